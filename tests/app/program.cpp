#include "app/program.h"

#include "mimbre/results.h"
#include "support/clocked.h"

namespace mimbre::app_test {

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void write_file(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::string program_path() {
  const char* const given = std::getenv("MIMBRE_PROGRAM");
  return given ? given : MIMBRE_PROGRAM;
}

double cpu_seconds(pid_t child) {
  clockid_t clock{};
  timespec time{};
  EXPECT_EQ(clock_getcpuclockid(child, &clock), 0);
  EXPECT_EQ(clock_gettime(clock, &time), 0);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void ProgramTest::SetUp() {
  std::string name = (fs::temp_directory_path() / "mimbre-app-XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  folder = name;
  // Not the user's own cache.
  setenv("MIMBRE_CACHE", (folder / "cache").c_str(), 1);
}

void ProgramTest::TearDown() {
  // Of a test that gave up.
  for (const pid_t child : running_) {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
}

pid_t ProgramTest::start(const std::vector<std::string>& arguments,
                         const std::function<void()>& prepare) const {
  std::vector<char*> argv{const_cast<char*>("mimbre")};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const std::string path = program_path();
  const pid_t child = fork();
  if (child > 0) running_.insert(child);
  if (child != 0) return child;
  if (chdir(folder.c_str()) != 0) _exit(126);
  const int out = open("out.txt", O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int err = open("err.txt", O_WRONLY | O_CREAT | O_TRUNC, 0600);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  // As from a terminal, even where the tests run under nohup. What never ends shall not fill the disk.
  for (const int of : {SIGHUP, SIGINT, SIGTERM}) signal(of, SIG_DFL);
  const rlimit limit{600, 600};
  setrlimit(RLIMIT_CPU, &limit);
  if (prepare) prepare();
  execv(path.c_str(), argv.data());
  _exit(127);
}

Outcome ProgramTest::wait_for(pid_t child) const {
  int status = 0;
  waitpid(child, &status, 0);
  running_.erase(child);
  Outcome outcome;
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  outcome.out = read_file(folder / "out.txt");
  outcome.err = read_file(folder / "err.txt");
  return outcome;
}

bool ProgramTest::has_rows(const fs::path& file, std::int64_t count) const {
  return test::comes_true([&] {
    try {
      return fs::exists(file) && read_results(file.string()).time.size() >= count;
    } catch (const std::exception&) {  // it is just being begun
      return false;
    }
  });
}

bool ProgramTest::appears(const fs::path& file) const {
  return test::comes_true([&] { return fs::exists(file); });
}

Outcome ProgramTest::run(const std::vector<std::string>& arguments,
                         const std::function<void()>& prepare) const {
  return wait_for(start(arguments, prepare));
}

std::vector<std::vector<double>> csv_rows(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace mimbre::app_test
