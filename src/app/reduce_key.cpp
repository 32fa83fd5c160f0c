#include "app/reduce_key.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "app/common.h"
#include "mimbre/build.h"
#include "mimbre/fe_import.h"
#include "mimbre/result_cache.h"

namespace mimbre::app {
namespace {

namespace fs = std::filesystem;

/// A file of any kind, pipes among them.
bool is_file(const fs::path& path) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  return fs::exists(status) && !fs::is_directory(status);
}

/// The part of an option's value that is the name of a file, as in FILE, ball=nodes:FILE,
/// push=nodes:FILE,0,0,1; empty when none is.
std::string_view file_in(std::string_view value) {
  for (std::size_t begin = 0; begin < value.size();) {
    for (std::size_t end = value.size(); end != std::string_view::npos && end > begin;
         end = value.rfind(',', end - 1))
      if (const auto part = value.substr(begin, end - begin); is_file(part)) return part;
    const std::size_t mark = value.find_first_of("=:", begin);
    if (mark == std::string_view::npos) break;
    begin = mark + 1;
  }
  return {};
}

/// A file counts by its format and its bytes, not by its name. False when it can be read only once, as a
/// pipe.
bool add_value(std::string_view value, ContentKey& key) {
  const std::string_view file = file_in(value);
  if (file.empty()) {
    key.add(value);
    return true;
  }
  const std::size_t begin = static_cast<std::size_t>(file.data() - value.data());
  key.add(value.substr(0, begin));
  key.add(value.substr(begin + file.size()));
  const fs::path path(file);
  if (!fs::is_regular_file(path)) return false;
  std::string format = path.extension().string();
  std::transform(format.begin(), format.end(), format.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  key.add(format);
  // Without an ending it may be the name of a set that a file happens to have too.
  if (format.empty()) key.add(file);
  key.add_file(path);
  for (const std::string& neighbour : fe::files_beside(path.string())) key.add_file(neighbour);
  return true;
}

}  // namespace

std::string reduction_key(const Parser& command, const std::string& name,
                          const std::vector<std::string>& without) {
  ContentKey key;
  key.add(build_info().version);
  key.add(name);
  key.add_program();
  try {
    for (const auto& [option, values] : command.given()) {
      if (std::find(without.begin(), without.end(), option) != without.end()) continue;
      key.add(option);
      for (const std::string& value : values)
        if (!add_value(value, key)) return {};
    }
  } catch (const InputError&) {
    return {};
  }
  return key.hex();
}

}  // namespace mimbre::app
