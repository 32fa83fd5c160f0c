#include "model_file/text/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <numbers>
#include <vector>

#include "mimbre/diagnostics.h"
#include "model_file/text/expression.h"
#include "model_file/text/scanning.h"

namespace mimbre::model_file {
namespace {

struct NamedUnit {
  std::string_view name;
  double numerator, denominator;
  Dimension dimension;
};

using std::numbers::pi;
constexpr Dimension kg{1}, m{0, 1}, s{0, 0, 1}, rad{0, 0, 0, 1}, N{1, 1, -2}, Nm{1, 2, -2}, Pa{1, -1, -2},
    A{0, 0, 0, 0, 1}, V{1, 2, -3, 0, -1}, ohm{1, 2, -3, 0, -2};

/// No `t` (the time of laws) and no Hz (turns or radians?).
constexpr std::array named_units{
    NamedUnit{"kg", 1, 1, kg},
    NamedUnit{"g", 1, 1000, kg},
    NamedUnit{"lb", 0.45359237, 1, kg},
    NamedUnit{"m", 1, 1, m},
    NamedUnit{"mm", 1, 1000, m},
    NamedUnit{"cm", 1, 100, m},
    NamedUnit{"km", 1000, 1, m},
    NamedUnit{"um", 1, 1e6, m},
    NamedUnit{"µm", 1, 1e6, m},  // the micro sign, U+00B5
    NamedUnit{"μm", 1, 1e6, m},  // the Greek letter, U+03BC
    NamedUnit{"in", 0.0254, 1, m},
    NamedUnit{"ft", 0.3048, 1, m},
    NamedUnit{"s", 1, 1, s},
    NamedUnit{"ms", 1, 1000, s},
    NamedUnit{"us", 1, 1e6, s},
    NamedUnit{"µs", 1, 1e6, s},
    NamedUnit{"μs", 1, 1e6, s},
    NamedUnit{"min", 60, 1, s},
    NamedUnit{"h", 3600, 1, s},
    NamedUnit{"rad", 1, 1, rad},
    NamedUnit{"mrad", 1, 1000, rad},
    NamedUnit{"deg", pi, 180, rad},
    NamedUnit{"°", pi, 180, rad},
    NamedUnit{"rev", 2 * pi, 1, rad},
    NamedUnit{"rpm", pi, 30, {0, 0, -1, 1}},
    NamedUnit{"N", 1, 1, N},
    NamedUnit{"kN", 1000, 1, N},
    NamedUnit{"MN", 1e6, 1, N},
    NamedUnit{"mN", 1, 1000, N},
    NamedUnit{"lbf", 4.4482216152605, 1, N},
    NamedUnit{"Nm", 1, 1, Nm},
    NamedUnit{"kNm", 1000, 1, Nm},
    NamedUnit{"Nmm", 1, 1000, Nm},
    NamedUnit{"Ns", 1, 1, {1, 1, -1}},
    NamedUnit{"kNs", 1000, 1, {1, 1, -1}},
    NamedUnit{"Nms", 1, 1, {1, 2, -1}},
    NamedUnit{"Pa", 1, 1, Pa},
    NamedUnit{"kPa", 1000, 1, Pa},
    NamedUnit{"MPa", 1e6, 1, Pa},
    NamedUnit{"GPa", 1e9, 1, Pa},
    NamedUnit{"bar", 1e5, 1, Pa},
    NamedUnit{"A", 1, 1, A},
    NamedUnit{"mA", 1, 1000, A},
    NamedUnit{"V", 1, 1, V},
    NamedUnit{"mV", 1, 1000, V},
    NamedUnit{"ohm", 1, 1, ohm},
    NamedUnit{"Ω", 1, 1, ohm},
    NamedUnit{"mohm", 1, 1000, ohm},
    NamedUnit{"mΩ", 1, 1000, ohm},
};

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }

/// An exponent at `at`: ^2, 2 or ²; 1 where there is none. Moves `at` behind it.
int read_exponent(const std::string& text, std::size_t& at) {
  for (const auto& [sign, exponent] : {std::pair<std::string_view, int>{"²", 2}, {"³", 3}})
    if (text.compare(at, sign.size(), sign) == 0) return at += sign.size(), exponent;
  std::size_t i = at;
  if (i < text.size() && text[i] == '^') ++i;
  if (i >= text.size() || !is_digit(text[i]) || (i + 1 < text.size() && is_digit(text[i + 1]))) return 1;
  at = i + 1;
  return text[i] - '0';
}

/// The unit whose name stands at `at` and ends there as a name does; moves `at` behind it and its exponent.
const NamedUnit* read_name(const std::string& text, std::size_t& at, int& exponent) {
  for (const NamedUnit& unit : named_units) {
    if (text.compare(at, unit.name.size(), unit.name) != 0) continue;
    std::size_t end = at + unit.name.size();
    const int power = read_exponent(text, end);
    if (end < text.size() && (is_letter(text[end]) || is_digit(text[end]) || text[end] == '(')) continue;
    at = end;
    exponent = power;
    return &unit;
  }
  return nullptr;
}

/// How many units a product or quotient has.
std::ptrdiff_t names_in(std::string_view unit) {
  return 1 + std::count_if(unit.begin(), unit.end(), [](char c) { return c == ' ' || c == '/'; });
}

std::string base_text(const Dimension& d) {
  std::string over, under;
  const auto add = [&](const char* name, int exponent) {
    if (exponent == 0) return;
    std::string& side = exponent > 0 ? over : under;
    side += exponent > 0 ? (over.empty() ? "" : " ") : "/";
    side += name;
    if (std::abs(exponent) > 1) side += fmt::format("^{}", std::abs(exponent));
  };
  add("kg", d.kilogram);
  add("m", d.metre);
  add("rad", d.radian);
  add("s", d.second);
  add("A", d.ampere);
  return (over.empty() ? "1" : over) + under;
}

}  // namespace

