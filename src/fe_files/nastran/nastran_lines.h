#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fe_files/text_file.h"

namespace mimbre::fe {

/// Lines of a Nastran file and of the files that it includes.
class NastranLines {
 public:
  /// Of one text, in which INCLUDE is refused.
  explicit NastranLines(TextFile& file) : first_(&file) {}
  /// Of a file; INCLUDE names files by the folder of the file that includes them, else of the first one.
  explicit NastranLines(std::unique_ptr<TextFile> file);

  /// False at the end of the first file. `line` is valid until the next call.
  bool next(std::string_view& line);
  void put_back() { file().put_back(); }

  Mark mark() const { return file().mark(); }
  const std::vector<std::string>& included() const { return included_; }

 private:
  TextFile& file() const { return files_.empty() ? *first_ : *files_.back(); }
  bool is_include(std::string_view line) const;
  void include(std::string_view line);

  TextFile* first_ = nullptr;
  std::vector<std::unique_ptr<TextFile>> files_;
  std::vector<std::string> included_;
};

}  // namespace mimbre::fe
