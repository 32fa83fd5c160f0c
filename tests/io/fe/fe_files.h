#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "io/fe/text_file.h"
#include "mimbre/diagnostics.h"

namespace mimbre::fe {

inline std::string data_file(const std::string& name) {
  return std::string(MIMBRE_SOURCE_DIR "/tests/data/") + name;
}

/// What the reader of a text says is wrong with it; empty when it is content.
template <class Read>
std::string complaint(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

/// A folder of the test's own, empty, removed afterwards.
class Folder {
 public:
  Folder() {
    static int count = 0;
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            (std::string("mimbre-") + test->test_suite_name() + "-" + test->name() + "-" +
             std::to_string(getpid()) + "-" + std::to_string(++count));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }

 private:
  std::filesystem::path path_;
};

}  // namespace mimbre::fe
