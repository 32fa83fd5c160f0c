#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fe_files/text_file.h"

namespace mimbre::fe {

/// A line that begins with one star: its keyword in capitals, and what stands behind the commas.
struct InpKeyword {
  std::string name;
  std::vector<std::pair<std::string, std::string>> parameters;  ///< names in capitals, values as written
  Mark mark;

  /// Null when there is no such parameter; without "=" the value is empty.
  const std::string* find(std::string_view parameter) const;
};

/// Lines of an .inp file and of what it includes, without comments and blank lines.
class InpLines {
 public:
  /// `folder`: where included files are; none are allowed when `includes` is false.
  InpLines(std::unique_ptr<TextFile> file, std::string folder, bool includes);

  /// The next keyword; lines of data before it are skipped. Opens what *INCLUDE names. False at the end.
  bool next_keyword(InpKeyword& keyword);
  /// The next line of data of the current keyword, through files that *INCLUDE names amid them; false before
  /// the next keyword and at the end.
  bool next_data(std::string_view& line);

  TextFile& file() { return *files_.back(); }
  /// Paths of the files included so far.
  const std::vector<std::string>& included() const { return included_; }

 private:
  bool next(std::string_view& line);
  InpKeyword keyword_of(std::string_view line);
  void include(const InpKeyword& keyword);

  std::vector<std::unique_ptr<TextFile>> files_;
  std::string folder_;
  bool includes_;
  std::string_view line_;
  bool again_ = false;
  bool begun_ = false;  ///< a keyword was there
  std::vector<std::string> included_;
};

}  // namespace mimbre::fe
