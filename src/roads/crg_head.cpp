#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "fe_files/text.h"
#include "roads/crg_file.h"

namespace mimbre::roads {

using fe::lower;
using fe::shown;
using fe::trimmed;

bool Lines::next(std::string_view& line) {
  if (next_byte >= bytes.size()) return false;
  const std::size_t end = std::min(bytes.find('\n', next_byte), bytes.size());
  line = bytes.substr(next_byte, end - next_byte);
  next_byte = end + 1;
  ++number;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

namespace {

constexpr std::size_t most_columns = 100000;
/// Reference lines are measured in thousands of km at most.
constexpr double largest_number = 1e9;

const std::set<std::string>& known_keys() {
  static const std::set<std::string> keys{
      "reference_line_start_u", "reference_line_start_x",   "reference_line_start_y",
      "reference_line_start_z", "reference_line_start_phi", "reference_line_start_s",
      "reference_line_start_b", "reference_line_end_u",     "reference_line_end_x",
      "reference_line_end_y",   "reference_line_end_z",     "reference_line_increment",
      "long_section_v_right",   "long_section_v_left",      "long_section_v_increment"};
  return keys;
}

/// Keys of modifiers and options with the value that asks for what is done anyway; none: no height depends on
/// it. Where the road lies on the earth is such, too.
const std::map<std::string, std::optional<double>>& harmless_keys() {
  static const std::map<std::string, std::optional<double>> keys{
      {"scale_z_grid", 1},          {"scale_slope", 1},
      {"scale_banking", 1},         {"scale_length", 1},
      {"scale_width", 1},           {"scale_curvature", 1},
      {"grid_nan_mode", 2},         {"grid_nan_offset", 0},
      {"refline_offset_x", 0},      {"refline_offset_y", 0},
      {"refline_offset_z", 0},      {"refline_offset_phi", 0},
      {"border_mode_u", 2},         {"border_mode_v", 2},
      {"border_offset_u", 0},       {"border_offset_v", 0},
      {"border_smooth_u", 0},       {"border_smooth_v", 0},
      {"refline_continuation", 0},  {"refline_search_far", {}},
      {"refline_search_close", {}}, {"reference_line_end_phi", {}},
      {"reference_line_end_s", {}}, {"reference_line_end_b", {}}};
  return keys;
}

bool is_harmless(const std::string& block, std::string_view line) {
  if (block == "$road_crg_mpro") return true;
  const std::size_t equals = std::min(line.find('='), line.size());
  const std::string key = lower(trimmed(line.substr(0, equals)));
  for (const char* end : {"_lon", "_lat", "_alt"})
    if (block == "$road_crg" && key.ends_with(end)) return true;
  for (const char* start : {"warn_", "log_", "check_"})
    if (block == "$road_crg_opts" && key.starts_with(start)) return true;
  const auto found = harmless_keys().find(key);
  if (found == harmless_keys().end()) return false;
  return !found->second ||
         (equals < line.size() && fe::to_real(trimmed(line.substr(equals + 1))) == found->second);
}

std::string_view without_comment(std::string_view line) { return trimmed(line.substr(0, line.find('!'))); }

void read_number(const Lines& lines, std::string_view line, CrgHead& head) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos)
    lines.fail(fmt::format("'{}' is no KEY = NUMBER of the block $ROAD_CRG", shown(line)));
  const std::string key = lower(trimmed(line.substr(0, equals)));
  const std::string_view text = trimmed(line.substr(equals + 1));
  if (!known_keys().contains(key)) {
    if (!is_harmless("$road_crg", line)) head.unused.push_back("$ROAD_CRG " + shown(key));
    return;
  }
  const auto value = fe::to_real(text);
  if (!value || std::abs(*value) > largest_number)
    lines.fail(fmt::format("{} is '{}'; a number is needed", shown(key), shown(text)));
  head.numbers[key] = *value;
  head.marks[key] = lines.mark();
}

/// Four letters: K, L; R, D; F, B; I.
void read_format(const Lines& lines, std::string_view letters, CrgHead& head) {
  const std::string format = lower(trimmed(letters));
  const auto one_of = [&](std::size_t place, const char* choices) {
    return format.size() == 4 && std::string_view(choices).find(format[place]) != std::string_view::npos;
  };
  if (!one_of(0, "kl") || !one_of(1, "rd") || !one_of(2, "fb") || !one_of(3, "i"))
    lines.fail(fmt::format("#:{} is no known format; LRFI, LDFI, KRFI, KDFI, KRBI, KDBI, LRBI and LDBI are",
                           shown(letters)));
  head.long_records = format[0] == 'l';
  head.doubles = format[1] == 'd';
  head.text = format[2] == 'f';
}

CrgColumn column_of(const Lines& lines, std::string_view definition) {
  // The unit stands behind the first comma; heights in another unit than metres would be wrong.
  const std::string name = lower(trimmed(definition.substr(0, definition.find(','))));
  std::string_view rest = definition.substr(std::min(definition.find(','), definition.size()));
  if (!rest.empty()) rest.remove_prefix(1);
  const std::string unit = lower(fe::next_field(rest));
  const auto need_unit = [&](const char* wanted) {
    if (unit != wanted)
      lines.fail(fmt::format("'{}' is in '{}'; {} is needed", shown(name), shown(unit), wanted));
  };
  const std::string section = "long section";
  if (name.starts_with(section)) {
    need_unit("m");
    const std::size_t equals = name.find('=');
    const bool at = equals != std::string::npos;
    const std::string_view text = trimmed(std::string_view(name).substr(at ? equals + 1 : section.size()));
    const auto number = fe::to_real(text);
    if (!number || std::abs(*number) > largest_number)
      lines.fail(
          fmt::format("'{}' has neither the section's number nor 'at v = ' and its place", shown(name)));
    return {at ? CrgColumn::section_at : CrgColumn::section_numbered, *number};
  }
  const std::map<std::string, std::pair<CrgColumn::Kind, const char*>> lines_of{
      {"reference line x", {CrgColumn::x, "m"}},
      {"reference line y", {CrgColumn::y, "m"}},
      {"reference line phi", {CrgColumn::phi, "rad"}},
      {"reference line banking", {CrgColumn::banking, "m/m"}},
      {"reference line slope", {CrgColumn::slope, "m/m"}}};
  const auto found = lines_of.find(name);
  if (found == lines_of.end()) return {};
  need_unit(found->second.second);
  return {found->second.first, 0};
}

}  // namespace

