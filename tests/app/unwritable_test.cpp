#include <gmock/gmock.h>
#include <sys/mount.h>

#include <sched.h>
#include <cerrno>
#include <cstring>
#include <map>

#include "app/program.h"

/// Every command that writes, with every way in which it cannot: the older output stands as it was, nothing
/// is left beside it, and the program says what is wrong, once and by exit code 3.
namespace mimbre::app_test::unwritable_test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// What makes a file, or a folder of files, in the folder `out`.
struct Making {
  std::vector<std::string> command;
  std::string output;
  bool folder = false;
};

/// Of all files below a folder, by their paths; folders have no content.
using Snapshot = std::map<std::string, std::string>;
Snapshot snapshot(const fs::path& folder) {
  Snapshot result;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    result[entry.path().lexically_relative(folder).string()] =
        entry.is_regular_file() ? read_file(entry.path()) : "";
  return result;
}

class Unwritable : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(run(reduction("arm.h5")).signal, 0);
    ASSERT_TRUE(fs::exists(folder / "arm.h5"));
    write_file(folder / "swing.yaml", R"(mimbre: 1
bodies:
  arm: {reduced: arm.h5, frame: {at: [0, 0, 0]}}
joints:
  hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}
outputs:
  - {name: angle, joint: hinge}
simulation: {step: 0.001, end: 0.02}
)");
    ASSERT_EQ(run({"run", "swing.yaml", "-o", "swing.h5", "-q"}).code, 0);
    ASSERT_EQ(run({"convert", "arm.h5", "--to", "fem", "-o", "arm.fem"}).code, 0);
    fs::create_directory(out());
  }

  fs::path out() const { return folder / "out"; }

  static std::vector<std::string> reduction(const std::string& output) {
    return {"reduce",      MIMBRE_SOURCE_DIR "/tests/data/gmsh/block-22.msh",
            "--material",  "2.1e11,0.3,7850",
            "--interface", "left=group:left",
            "--modes",     "2",
            "--no-cache",  "-o",
            output};
  }

  static std::vector<Making> makings() {
    std::vector<std::string> reported = reduction("other.h5");
    reported.insert(reported.end(), {"--report", "out/modes.html"});
    return {
        {{"run", "swing.yaml", "-q", "-o", "out/a.h5"}, "a.h5"},
        {{"run", "swing.yaml", "-q", "--until", "0.2", "--csv", "out/a.csv"}, "a.csv"},
        {reduction("out/b.h5"), "b.h5"},
        {reported, "modes.html"},
        {{"select", "swing.yaml", "--body", "arm", "--error", "50", "-o", "out/c.h5"}, "c.h5"},
        {{"convert", "arm.h5", "--to", "fem", "-o", "out/b.fem"}, "b.fem"},
        {{"convert", "arm.h5", "--to", "sid", "-o", "out/b.sid"}, "b.sid"},
        {{"convert", "arm.fem", "--to", "h5", "-o", "out/b.h5"}, "b.h5"},
        {{"report", "swing.h5", "-o", "out/a.html"}, "a.html"},
        {{"report", "swing.h5", "swing.h5", "-o", "out/a.html"}, "a.html"},
        {{"report", "arm.h5", "-o", "out/a.html"}, "a.html"},
        {{"export", "swing.h5", "--vtk", "out/frames"}, "frames", true},
    };
  }

  void put_older(const Making& making) const {
    const fs::path target = out() / making.output;
    if (!making.folder) return write_file(target, "older");
    fs::create_directory(target);
    write_file(target / "run.pvd", "older");
    write_file(target / "arm_00000.vtp", "older");
    write_file(target / "notes.txt", "not of an export");
  }

  /// The command ends so, and changes nothing in `out`.
  void changes_nothing(const Making& making, const std::string& why, const std::function<void()>& prepare) {
    const Snapshot before = snapshot(out());
    const Outcome outcome = run(making.command, prepare);
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_EQ(outcome.signal, 0);
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("mimbre: error: cannot write "),
                                   AnyOf(HasSubstr(making.output), HasSubstr("other.h5")), HasSubstr(why),
                                   Not(HasSubstr("HDF5")), Not(HasSubstr("part-"))));
    EXPECT_EQ(error_lines(outcome.err), 1) << outcome.err;
    EXPECT_TRUE(snapshot(out()) == before);
  }

  /// Of the bodies' own certificates there may be warnings.
  static int error_lines(const std::string& text) {
    int count = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) count += line.find("error:") != std::string::npos;
    return count;
  }

  /// All commands, over an older output and without one.
  void nothing_is_changed_where(const std::string& why, const std::function<void()>& prepare,
                                const std::function<void()>& refill = {}) {
    for (const Making& making : makings())
      for (const bool older : {false, true}) {
        SCOPED_TRACE(making.command[0] + ' ' + making.output + (older ? " over an older one" : ""));
        for (const auto& entry : fs::directory_iterator(out())) fs::remove_all(entry.path());
        if (older) put_older(making);
        if (refill) refill();
        changes_nothing(making, why, prepare);
      }
  }
};

