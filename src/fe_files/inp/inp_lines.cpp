#include "fe_files/inp/inp_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "fe_files/text.h"

namespace mimbre::fe {

namespace {

std::string compact_capitals(std::string_view text) {
  std::string result;
  for (const char c : text)
    if (c != ' ' && c != '\t') result += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

std::string_view unquoted(std::string_view text) {
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return text;
}

bool is_include(std::string_view line) {
  const std::string name = compact_capitals(line.substr(1, line.find(',') - 1));
  return name == "INCLUDE";
}

}  // namespace

const std::string* InpKeyword::find(std::string_view parameter) const {
  // Blanks in names do not count, as in Abaqus: REF NODE and REFNODE.
  const auto packed = [](std::string_view text) {
    std::string out;
    for (const char c : text)
      if (c != ' ') out += c;
    return out;
  };
  for (const auto& [name_, value] : parameters)
    if (packed(name_) == packed(parameter)) return &value;
  return nullptr;
}

InpLines::InpLines(std::unique_ptr<TextFile> file, std::string folder, bool includes)
    : folder_(std::move(folder)), includes_(includes) {
  files_.push_back(std::move(file));
}

bool InpLines::next(std::string_view& line) {
  if (again_) {
    again_ = false;
    line = line_;
    return true;
  }
  while (true) {
    if (!files_.back()->next(line_)) {
      if (files_.size() == 1) return false;
      files_.pop_back();
      continue;
    }
    line_ = trimmed(line_);
    if (line_.empty() || line_.starts_with("**")) continue;
    line = line_;
    return true;
  }
}

bool InpLines::next_data(std::string_view& line) {
  while (next(line)) {
    if (!line.starts_with('*')) return true;
    if (!is_include(line)) {
      again_ = true;
      return false;
    }
    include(keyword_of(line));  // of data lines that go on with those of the other file
  }
  return false;
}

InpKeyword InpLines::keyword_of(std::string_view line) {
  InpKeyword keyword;
  keyword.mark = file().mark();
  std::string text(line);
  // A keyword line that ends with a comma goes on in the next line.
  while (text.ends_with(',') && next(line)) {
    if (line.starts_with('*')) {
      again_ = true;
      break;
    }
    text += line;
  }
  std::string_view rest = std::string_view(text).substr(1);
  // "NODE FILE" and "SOLID SECTION" keep one blank between their words.
  std::string_view name = next_field(rest);
  while (!name.empty()) {
    if (!keyword.name.empty()) keyword.name += ' ';
    keyword.name += compact_capitals(next_word(name));
    name = trimmed(name);
  }
  while (!rest.empty()) {
    std::string_view field = next_field(rest);
    if (field.empty()) continue;
    const std::size_t equals = field.find('=');
    const std::string_view value =
        equals == std::string_view::npos ? std::string_view() : trimmed(field.substr(equals + 1));
    keyword.parameters.emplace_back(compact_capitals(field.substr(0, equals)), unquoted(value));
  }
  return keyword;
}

bool InpLines::next_keyword(InpKeyword& keyword) {
  std::string_view line;
  while (next(line)) {
    if (!line.starts_with('*')) {
      if (!begun_)
        file().fail(fmt::format("'{}' stands before the first keyword (a line such as *NODE)", shown(line)));
      continue;
    }
    keyword = keyword_of(line);
    if (keyword.name != "INCLUDE") {
      begun_ = true;
      return true;
    }
    include(keyword);
  }
  return false;
}

void InpLines::include(const InpKeyword& keyword) {
  const std::string* input = keyword.find("INPUT");
  if (!input || input->empty()) file().fail("*INCLUDE needs a file: *INCLUDE, INPUT=mesh.inp");
  if (!includes_) file().fail("*INCLUDE is not allowed here");
  const std::string path = (std::filesystem::path(folder_) / *input).string();
  for (const auto& open : files_)
    if (same_file(open->name(), path)) file().fail(fmt::format("'{}' includes itself", shown(*input)));
  if (files_.size() >= kDeepestIncludes)
    file().fail(fmt::format("includes go more than {} files deep", kDeepestIncludes));
  if (!std::filesystem::exists(path)) file().fail(fmt::format("'{}' is not there to be included", path));
  files_.push_back(std::make_unique<TextFile>(path));
  included_.push_back(path);
}

}  // namespace mimbre::fe
