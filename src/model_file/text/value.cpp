#include "model_file/text/value.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <tuple>

namespace mimbre::model_file {
namespace {

const char* kind_name(Tree::Kind kind) {
  switch (kind) {
    case Tree::Kind::null:
      return "nothing";
    case Tree::Kind::scalar:
      return "a single value";
    case Tree::Kind::list:
      return "a list";
    case Tree::Kind::map:
      return "a map of keys";
  }
  return "";
}

/// "0, 0, 2" of "(0, 0, 2)".
std::string without_parentheses(const std::string& text) {
  return text.size() > 2 && text.front() == '(' && text.back() == ')' ? text.substr(1, text.size() - 2)
                                                                      : text;
}

/// "[0, 0, 1]"
std::string example_of(std::size_t numbers) {
  std::string text = "[";
  for (std::size_t k = 0; k < numbers; ++k) text += k + 1 == numbers ? "1" : "0, ";
  return text + "]";
}

/// What is meant by a key that stands in the wrong place, where that is known.
std::string misplaced(const std::string& key, const std::vector<std::string>& known) {
  const auto has = [&](const char* name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  };
  const auto digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  if (!key.empty() && std::all_of(key.begin(), key.end(), digit))
    return " (a number has a decimal point, no comma)";
  if (key == "stiffness" && has("elastic")) return " (write elastic: {stiffness: .., zero: ..})";
  if (key == "coefficient" && has("damping")) return " (write damping: {coefficient: ..})";
  return did_you_mean(key, known);
}

}  // namespace

/// The message with names of instances left out and those of repeated items as they are written; `where`:
/// the first such name.
std::string Errors::in_common(const std::string& message, std::string& where) const {
  // Lists of what there is name the other instances' items.
  std::string words = message.substr(0, message.find("; there are: "));
  const auto replace = [&](std::size_t at, std::size_t length) {
    const std::string name = words.substr(at, length);
    const auto found = common_.find(name);
    if (found == common_.end()) return false;
    if (where.empty()) where = name;
    words.replace(at, length, found->second);
    return true;
  };
  if (const auto colon = words.find(": "); colon != std::string::npos) replace(0, colon);
  for (auto at = words.find('\''); at != std::string::npos; at = words.find('\'', at)) {
    const bool apostrophe = at > 0 && std::isalnum(static_cast<unsigned char>(words[at - 1]));
    const auto end = words.find('\'', ++at);
    if (apostrophe) continue;
    if (end == std::string::npos) break;
    // The name itself, or what it is a part of: 'car.left.hub', 'car.left', 'car'.
    for (auto dot = end; dot != std::string::npos && dot > at; dot = words.rfind('.', dot - 1))
      if (replace(at, dot - at)) break;
    at = words.find('\'', at);
    if (at != std::string::npos) ++at;
  }
  return words;
}

bool Errors::merged(const Mark& mark, const std::string& message) {
  std::string where;
  std::string words = in_common(message, where);
  if (where.empty()) return false;
  for (Several& known : several_) {
    Diagnostic& first = list[known.index];
    if (known.words != words || first.mark.line != mark.line || first.mark.column != mark.column ||
        first.mark.file != mark.file)
      continue;
    if (!known.places.insert(where).second) return true;
    if (known.where.size() > 1) first.message.erase(first.message.rfind(" (likewise in "));
    known.where.push_back(where);
    first.message += fmt::format(" (likewise in {})", joined({known.where.begin() + 1, known.where.end()}));
    return true;
  }
  several_.push_back({list.size(), std::move(words), {where}, {where}});
  return false;
}

void Errors::add(const Mark& mark, const std::string& message) {
  const auto known_already = [&](const Diagnostic& d) {
    return d.message == message && d.mark.line == mark.line && d.mark.column == mark.column &&
           d.mark.file == mark.file && mark.line > 0;
  };
  if (merged(mark, message) || std::any_of(list.begin(), list.end(), known_already)) return;
  list.push_back({mark, message});
  if (list.size() >= limits_.errors) {
    list.push_back({Mark{}, "too many errors; the rest is not shown"});
    throw_if_any();
  }
}

void Errors::throw_if_any() const {
  if (list.empty()) return;
  // File by file, by place, as one works through them.
  std::map<std::string, int> files;
  for (const Diagnostic& d : list) files.emplace(d.mark.file, static_cast<int>(files.size()));
  auto sorted = list;
  const auto place = [&](const Diagnostic& d) {
    return std::tuple(d.mark.line == 0, files.at(d.mark.file), d.mark.line, d.mark.column);
  };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const Diagnostic& a, const Diagnostic& b) { return place(a) < place(b); });
  throw InputError(std::move(sorted));
}