Dimension product(const Dimension& a, const Dimension& b) {
  return {a.kilogram + b.kilogram, a.metre + b.metre, a.second + b.second, a.radian + b.radian,
          a.ampere + b.ampere};
}

Dimension power(const Dimension& a, int exponent) {
  return {exponent * a.kilogram, exponent * a.metre, exponent * a.second, exponent * a.radian,
          exponent * a.ampere};
}

bool fits(const Dimension& dimension, const Quantity& quantity) {
  if (!quantity.dimension) return true;
  const Dimension &a = dimension, &b = *quantity.dimension;
  const bool others =
      a.kilogram == b.kilogram && a.metre == b.metre && a.second == b.second && a.ampere == b.ampere;
  const bool only_angles = a.kilogram == 0 && a.metre == 0 && a.ampere == 0;
  return others && (a.radian == b.radian || !only_angles);
}

std::string to_text(const Dimension& dimension) {
  for (const Quantity& q :
       {quantity::mass, quantity::length, quantity::time, quantity::angle, quantity::turning_speed,
        quantity::force, quantity::moment, quantity::pressure, quantity::stiffness,
        quantity::turning_stiffness, quantity::damping, quantity::turning_damping})
    if (*q.dimension == dimension) return std::string(q.unit);
  return base_text(dimension);
}

std::optional<WrittenUnit> read_unit(const std::string& text, std::size_t at,
                                     const std::function<bool(const std::string&)>& taken) {
  WrittenUnit result;
  std::size_t next = at;
  enum { first, times, over, blank } joined_by = first;
  for (;;) {
    const std::size_t start = next;
    int exponent = 1;
    const NamedUnit* unit = read_name(text, next, exponent);
    if (!unit) break;
    const std::string name(unit->name);
    if ((joined_by == times || joined_by == over) && taken(name))
      throw ExpressionError(
          fmt::format("in '{}' '{}' could be the unit or what has this name in the model; put blanks around "
                      "the operator before it, or rename that",
                      text.substr(at, next - at), text.substr(start, unit->name.size())));
    const bool under = joined_by == over;
    for (int k = 0; k < exponent; ++k) {
      result.numerator *= under ? unit->denominator : unit->numerator;
      result.denominator *= under ? unit->numerator : unit->denominator;
    }
    result.dimension = product(result.dimension, power(unit->dimension, under ? -exponent : exponent));
    result.end = next;
    constexpr std::string_view dot = "·";
    if (next >= text.size()) break;
    if (text[next] == '*' || text[next] == '/')
      joined_by = text[next++] == '*' ? times : over;
    else if (text[next] == ' ')
      joined_by = blank, ++next;
    else if (text.compare(next, dot.size(), dot) == 0)
      joined_by = times, next += dot.size();
    else
      break;
  }
  if (result.end == 0) return {};
  return result;
}

std::string needed(const Quantity& quantity) {
  if (quantity.unit.empty()) return "a number without unit is needed here";
  return fmt::format("{} is needed here{}", quantity.unit,
                     quantity.others.empty() ? "" : fmt::format(" (or {})", quantity.others));
}

std::string unit_hint(const std::string& name, const Quantity& wanted) {
  const bool known = wanted.dimension && !wanted.unit.empty();
  std::vector<std::string> names;
  for (const NamedUnit& unit : named_units)
    if (!known || fits(unit.dimension, wanted) || names_in(wanted.unit) > 1) names.emplace_back(unit.name);
  const std::string hint = name.size() > 1 ? did_you_mean(name, names) : "";
  if (!hint.empty()) return hint;
  return "; " +
         (known ? needed(wanted)
                : "units are kg, g, m, mm, s, ms, N, kN, N m, Pa, MPa, rad, deg, rpm and their products");
}

}  // namespace mimbre::model_file
