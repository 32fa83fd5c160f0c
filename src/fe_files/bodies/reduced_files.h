#pragma once
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

#include "base/output_place.h"
#include "fe_files/text_file.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

ImportedBody parse_mbdyn_fem(TextFile& file);
ImportedBody parse_sid(TextFile& file);

/// A text file that takes its name's place only when it is whole. Throws std::runtime_error when it cannot be
/// written.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  template <class... Values>
  void print(fmt::format_string<Values...> text, Values&&... values) {
    write(fmt::format(text, std::forward<Values>(values)...));
  }
  void write(const std::string& text);
  void finish();

 private:
  [[noreturn]] void fail(const std::string& why) const;

  std::string path_;
  OutputPlace place_;
  std::FILE* file_;
};

}  // namespace mimbre::fe