TEST_F(Unwritable, AllIsWellWhereItIsWritable) {
  for (const Making& making : makings()) {
    SCOPED_TRACE(making.command[0] + ' ' + making.output);
    put_older(making);
    const Outcome outcome = run(making.command);
    EXPECT_THAT(outcome.code, AnyOf(0, 4)) << outcome.err;
    const fs::path made = out() / making.output / (making.folder ? "run.pvd" : "");
    EXPECT_NE(read_file(making.folder ? made : out() / making.output), "older");
    if (making.folder) {
      EXPECT_EQ(read_file(out() / "frames/notes.txt"), "not of an export");
    }
    fs::remove_all(out() / making.output);
    EXPECT_TRUE(fs::is_empty(out()));
  }
}

/// A limit on the size of files, as quotas are, within the first bytes and later.
TEST_F(Unwritable, BeyondALimitOnTheSizeOfFiles) {
  for (const rlim_t room : {300, 2000})
    nothing_is_changed_where("File too large", [room] {
      const rlimit limit{room, room};
      setrlimit(RLIMIT_FSIZE, &limit);
    });
}

/// Mounts that only this process and its children see. False where that may not be.
bool own_mounts() {
  return unshare(CLONE_NEWNS) == 0 && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
}

TEST_F(Unwritable, InAFolderThatCanOnlyBeRead) {
  const std::string place = out().string();
  const auto read_only = [place] {
    if (!own_mounts() || mount(place.c_str(), place.c_str(), nullptr, MS_BIND, nullptr) != 0 ||
        mount("none", place.c_str(), nullptr, MS_REMOUNT | MS_BIND | MS_RDONLY, nullptr) != 0)
      _exit(99);
  };
  if (run({"--version"}, read_only).code == 99) GTEST_SKIP() << "no mounts here: " << std::strerror(errno);
  nothing_is_changed_where("Read-only file system", read_only);
}

TEST_F(Unwritable, InAFolderThatIsNotThere) {
  fs::remove(out());
  fs::create_directory(folder / "no");
  for (Making making : makings()) {
    if (making.folder) continue;  // it is made
    SCOPED_TRACE(making.command[0] + ' ' + making.output);
    const Outcome outcome = run(making.command);
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, HasSubstr(making.output + "': No such file or directory"));
  }
  const Outcome below_a_file = run({"export", "swing.h5", "--vtk", "swing.h5/frames"});
  EXPECT_EQ(below_a_file.code, 3);
  EXPECT_THAT(below_a_file.err, HasSubstr("cannot write 'swing.h5/frames': Not a directory"));
}

/// HDF5 goes back and forth in its files.
TEST_F(Unwritable, WhereAPlainFileIsNeeded) {
  for (const std::vector<std::string>& command :
       {reduction("/dev/null"),
        {"run", "swing.yaml", "-q", "-o", "/dev/null"},
        {"convert", "arm.fem", "--to", "h5", "-o", "/dev/null"},
        {"select", "swing.yaml", "--body", "arm", "-o", "/dev/null"}}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.code, 3) << command[0];
    EXPECT_THAT(outcome.err, HasSubstr("'/dev/null': it is not a plain file")) << command[0];
  }
}

