#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "support/fmu_importer.h"

/// Programs that call the functions of an FMU at random (tests/data/fmu/hostile.h), under the sanitizers.
namespace mimbre::test {

/// What the program `program`.c prints of 20000 calls of the FMU; empty: the compiler has no sanitizers.
/// `more`: definitions for that program.
inline std::string printed_by_hostile(const FmuCode& fmu, const std::string& program,
                                      const std::string& more) {
  const std::string folder = fmu_sources(fmu, program), version = std::to_string(fmu.version);
  const std::string compiler = "cc -std=c99 -g -O0 -fsanitize=address,undefined -fno-sanitize-recover=all ";
  if (std::system(("echo 'int main(void){return 0;}' > " + folder + "/probe.c && " + compiler + folder +
                   "/probe.c -o " + folder + "/probe > /dev/null 2>&1")
                      .c_str()) != 0)
    return "";
  const std::string data = MIMBRE_SOURCE_DIR "/tests/data/fmu";
  EXPECT_EQ(printed_by(compiler + "-DFMI=" + version + " -DWRAPPER='\"" + folder + "/fmi" + version +
                       ".c\"' -DTOKEN='\"" + fmu.token + "\"' " + more + " -I" + folder + " -I" + data + " " +
                       data + "/" + program + ".c " + folder + "/" + fmu.code.name + ".c -o " + folder +
                       "/hostile -lm"),
            "");
  return printed_by(folder + "/hostile 20000");
}

/// So that refusing everything does not pass: each function has succeeded but those that never can, and so
/// many per cent of all calls.
inline void expect_good_calls(const std::string& printed, long least, const std::set<int>& hopeless) {
  std::istringstream lines(printed);
  long share = -1;
  for (std::string line; std::getline(lines, line);) {
    int function = -1;
    long calls = 0;
    if (std::sscanf(line.c_str(), "function %d never", &function) == 1)
      EXPECT_TRUE(hopeless.contains(function)) << line;
    else
      EXPECT_EQ(std::sscanf(line.c_str(), "%ld calls, %ld %%", &calls, &share), 2) << line;
  }
  EXPECT_GE(share, least) << printed;
}

}  // namespace mimbre::test
