#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mimbre::app {

/// A model file that is built into the program: its path below examples/, and its text.
struct ExampleFile {
  std::string_view name, text;
};
const std::vector<ExampleFile>& embedded_examples();

/// The built-in models as files, because they include each other, in a folder that goes with this object.
class ExampleFolder {
 public:
  /// Throws Failure when the folder for temporary files cannot be written.
  ExampleFolder();
  ~ExampleFolder();
  ExampleFolder(const ExampleFolder&) = delete;
  ExampleFolder& operator=(const ExampleFolder&) = delete;
  /// Path of a file by its name below examples/.
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_;
};

}  // namespace mimbre::app