void Value::error(const std::string& message) const {
  reading_->errors->add(tree_->mark, fmt::format("{}: {}", what_, message));
}

std::optional<double> Value::number(const Quantity& of) const {
  if (!is_scalar()) {
    error(fmt::format("a number is needed, this is {}", kind_name(tree_->kind)));
    return {};
  }
  try {
    return evaluate(tree_->text, *reading_->scope, of);
  } catch (const ExpressionError& e) {
    error(e.what());
    return {};
  }
}

std::optional<double> Value::positive(const Quantity& of) const {
  const auto value = number(of);
  if (!value || *value > 0) return value;
  error(fmt::format("{} is not positive", *value));
  return {};
}

std::optional<double> Value::not_negative(const Quantity& of) const {
  const auto value = number(of);
  if (!value || *value >= 0) return value;
  error(fmt::format("{} is negative; it must be 0 or more", *value));
  return {};
}

std::optional<int> Value::integer(int smallest, int largest) const {
  const auto value = number();
  if (!value) return {};
  if (*value != std::floor(*value) || *value < smallest || *value > largest) {
    error(fmt::format("{} is not a whole number from {} to {}", *value, smallest, largest));
    return {};
  }
  return static_cast<int>(*value);
}

std::optional<bool> Value::flag() const {
  if (!is_scalar()) {
    error(fmt::format("true or false is needed, this is {}", kind_name(tree_->kind)));
    return {};
  }
  try {
    return evaluate(tree_->text, *reading_->scope) != 0;
  } catch (const ExpressionError&) {
    error(fmt::format("'{}' is neither true nor false", tree_->text));
    return {};
  }
}

std::optional<std::string> Value::word() const {
  if (!is_scalar()) {
    error(fmt::format("a name or word is needed, this is {}", kind_name(tree_->kind)));
    return {};
  }
  try {
    return evaluate_word(tree_->text, *reading_->scope);
  } catch (const ExpressionError& e) {
    error(e.what());
    return {};
  }
}

std::optional<std::string> Value::text() const {
  if (is_scalar() && !tree_->text.starts_with('$')) return tree_->text;
  return word();
}

std::optional<int> Value::choice(const std::vector<std::string>& choices) const {
  const auto text = word();
  if (!text) return {};
  const auto found = std::find(choices.begin(), choices.end(), *text);
  if (found != choices.end()) return static_cast<int>(found - choices.begin());
  error(fmt::format("'{}' is not one of {}{}", *text, joined(choices), did_you_mean(*text, choices)));
  return {};
}

std::optional<Eigen::Vector3d> Value::triple(const Quantity& of) const {
  const auto values = numbers(3, 3, of);
  if (!values) return {};
  return Eigen::Vector3d((*values)[0], (*values)[1], (*values)[2]);
}

std::optional<Eigen::Vector3d> Value::direction() const {
  const auto value = triple();
  if (!value) return {};
  const double length = value->stableNorm();
  if (!(length > 0) || !std::isfinite(length)) {
    error("the direction has no length; give a vector such as [0, 0, 1]");
    return {};
  }
  return *value / length;
}

