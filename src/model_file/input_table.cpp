#include "mimbre/input_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

#include "fe_files/text.h"
#include "fe_files/text_file.h"
#include "mimbre/unknown_name.h"
#include "model_file/text/units.h"

namespace mimbre {
namespace {

using fe::shown;
using fe::TextFile;
using fe::trimmed;
using Cells = std::vector<std::string>;

constexpr std::uintmax_t largest_file = 1u << 30;

/// The next line that is neither empty nor a comment.
bool next_line(TextFile& file, std::string_view& line) {
  while (file.next(line)) {
    if (file.line_number() == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    if (const std::string_view text = trimmed(line); !text.empty() && text[0] != '#') return true;
  }
  return false;
}

/// What parts the cells of the whole table: a tab where its first line has one, else a semicolon, else a
/// comma.
char separator_of(std::string_view line) {
  bool quoted = false;
  char found = ',';
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '\t') return c;
    if (c == ';') found = c;
  }
  return found;
}

/// The cells of a line, without blanks around them; one in quotes may hold the separator, and "" for a quote.
void cut(const TextFile& file, std::string_view line, char separator, Cells& cells) {
  cells.clear();
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t begin = line.find_first_not_of(separator == '\t' ? " " : " \t", at);
    std::string cell;
    if (begin != std::string_view::npos && line[begin] == '"') {
      std::size_t end = begin + 1;
      for (; end < line.size(); ++end) {
        if (line[end] == '"' && (end + 1 >= line.size() || line[end + 1] != '"')) break;
        if (line[end] == '"') ++end;
        cell += line[end];
      }
      const std::size_t next = std::min(line.find(separator, end), line.size());
      if (end >= line.size() || !trimmed(line.substr(end + 1, next - end - 1)).empty())
        file.fail("has a quote that does not end with its cell");
      at = next + 1;
    } else {
      const std::size_t next = std::min(line.find(separator, at), line.size());
      cell = trimmed(line.substr(at, next - at));
      at = next + 1;
    }
    cells.push_back(std::string(trimmed(cell)));
  }
}

/// The numbers of a table. Where commas do not part its cells, they may be the decimal marks of all numbers.
class Numbers {
 public:
  explicit Numbers(char separator) : commas_(separator != ',') {}

  /// "the time", "the value of 'u'": what the cell is of.
  double read(const TextFile& file, const std::string& cell, const std::string& what) {
    std::string text = cell;
    for (char& c : text) {
      if (c != '.' && !(commas_ && c == ',')) continue;
      if (mark_ != 0 && mark_ != c)
        file.fail(fmt::format("'{}': the table has numbers with a decimal comma and with a decimal point",
                              shown(cell)));
      mark_ = c;
      c = '.';
    }
    if (text.starts_with('+')) text.erase(0, 1);
    double value = 0;
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = end == text.data() + text.size() && !text.empty();
    if (!whole || status == std::errc::invalid_argument)
      file.fail(fmt::format("{}: '{}' is not a number", what, shown(cell)));
    // Below the smallest number there is 0.
    if (const auto at = text.find_first_of("eE");
        status == std::errc::result_out_of_range && at != std::string::npos && text[at + 1] == '-')
      return 0;
    if (status != std::errc() || !std::isfinite(value))
      file.fail(fmt::format("{}: '{}' is not a finite number", what, shown(cell)));
    return value;
  }

 private:
  bool commas_;
  char mark_ = 0;
};

/// Names do not begin so.
bool begins_number(const std::string& cell) {
  return !cell.empty() && std::string_view("+-.,0123456789").find(cell[0]) != std::string_view::npos;
}

/// A column's name, and its unit where one stands in brackets behind it.
struct Head {
  std::string name;
  std::optional<std::string> unit;
};

Head head_of(const TextFile& file, const std::string& cell) {
  const auto bracket = cell.find('[');
  if (bracket == std::string::npos) return {cell, {}};
  if (cell.back() != ']')
    file.fail(
        fmt::format("'{}': a column's head is its name and its unit, as in 'speed [m/s]'", shown(cell)));
  return {std::string(trimmed(std::string_view(cell).substr(0, bracket))),
          std::string(trimmed(std::string_view(cell).substr(bracket + 1, cell.size() - bracket - 2)))};
}

std::optional<model_file::WrittenUnit> unit_of(const std::string& text) {
  const auto unit = model_file::read_unit(text, 0, [](const std::string&) { return false; });
  return unit && unit->end == text.size() ? unit : std::nullopt;
}

bool is_pure(const std::string& unit) { return unit.empty() || unit == "1" || unit == "-"; }

