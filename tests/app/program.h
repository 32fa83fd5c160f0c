#pragma once
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

/// Runs the program as a user does, in a folder of its own.
namespace mimbre::app_test {

namespace fs = std::filesystem;

inline std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void write_file(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

struct Outcome {
  int code = -1;  ///< exit code; -1 when a signal ended the program
  int signal = 0;
  std::string out, err;
  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

/// A folder that goes when the test ends; the program runs in it.
class ProgramTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "mimbre-app-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder = name;
    // Not the user's own cache.
    setenv("MIMBRE_CACHE", (folder / "cache").c_str(), 1);
  }
  void TearDown() override {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }

  /// Starts the program; `prepare` runs in the new process before it.
  pid_t start(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const {
    std::vector<char*> argv{const_cast<char*>("mimbre")};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    const pid_t child = fork();
    if (child != 0) return child;
    if (chdir(folder.c_str()) != 0) _exit(126);
    const int out = open("out.txt", O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int err = open("err.txt", O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    if (prepare) prepare();
    execv(MIMBRE_PROGRAM, argv.data());
    _exit(127);
  }

  Outcome wait_for(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    Outcome outcome;
    if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
    outcome.out = read_file(folder / "out.txt");
    outcome.err = read_file(folder / "err.txt");
    return outcome;
  }

  Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const {
    return wait_for(start(arguments, prepare));
  }

  fs::path folder;
};

/// A body on a hinge with the axis y: the angle is zero when it points along x, and it hangs at pi/2.
inline const std::string pendulum = R"(mimbre: 1
title: A pendulum
parameters:
  length: 1.5
  interval: {value: 0.01}
bodies:
  bob: {mass: 2, com: [length, 0, 0], inertia: [0.1, 0.1, 0.1]}
joints:
  hinge: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}
outputs:
  - {name: angle, joint: hinge}
  - {name: bob.z, position: bob, component: z}
simulation: {step: 0.01, end: 1, output_interval: interval}
)";

/// The numbers of a CSV file by rows, without the heading.
inline std::vector<std::vector<double>> csv_rows(const fs::path& path) {
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