std::optional<std::vector<double>> Value::numbers(std::size_t fewest, std::size_t most,
                                                  const Quantity& of) const {
  if (!is_list() || tree_->items.size() < fewest || tree_->items.size() > most) {
    const std::string count = fewest == most ? fmt::format("{}", fewest)
                              : most > 1000  ? fmt::format("{} or more", fewest)
                                             : fmt::format("{} to {}", fewest, most);
    const std::string given =
        is_list() ? fmt::format("{} values", tree_->items.size()) : std::string(kind_name(tree_->kind));
    const bool one_line = is_scalar() && tree_->text.find(',') != std::string::npos;
    error(fmt::format("a list of {} numbers is needed, this is {}; {}", count, given,
                      one_line ? fmt::format("write it as [{}]", without_parentheses(tree_->text))
                               : fmt::format("for example {}", example_of(fewest))));
    return {};
  }
  std::vector<double> result;
  bool good = true;
  for (const auto& item : tree_->items) {
    const auto value = Value(*reading_, *item, what_).number(of);
    good = good && value;
    result.push_back(value.value_or(0));
  }
  if (!good) return {};
  return result;
}

std::vector<Value> Value::list() const {
  std::vector<Value> result;
  if (!is_list()) {
    error(fmt::format("a list is needed, this is {}{}", kind_name(tree_->kind),
                      is_map() ? "; each of its items begins with '- '" : "; write [..]"));
    return result;
  }
  result.reserve(tree_->items.size());
  for (const auto& item : tree_->items) result.emplace_back(*reading_, *item, what_);
  return result;
}

Fields::Fields(const Value& value, std::initializer_list<const char*> known)
    : Fields(value, std::vector<std::string>(known.begin(), known.end())) {}

Fields::Fields(const Value& value, const std::vector<std::string>& names) : value_(value) {
  if (value.is_null()) return;
  if (!value.is_map()) {
    value.error(fmt::format("keys are needed here ({}), this is {}; for example {{{}: ..}}", joined(names),
                            kind_name(value.tree().kind), names.front()));
    return;
  }
  for (const auto& entry : value.tree().entries)
    if (std::find(names.begin(), names.end(), entry.key) == names.end())
      value.reading().errors->add(entry.mark,
                                  fmt::format("{}: unknown key '{}'{}; known: {}", value.what(), entry.key,
                                              misplaced(entry.key, names), joined(names)));
}

std::optional<Value> Fields::get(const std::string& key) const {
  if (!value_.is_map()) return {};
  const Tree::Entry* entry = value_.tree().find(key);
  if (!entry || entry->value->kind == Tree::Kind::null) return {};
  return Value(value_.reading(), *entry->value, fmt::format("{}: {}", value_.what(), key));
}

std::optional<Value> Fields::need(const std::string& key, const std::string& example) const {
  auto found = get(key);
  if (!found && (value_.is_map() || value_.is_null()))
    value_.error(fmt::format("'{}' is missing; for example {}: {}", key, key, example));
  return found;
}

double Fields::number(const std::string& key, double fallback, const Quantity& of) const {
  const auto value = get(key);
  return value ? value->number(of).value_or(fallback) : fallback;
}

bool in_an_item_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.' || (c & 0x80);
}

bool check_name(const Reading& reading, const std::string& name, const Mark& mark, const std::string& kind) {
  if (!name.empty() && name.size() <= 100 && name[0] != '.' && name[0] != '-' &&
      std::all_of(name.begin(), name.end(), in_an_item_name))
    return true;
  reading.errors->add(
      mark, fmt::format("'{}' is no name for a {}; names have 1 to 100 letters, digits, '_', '-' or '.'",
                        name.substr(0, 100), kind));
  return false;
}

std::string joined(const std::vector<std::string>& words) {
  constexpr std::size_t most = 30;
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i == most) return text + fmt::format(", … ({} in all)", words.size());
    text += (i ? ", " : "") + words[i];
  }
  return text;
}

std::string to_text(const Eigen::Vector3d& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x(), v.y(), v.z());
}

}  // namespace mimbre::model_file
