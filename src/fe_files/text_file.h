#pragma once
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mimbre/diagnostics.h"

namespace mimbre::fe {

/// A text file, line by line through a buffer of a megabyte, so that size on disk is not size in memory; or a
/// text at hand (tests, fuzzing). Line ends may be \n or \r\n.
class TextFile {
 public:
  /// Throws InputError when the file cannot be opened.
  explicit TextFile(const std::string& path);
  TextFile(std::string text, std::string name);

  /// False at the end. `line` is valid until the next call. Throws InputError at bytes that no text has.
  bool next(std::string_view& line);
  /// The next line; at the end, InputError saying that the file ends within `what`.
  std::string_view expect(const char* what);
  /// Gives the current line once more by the next call of next().
  void put_back() { again_ = true; }

  const std::string& name() const { return name_; }
  int line_number() const { return line_number_; }
  Mark mark() const { return {name_, line_number_, 1}; }
  [[noreturn]] void fail(std::string message) const { throw InputError(mark(), std::move(message)); }

  // The number that the rest of a line begins with, taken off it; InputError says that `what` is missing, or
  // that the word is none.
  std::int64_t integer(std::string_view& rest, const char* what) const;
  double real(std::string_view& rest, const char* what) const;

 private:
  bool refill();

  std::string name_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::string_view line_;
  int line_number_ = 0;
  bool again_ = false;
};

/// All of a plain file. Throws InputError when it is none or cannot be read.
std::string read_bytes(const std::string& path);

}  // namespace mimbre::fe
