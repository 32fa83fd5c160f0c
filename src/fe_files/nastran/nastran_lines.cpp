#include "fe_files/nastran/nastran_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "fe_files/text.h"

// MSC Nastran Quick Reference Guide, "INCLUDE".

namespace mimbre::fe {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 4096;

}  // namespace

NastranLines::NastranLines(std::unique_ptr<TextFile> file) { files_.push_back(std::move(file)); }

bool NastranLines::is_include(std::string_view line) const {
  line = trimmed(line);
  constexpr std::string_view word = "include";
  if (line.size() <= word.size() || lower(line.substr(0, word.size())) != word) return false;
  const char next = line[word.size()];
  return next == ' ' || next == '\t' || next == '\'' || next == '"' || next == '=' || next == ',';
}

void NastranLines::include(std::string_view line) {
  const Mark start = mark();
  if (files_.empty()) throw InputError(start, "INCLUDE is not allowed here");
  std::string name(trimmed(trimmed(line).substr(7)));
  if (name.starts_with('=') || name.starts_with(',')) name = trimmed(name.substr(1));
  if (name.starts_with('\'') || name.starts_with('"')) {
    // A long name goes on in the next lines, up to its second quotation mark.
    const char quote = name.front();
    name.erase(0, 1);
    std::size_t end = name.find(quote);
    std::string_view more;
    while (end == std::string::npos) {
      if (name.size() > kLongestName || !file().next(more))
        throw InputError(start, "the name of the included file has no second quotation mark");
      name += trimmed(more);
      end = name.find(quote);
    }
    name.resize(end);
    name = trimmed(name);
  } else {
    name = trimmed(std::string_view(name).substr(0, name.find('$')));
  }
  if (name.empty()) throw InputError(start, "INCLUDE needs a file: INCLUDE 'mesh.bdf'");
  std::replace(name.begin(), name.end(), '\\', '/');
  std::string path;
  for (const auto& by : {files_.back()->name(), files_.front()->name()}) {
    path = (fs::path(by).parent_path() / name).string();
    std::error_code ignored;
    if (fs::exists(path, ignored)) break;
    path.clear();
  }
  if (path.empty()) throw InputError(start, fmt::format("'{}' is not there to be included", shown(name)));
  for (const auto& open : files_)
    if (same_file(open->name(), path))
      throw InputError(start, fmt::format("'{}' includes itself", shown(name)));
  if (files_.size() >= kDeepestIncludes)
    throw InputError(start, fmt::format("includes go more than {} files deep", kDeepestIncludes));
  files_.push_back(std::make_unique<TextFile>(path));
  included_.push_back(path);
}

bool NastranLines::next(std::string_view& line) {
  while (true) {
    if (!file().next(line)) {
      if (files_.size() <= 1) return false;
      files_.pop_back();
      continue;
    }
    if (!is_include(line)) return true;
    include(line);
  }
}

}  // namespace mimbre::fe
