#include "fe_files/text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "fe_files/text.h"

namespace mimbre::fe {

namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;
/// No line of a text file is longer; a binary file may have no line end at all.
constexpr std::size_t kLongestLine = std::size_t{16} << 20;

/// Opened, when it is a plain file. Others are not even opened: a pipe would wait for its writer, a device
/// may have no end.
std::FILE* open_plain(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  if (fs::is_directory(status)) throw InputError({path, 0, 0}, "is a folder, not a file");
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw InputError({path, 0, 0}, "is a pipe or a device; a plain file is needed");
  std::FILE* const file = std::fopen(path.c_str(), "rb");
  if (!file) throw InputError({path, 0, 0}, fmt::format("cannot be opened: {}", std::strerror(errno)));
  return file;
}

}  // namespace

TextFile::TextFile(const std::string& path)
    : name_(path), file_(open_plain(path), std::fclose), buffer_(kChunk) {}

TextFile::TextFile(std::string text, std::string name)
    : name_(std::move(name)),
      file_(nullptr, std::fclose),
      buffer_(text.begin(), text.end()),
      end_(text.size()) {}

bool TextFile::refill() {
  if (!file_) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ == buffer_.size()) {
    if (buffer_.size() >= kLongestLine)
      fail(fmt::format("has a line of more than {} MB: not a text file", kLongestLine >> 20));
    buffer_.resize(buffer_.size() * 2);
  }
  const std::size_t count = std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_.get());
  if (count == 0 && std::ferror(file_.get())) fail(fmt::format("cannot be read: {}", std::strerror(errno)));
  end_ += count;
  return count > 0;
}

bool TextFile::next(std::string_view& line) {
  if (again_) {
    again_ = false;
    line = line_;
    return true;
  }
  std::size_t searched = begin_;
  const char* found = nullptr;
  while (true) {
    found = end_ > searched
                ? static_cast<const char*>(std::memchr(buffer_.data() + searched, '\n', end_ - searched))
                : nullptr;
    if (found) break;
    const std::size_t waiting = end_ - begin_;
    if (!refill()) break;
    searched = begin_ + waiting;
  }
  if (!found && begin_ == end_) return false;
  const char* first = buffer_.data() + begin_;
  const char* last = found ? found : buffer_.data() + end_;
  begin_ = found ? static_cast<std::size_t>(found - buffer_.data()) + 1 : end_;
  ++line_number_;
  line_ = {first, static_cast<std::size_t>(last - first)};
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  if (line_number_ == 1) {
    if (line_.starts_with("\xef\xbb\xbf")) line_.remove_prefix(3);
    if (line_.find('\r') != std::string_view::npos)
      fail("ends its lines with CR alone; save it with LF or CR LF");
  }
  if (line_.find('\0') != std::string_view::npos) fail("holds zero bytes: not a text file");
  line = line_;
  return true;
}

std::string_view TextFile::expect(const char* what) {
  std::string_view line;
  if (!next(line)) fail(fmt::format("ends within {}", what));
  return line;
}

namespace {
[[noreturn]] void fail_without(const TextFile& file, std::string_view word, const char* what) {
  file.fail(word.empty() ? fmt::format("{} is missing", what)
                         : fmt::format("'{}' is no {}", shown(word), what));
}
}  // namespace

std::int64_t TextFile::integer(std::string_view& rest, const char* what) const {
  const std::string_view word = next_word(rest);
  const auto value = to_integer(word);
  if (!value) fail_without(*this, word, what);
  return *value;
}

double TextFile::real(std::string_view& rest, const char* what) const {
  const std::string_view word = next_word(rest);
  const auto value = to_real(word);
  if (!value) fail_without(*this, word, what);
  return *value;
}

std::string read_bytes(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open_plain(path), std::fclose);
  std::string bytes, chunk(kChunk, '\0');
  while (const std::size_t count = std::fread(chunk.data(), 1, chunk.size(), file.get()))
    bytes.append(chunk, 0, count);
  if (std::ferror(file.get()))
    throw InputError({path, 0, 0}, fmt::format("cannot be read: {}", std::strerror(errno)));
  return bytes;
}

}  // namespace mimbre::fe
