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
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "support/json.h"

/// Runs the program as a user does, in a folder of its own.
namespace mimbre::app_test {

namespace fs = std::filesystem;

std::string read_file(const fs::path& path);

void write_file(const fs::path& path, const std::string& text);

/// Of a program that runs.
double cpu_seconds(pid_t child);

struct Outcome {
  int code = -1;  ///< exit code; -1 when a signal ended the program
  int signal = 0;
  std::string out, err;
  test::Json json() const { return test::Json::parse(out); }
};

/// The program that is tested: MIMBRE_PROGRAM in the environment, else the one of this build.
std::string program_path();

/// A folder that goes when the test ends, as do programs that still run; the program runs in it.
class ProgramTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  /// Starts the program; `prepare` runs in the new process before it.
  pid_t start(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const;
  Outcome wait_for(pid_t child) const;
  /// Until the results of a program that runs have so many rows: how long that takes is the machine's affair.
  /// False where it gives up.
  bool has_rows(const fs::path& file, std::int64_t count) const;
  /// Until there is such a file; likewise.
  bool appears(const fs::path& file) const;
  Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const;

  fs::path folder;

 private:
  mutable std::set<pid_t> running_;  ///< started and not waited for
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
std::vector<std::vector<double>> csv_rows(const fs::path& path);

}  // namespace mimbre::app_test