/// Whether a number in one unit is the same number in the other.
bool same_unit(const std::string& a, const std::string& b) {
  if (a == b || (is_pure(a) && is_pure(b))) return true;
  const auto one = unit_of(a), other = unit_of(b);
  return one && other && one->dimension == other->dimension &&
         one->numerator * other->denominator == other->numerator * one->denominator;
}

void require_unit(const TextFile& file, const spec::Input& input, const std::string& unit) {
  if (!input.unit.empty()) {
    if (same_unit(unit, input.unit)) return;
    file.fail(fmt::format("the column of '{}' is in '{}', and the input is in '{}'", input.name, shown(unit),
                          input.unit));
  }
  // The model does not specify it: then it is an SI unit.
  const auto written = unit_of(unit);
  if (is_pure(unit) || (written && written->numerator == written->denominator)) return;
  file.fail(fmt::format(
      "the column of '{}' is in '{}', and the model gives the input no unit: its values are in SI units",
      input.name, shown(unit)));
}

std::string in_words(const std::vector<std::string>& names) {
  return fmt::format("'{}'", fmt::join(names, "', '"));
}

class Table {
 public:
  Table(const std::string& path, const std::vector<spec::Input>& inputs, const std::string& name,
        const std::string& columns)
      : file_(path), inputs_(inputs), name_(name), called_(columns) {}

  std::vector<RecordedInput> read() {
    std::string_view line;
    if (!next_line(file_, line)) nothing();
    separator_ = separator_of(line);
    numbers_ = Numbers(separator_);
    cut(file_, line, separator_, cells_);
    const auto count = std::count_if(cells_.begin(), cells_.end(), begins_number);
    if (count == 0) {
      read_header();
      if (next_line(file_, line)) {
        cut(file_, line, separator_, cells_);
        if (!is_unit_line()) read_row();
      }
    } else {
      take_order();
      read_row();
    }
    while (next_line(file_, line)) {
      cut(file_, line, separator_, cells_);
      read_row();
    }
    for (const RecordedInput& column : columns_)
      if (column.times.empty()) nothing();
    return std::move(columns_);
  }

 private:
  [[noreturn]] void nothing() const {
    throw InputError({file_.name(), 0, 0}, "has no line with a time and a value");
  }

  const spec::Input& input(const RecordedInput& column) const {
    return inputs_[static_cast<std::size_t>(column.input)];
  }
  std::optional<int> find(const std::string& name) const {
    for (std::size_t k = 0; k < inputs_.size(); ++k)
      if (inputs_[k].name == name) return static_cast<int>(k);
    return {};
  }
  std::vector<std::string> input_names() const {
    std::vector<std::string> names;
    for (const spec::Input& i : inputs_) names.push_back(i.name);
    return names;
  }

  void add_column(int input, std::size_t place) {
    columns_.push_back({input, {}, {}});
    places_.push_back(place);
    what_.push_back(fmt::format("the value of '{}'", inputs_[static_cast<std::size_t>(input)].name));
  }

  /// Without a header: t, value.
  void take_order() {
    if (name_.empty())
      file_.fail("has no header with the names of inputs; name the one input of a table without: NAME=FILE");
    if (cells_.size() != 2)
      file_.fail(fmt::format("has {} columns, and no header that names them", cells_.size()));
    width_ = 2;
    add_column(*find(name_), 1);
  }

  void read_header() {
    width_ = cells_.size();
    std::vector<std::string> names;
    for (const std::string& cell : cells_) {
      heads_.push_back(head_of(file_, cell));
      names.push_back(heads_.back().name);
      if (names.back().empty()) file_.fail(fmt::format("column {} has no name", names.size()));
    }
    time_ = time_column(names);
    if (name_.empty())
      take_inputs(names);
    else
      add_column(*find(name_), value_column(names));
    for (std::size_t k = 0; k < columns_.size(); ++k)
      if (const auto& unit = heads_[places_[k]].unit) require_unit(file_, input(columns_[k]), *unit);
    if (const auto& unit = heads_[time_].unit) require_seconds(*unit);
  }

  void require_seconds(const std::string& unit) const {
    if (unit != "s") file_.fail(fmt::format("the times are in '{}'; they are needed in s", shown(unit)));
  }

