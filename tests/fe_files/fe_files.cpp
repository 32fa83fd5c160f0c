#include "fe_files/fe_files.h"

namespace mimbre::fe {

std::string data_file(const std::string& name) {
  return std::string(MIMBRE_SOURCE_DIR "/tests/data/") + name;
}

std::string complaint(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

Folder::Folder() {
  static int count = 0;
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  path_ = std::filesystem::temp_directory_path() /
          (std::string("mimbre-") + test->test_suite_name() + "-" + test->name() + "-" +
           std::to_string(getpid()) + "-" + std::to_string(++count));
  std::filesystem::remove_all(path_);
  std::filesystem::create_directories(path_);
}
Folder::~Folder() { std::filesystem::remove_all(path_); }
std::string Folder::path(const std::string& name) const { return (path_ / name).string(); }
std::string Folder::write(const std::string& name, const std::string& text) const {
  std::ofstream(path(name), std::ios::binary) << text;
  return path(name);
}

}  // namespace mimbre::fe