/// Root as everyone else.
TEST_F(Unwritable, WhereTheSystemTakesNoFiles) {
  if (!fs::is_directory("/proc/self")) GTEST_SKIP() << "there is no /proc";
  for (Making making : makings()) {
    SCOPED_TRACE(making.command[0] + ' ' + making.output);
    for (std::string& word : making.command)
      if (word.starts_with("out/")) word = "/proc/" + making.output;
    changes_nothing(making, "/proc/", {});
  }
}

TEST_F(Unwritable, OnAFullDisk) {
  if (!own_mounts() || mount("none", out().c_str(), "tmpfs", 0, "size=512k") != 0)
    GTEST_SKIP() << "no mounts here: " << std::strerror(errno);
  nothing_is_changed_where("No space left on device", {}, [&] {
    std::ofstream(out() / "filler", std::ios::binary) << std::string(1 << 20, 'x');
    ASSERT_EQ(fs::space(out()).available, 0);
  });
  umount2(out().c_str(), MNT_DETACH);
}

/// Whenever the folder goes, the older output in it is whole or the new one is.
TEST_F(Unwritable, InAFolderThatVanishesMeanwhile) {
  for (const Making& making : makings())
    for (const int milliseconds : {5, 20}) {
      SCOPED_TRACE(making.command[0] + ' ' + making.output + ", after ms: " + std::to_string(milliseconds));
      fs::remove_all(out());
      fs::remove_all(folder / "gone");
      fs::create_directory(out());
      put_older(making);
      const Snapshot before = snapshot(out());
      const pid_t child = start(making.command);
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      fs::rename(out(), folder / "gone");
      const Outcome outcome = wait_for(child);
      EXPECT_THAT(outcome.code, AnyOf(0, 3, 4)) << outcome.err;
      const Snapshot after = snapshot(folder / "gone");
      bool whole = true;
      for (const auto& [name, content] : before)
        whole = whole && after.contains(name) && after.at(name) == content;
      // A folder is made anew, with those above it.
      if (!making.folder) {
        EXPECT_EQ(whole, outcome.code == 3) << outcome.err;
      }
      if (outcome.code == 3) {
        EXPECT_TRUE(whole);
        EXPECT_THAT(outcome.err, HasSubstr("mimbre: error: cannot write "));
        EXPECT_EQ(error_lines(outcome.err), 1) << outcome.err;
      }
    }
}

/// The same for what goes to the standard output, of every command.
TEST_F(Unwritable, OnAFullStandardOutput) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  ASSERT_EQ(run({"run", "swing.yaml", "-q", "-o", "other.h5", "--step", "0.002"}).code, 0);
  std::vector<std::vector<std::string>> commands{
      {"--help"},
      {"--version"},
      {"run", "--help"},
      {"run", "swing.yaml"},
      {"run", "swing.yaml", "-q", "--json"},
      {"check", "swing.yaml"},
      {"check", "swing.yaml", "--json"},
      {"static", "swing.yaml"},
      {"static", "swing.yaml", "--json"},
      {"stress", "swing.h5"},
      {"stress", "swing.h5", "--json"},
      {"compare", "swing.h5", "other.h5"},
      {"compare", "swing.h5", "other.h5", "--json"},
      {"verify", "swing.yaml"},
      {"bench", "swing.yaml", "--runs", "1"},
      {"reproduce", "--list"},
      {"reproduce", "--list", "--json"},
  };
  for (const Making& making : makings())
    if (making.command[0] != "run") commands.push_back(making.command);
  for (const auto& command : commands) {
    const Outcome outcome = run(command, [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); });
    EXPECT_EQ(outcome.code, 3) << command[0];
    EXPECT_THAT(outcome.err, HasSubstr("error: cannot write to the standard output: No space left on device"))
        << command[0];
    EXPECT_EQ(error_lines(outcome.err), 1) << command[0] << outcome.err;
  }
}

}  // namespace
}  // namespace mimbre::app_test::unwritable_test