CrgHead read_crg_head(Lines& lines) {
  CrgHead head;
  std::string block;
  bool formatted = false;
  std::string_view line;
  while (lines.next(line)) {
    if (line.starts_with("$$$$")) {
      if (!formatted) lines.fail("the block $KD_DEFINITION has no format, #:LRFI or another");
      return head;
    }
    if (line.starts_with('*')) continue;
    if (line.starts_with('$')) {
      std::string_view rest = without_comment(line);
      block = lower(fe::next_word(rest));
      continue;
    }
    line = without_comment(line);
    if (line.empty() || block.empty() || block == "$" || block == "$ct" || line.starts_with('%')) continue;
    if (block == "$road_crg") {
      read_number(lines, line, head);
    } else if (block == "$road_crg_file") {
      lines.fail("the road's data stand in another file, which this one names; read that one");
    } else if (block == "$kd_definition") {
      if (line.starts_with("#:")) {
        read_format(lines, line.substr(2), head);
        formatted = true;
      } else if (line.starts_with("D:") || line.starts_with("d:")) {
        if (head.columns.size() == most_columns)
          lines.fail(fmt::format("has more than {} columns", most_columns));
        head.columns.push_back(column_of(lines, line.substr(2)));
        if (head.columns.back().kind == CrgColumn::other)
          head.unused.push_back("$KD_DEFINITION " + shown(line));
      }
    } else if (!is_harmless(block, line)) {
      std::string name = block;
      for (char& c : name) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
      head.unused.push_back(shown(name) + " " + shown(trimmed(line.substr(0, line.find('=')))));
    }
  }
  lines.fail("has no line $$$$ that the data begin behind: not an OpenCRG file");
}

}  // namespace mimbre::roads
