#include <gmock/gmock.h>
#include <poll.h>
#include <sys/ioctl.h>

#include <cstdlib>

#include "app/program.h"

/// What takes long says so on a terminal, and ends by Ctrl-C there.
namespace mimbre::app_test::terminal_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Rigid bodies in a row, each on a hinge.
std::string chain(int bodies, const std::string& formulation) {
  std::ostringstream model;
  model << "mimbre: 1\nbodies:\n";
  for (int k = 0; k < bodies; ++k)
    model << "  b" << k << ": {mass: 1, com: [" << k + 0.5 << ", 0, 0], inertia: [0.01, 0.1, 0.1]}\n";
  model << "joints:\n";
  for (int k = 0; k < bodies; ++k)
    model << "  j" << k << ": {type: revolute, between: ["
          << (k > 0 ? "b" + std::to_string(k - 1) : std::string("ground")) << ", b" << k << "], at: [" << k
          << ", 0, 0], axis: [0, 1, 0]}\n";
  model << "outputs: [{name: angle, joint: j0}]\nsimulation: {step: 0.001, end: 0.01, formulation: "
        << formulation << "}\n";
  return model.str();
}

/// A beam of so many elements that follow any deflection, held at both ends.
std::string beam(int elements) {
  return "mimbre: 1\nmaterials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\n"
         "sections: {round: {type: round, diameter: 0.01}}\nbodies:\n  bar:\n    frame: {at: [0, 0, 0]}\n"
         "    flexible: {material: steel, section: round, nodes: {a: [0, 0, 0], b: [1, 0, 0]}, "
         "bars: {ab: {from: a, to: b, elements: " +
         std::to_string(elements) +
         "}}, clamped: [a], beam: corotational}\n"
         "joints:\n  h: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}\n"
         "  e: {type: pin_slot, between: [ground, bar], at: [1, 0, 0], axis: [0, 1, 0], axis2: [1, 0, 0]}\n"
         "outputs: [{name: a, joint: h}]\nsimulation: {step: 0.01, end: 0.01}\n";
}

/// Of all programs that were waited for.
double cpu_seconds_of_ended() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// The program's standard error is a terminal, in which it is the foreground.
class Terminal : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    setenv("TERM", "xterm", 1);
    keyboard_ = posix_openpt(O_RDWR | O_NOCTTY);
    if (keyboard_ < 0 || grantpt(keyboard_) != 0 || unlockpt(keyboard_) != 0)
      GTEST_SKIP() << "there are no terminals here";
    const char* const name = ptsname(keyboard_);
    screen_ = open(name, O_RDWR | O_NOCTTY);
    ASSERT_GE(screen_, 0) << name;
  }
  void TearDown() override {
    close(screen_);
    close(keyboard_);
    ProgramTest::TearDown();
  }

  pid_t start_in_terminal(const std::vector<std::string>& arguments) const {
    return start(arguments, [screen = screen_] {
      setsid();
      if (ioctl(screen, TIOCSCTTY, 0) != 0 || dup2(screen, STDERR_FILENO) < 0) _exit(126);
    });
  }

  /// What the terminal has shown when this is in it, or after some seconds. `after`: only behind that.
  std::string shown_until(const std::string& text, int seconds = 300, const std::string& after = "") const {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(seconds);
    std::string shown;
    const auto is_there = [&] {
      const std::size_t from = shown.find(after);
      return from != std::string::npos && shown.find(text, from) != std::string::npos;
    };
    while (!is_there() && Clock::now() < end) {
      pollfd reading{keyboard_, POLLIN, 0};
      char part[4096];
      if (poll(&reading, 1, 100) <= 0) continue;
      const ssize_t count = read(keyboard_, part, sizeof part);
      if (count > 0) shown.append(part, static_cast<std::size_t>(count));
    }
    return shown;
  }

  void set_columns(unsigned short columns) const {
    const winsize size{.ws_row = 24, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
    ASSERT_EQ(ioctl(screen_, TIOCSWINSZ, &size), 0);
  }

  void press_ctrl_c() const { ASSERT_EQ(write(keyboard_, "\x03", 1), 1); }

  int keyboard_ = -1, screen_ = -1;
};

TEST_F(Terminal, LongWorkSaysWhatItDoesAndEndsByCtrlC) {
  write_file(folder / "beam.yaml", beam(2000));
  write_file(folder / "chain.yaml", chain(2000, "natural"));
  const std::pair<std::vector<std::string>, const char*> works[] = {
      {{"check", "beam.yaml"}, "assembling the mechanism … "},
      {{"run", "beam.yaml"}, "assembling the mechanism … "},
      {{"static", "chain.yaml"}, "looking for the equilibrium … "},
  };
  for (const auto& [command, words] : works) {
    SCOPED_TRACE(command[0]);
    const pid_t child = start_in_terminal(command);
    // The first second may be over before it is told.
    const std::string shown = shown_until(" s (Ctrl-C stops it)", 300, words);
    EXPECT_THAT(shown, testing::ContainsRegex(std::string(words) + "[0-9]+ s [(]Ctrl-C stops it[)]"));
    const double at_work = cpu_seconds(child), by_others = cpu_seconds_of_ended();
    press_ctrl_c();
    EXPECT_EQ(wait_for(child).signal, SIGINT);
    EXPECT_LT(cpu_seconds_of_ended() - by_others - at_work, 5);
  }
}

TEST_F(Terminal, TheLineFitsIntoANarrowOne) {
  write_file(folder / "pendulum.yaml", pendulum);
  set_columns(24);
  const pid_t child = start_in_terminal({"run", "pendulum.yaml", "--until", "1e5"});
  const std::string shown = shown_until("[##");
  press_ctrl_c();
  EXPECT_EQ(wait_for(child).code, 3);
  ASSERT_THAT(shown, HasSubstr("[##"));
  std::istringstream lines(shown);
  for (std::string line; std::getline(lines, line, '\r');)
    EXPECT_LT(line.substr(0, line.find('\033')).size(), 24) << line;
}

TEST_F(Terminal, OneThatCannotGoBackGetsNoLine) {
  write_file(folder / "pendulum.yaml", pendulum);
  setenv("TERM", "dumb", 1);
  const pid_t child = start_in_terminal({"run", "pendulum.yaml", "--until", "2000"});
  EXPECT_EQ(wait_for(child).code, 0);
  EXPECT_THAT(shown_until("\033", 1), Not(HasSubstr("\r\033")));
}

using LongWork = ProgramTest;

/// A thousand bodies in a row took 80 s to be checked, in relative coordinates, and more in natural ones.
TEST_F(LongWork, LongChainsAreCheckedInSeconds) {
  for (const char* formulation : {"relative", "natural"}) {
    write_file(folder / "chain.yaml", chain(1000, formulation));
    const Outcome outcome = run({"check", "chain.yaml"}, [] {
      const rlimit limit{30, 30};
      setrlimit(RLIMIT_CPU, &limit);
    });
    EXPECT_EQ(outcome.code, 0) << formulation << outcome.signal << outcome.err;
  }
}

}  // namespace
}  // namespace mimbre::app_test::terminal_test