  std::vector<std::size_t> places_of(const std::vector<std::string>& names,
                                     const std::function<bool(const std::string&)>& is) const {
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < names.size(); ++k)
      if (is(names[k])) places.push_back(k);
    return places;
  }

  std::size_t time_column(const std::vector<std::string>& names) const {
    const auto is_time = [](const std::string& name) {
      const std::string word = fe::lower(name);
      return word == "t" || word == "time";
    };
    // An input may be called `time`.
    auto places = places_of(names, [&](const auto& name) { return is_time(name) && !find(name); });
    if (places.empty()) places = places_of(names, is_time);
    if (places.empty())
      file_.fail(fmt::format("has no column `t` or `time`; its columns are {}", in_words(names)));
    if (places.size() > 1)
      file_.fail(fmt::format("has more than one column of times: '{}' and '{}'", names[places[0]],
                             names[places[1]]));
    return places[0];
  }

  /// The column of the one input.
  std::size_t value_column(const std::vector<std::string>& names) const {
    auto places = places_of(names, [&](const auto& name) { return name == name_; });
    if (places.empty())
      places = places_of(names, [](const auto& name) { return fe::lower(name) == "value"; });
    if (places.empty())
      file_.fail(fmt::format("has no column '{}' or `value`; its columns are {}", name_, in_words(names)));
    if (places.size() > 1) file_.fail(fmt::format("has more than one column '{}'", names[places[0]]));
    return places[0];
  }

  void take_inputs(const std::vector<std::string>& names) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (k == time_) continue;
      const auto found = find(names[k]);
      if (!found)
        file_.fail(fmt::format("column '{}' is not {} of the model{}", shown(names[k]), called_,
                               did_you_mean(names[k], input_names())));
      for (const RecordedInput& column : columns_)
        if (column.input == *found) file_.fail(fmt::format("has more than one column '{}'", names[k]));
      add_column(*found, k);
    }
    if (columns_.empty()) file_.fail(fmt::format("has no column of {}", called_));
  }

  /// Whether the line below the header has the units of the columns.
  bool is_unit_line() const {
    for (const Head& head : heads_)
      if (head.unit) return false;
    const auto bare = [&](std::size_t place) {
      const std::string& cell = cells_[place];
      return cell.size() > 1 && cell.front() == '[' && cell.back() == ']'
                 ? std::string(trimmed(std::string_view(cell).substr(1, cell.size() - 2)))
                 : cell;
    };
    if (cells_.size() != width_ || !unit_of(bare(time_))) return false;
    require_seconds(bare(time_));
    for (std::size_t k = 0; k < columns_.size(); ++k)
      if (const std::string unit = bare(places_[k]); !unit.empty())
        require_unit(file_, input(columns_[k]), unit);
    return true;
  }

  void read_row() {
    if (cells_.size() != width_)
      file_.fail(fmt::format("has {} cell{} where the lines before have {}{}", cells_.size(),
                             cells_.size() == 1 ? "" : "s", width_,
                             separator_ == ',' && cells_.size() > width_
                                 ? " (numbers with decimal commas need semicolons between them)"
                                 : ""));
    const double time = numbers_.read(file_, cells_[time_], "the time");
    if (any_ && !(time > last_))
      file_.fail(fmt::format("the times do not increase: {} comes after {}", time, last_));
    any_ = true;
    last_ = time;
    bool has_value = false;
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const std::string& cell = cells_[places_[k]];
      if (cell.empty() && columns_.size() > 1) continue;  // the input stays as it is
      columns_[k].times.push_back(time);
      columns_[k].values.push_back(numbers_.read(file_, cell, what_[k]));
      has_value = true;
    }
    if (!has_value) file_.fail("has a time and no value");
  }

  TextFile file_;
  const std::vector<spec::Input>& inputs_;
  const std::string &name_, &called_;
  char separator_ = ',';
  Numbers numbers_{','};
  Cells cells_;              ///< of the line at hand
  std::vector<Head> heads_;  ///< of all columns; none without a header
  std::size_t width_ = 0, time_ = 0;
  std::vector<RecordedInput> columns_;
  std::vector<std::size_t> places_;  ///< of those in a line
  std::vector<std::string> what_;    ///< they are, for messages
  bool any_ = false;
  double last_ = 0;  ///< s, where there is any
};

}  // namespace

std::vector<RecordedInput> read_input_table(const std::string& path, const std::vector<spec::Input>& inputs,
                                            const std::string& name, const std::string& columns) {
  if (!name.empty()) {
    std::vector<std::string> names;
    for (const spec::Input& input : inputs) names.push_back(input.name);
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UnknownName(Mark{}, fmt::format("there is no input or tunable parameter '{}'{}", name,
                                            did_you_mean(name, names)));
  }
  std::error_code unknown;
  if (std::filesystem::is_regular_file(path, unknown) &&
      std::filesystem::file_size(path, unknown) > largest_file)
    throw InputError({path, 0, 0}, "is larger than 1 GiB; an input's table has a line per change");
  return Table(path, inputs, name, columns).read();
}

}  // namespace mimbre
