#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model_file/text/builder.h"

/// Force laws: functions of one variable.
namespace mimbre::model_file {
namespace {

std::optional<Function> linear_law(const Value& value, const LawUnits& units) {
  const Fields fields(value, {"stiffness", "zero"});
  const auto stiffness = fields.need("stiffness", "1000");
  const auto k = stiffness ? stiffness->not_negative(units.slope) : std::nullopt;
  const double zero = fields.number("zero", 0, units.x);
  if (!k) return {};
  return Function::linear(*k, zero);
}

/// "N/m^2", "N s^2/m^2": of the coefficient of x^k in y(x).
std::string coefficient_unit(const LawUnits& units, int k) {
  if (k == 0) return std::string(units.y.unit);
  if (k == 1 && units.slope.unit.size() > 0) return std::string(units.slope.unit);
  const std::string x(units.x.unit), y(units.y.unit);
  const auto over = x.find('/');
  const auto raised = [k](const std::string& unit) { return k == 1 ? unit : fmt::format("{}^{}", unit, k); };
  const std::string times = over == std::string::npos ? "" : raised(x.substr(over + 1));
  const std::string above = y + (y.empty() || times.empty() ? "" : " ") + times;
  return fmt::format("{}/{}", above.empty() ? "1" : above, raised(x.substr(0, over)));
}

/// Coefficients c of y = Σ c[k] x^k, each in SI or with a unit of y/x^k.
std::optional<std::vector<double>> read_coefficients(const Value& value, const LawUnits& units) {
  const auto& items = value.tree().items;
  if (!value.is_list() || items.empty() || items.size() > 32) return value.numbers(1, 32);
  std::vector<double> coefficients;
  bool good = true;
  for (std::size_t k = 0; k < items.size(); ++k) {
    const int power_of_x = static_cast<int>(k);
    const std::string unit = coefficient_unit(units, power_of_x);
    Quantity of{unit, {}};
    if (units.x.dimension && units.y.dimension)
      of.dimension = product(*units.y.dimension, power(*units.x.dimension, -power_of_x));
    const auto coefficient = Value(value.reading(), *items[k], value.what()).number(of);
    good = good && coefficient;
    coefficients.push_back(coefficient.value_or(0));
  }
  if (!good) return {};
  return coefficients;
}

std::optional<Function> pieces_law(const Value& value, const LawUnits& units) {
  std::vector<double> breaks;
  std::vector<std::vector<double>> pieces;
  bool good = true;
  const auto list = value.list();
  if (list.empty() && value.is_list()) value.error("there is no piece; for example [{polynomial: [0, 100]}]");
  for (std::size_t k = 0; k < list.size(); ++k) {
    const Fields fields(list[k], {"until", "polynomial"});
    const auto polynomial = fields.need("polynomial", "[0, 100]");
    const auto coefficients = polynomial ? read_coefficients(*polynomial, units) : std::nullopt;
    good = good && coefficients;
    pieces.push_back(coefficients.value_or(std::vector<double>{0}));
    const auto until = fields.get("until");
    if (k + 1 == list.size()) {
      if (until) until->error("the last piece goes on for ever and has no 'until'");
      good = good && !until;
      break;
    }
    if (!until) {
      list[k].error("'until' is missing; every piece but the last needs its end");
      good = false;
      continue;
    }
    const auto end = until->number(units.x);
    if (end && !breaks.empty() && *end <= breaks.back()) {
      until->error(fmt::format("the pieces do not ascend: {} comes after {}", *end, breaks.back()));
      good = false;
    }
    good = good && end;
    breaks.push_back(end.value_or(0));
  }
  if (!good || pieces.empty()) return {};
  return Function::piecewise(std::move(breaks), std::move(pieces));
}

std::optional<Function> expression_law(const Value& value, LawOf law, const LawUnits& units) {
  const std::vector<Variable> variables = variables_of(law, units.x);
  try {
    return Function::expression(
        substitute_parameters(value.tree().text, *value.reading().scope, variables, units.y),
        variables.front().name);
  } catch (const ExpressionError& e) {
    value.error(e.what());
  } catch (const InputError& e) {
    value.error(e.diagnostics().front().message);
  } catch (const std::invalid_argument& e) {
    value.error(e.what());
  }
  return {};
}

}  // namespace

bool is_plain_number(const Value& value) {
  if (!value.is_scalar()) return false;
  try {
    evaluate(value.tree().text, *value.reading().scope, quantity::any);
    return true;
  } catch (const ExpressionError&) {
    return false;
  }
}

std::optional<std::pair<std::vector<double>, std::vector<double>>> read_points(const Value& value, bool jumps,
                                                                               const Quantity& of_x,
                                                                               const Quantity& of_y) {
  std::vector<double> x, y;
  bool good = true;
  const auto rows = value.list();
  if (value.is_list() && rows.size() < 2) {
    value.error("at least two points [x, y] are needed");
    return {};
  }
  for (const Value& row : rows) {
    const auto pair = row.is_list() && row.tree().items.size() == 2 ? row.list() : std::vector<Value>{};
    if (pair.empty()) row.numbers(2, 2);
    const auto at = pair.empty() ? std::nullopt : pair[0].number(of_x);
    const auto height = pair.empty() ? std::nullopt : pair[1].number(of_y);
    if (!at || !height) {
      good = false;
      continue;
    }
    const std::size_t n = x.size();
    const double next = *at;
    if (n > 0 && next < x[n - 1]) {
      row.error(fmt::format("the table does not ascend: {} comes after {}", next, x[n - 1]));
      good = false;
    } else if (n > 0 && next == x[n - 1] && (!jumps || (n > 1 && x[n - 2] == next))) {
      row.error(fmt::format("{} is given {}", next, jumps ? "three times; a jump has two points" : "twice"));
      good = false;
    }
    x.push_back(next);
    y.push_back(*height);
  }
  if (good && x.size() >= 2 && x.front() == x.back()) {
    value.error("the table has only one abscissa");
    good = false;
  }
  if (!good || x.size() < 2) return {};
  return std::pair(std::move(x), std::move(y));
}

namespace {

std::optional<Function> table_law(const Fields& fields, const Value& table, const LawUnits& units) {
  int cubic = 0;
  if (const auto interpolation = fields.get("interpolation"))
    cubic = interpolation->choice({"linear", "cubic"}).value_or(0);
  auto points = read_points(table, cubic == 0, units.x, units.y);
  if (!points) return {};
  return Function::table(std::move(points->first), std::move(points->second),
                         cubic ? Function::Interpolation::cubic : Function::Interpolation::linear);
}

}  // namespace

std::optional<Function> read_law(const Value& value, LawOf law, const LawUnits& units) {
  if (value.is_scalar()) return expression_law(value, law, units);
  if (!value.is_map()) {
    value.error(
        "a law is needed: an expression, or {stiffness: 1000, zero: 0.1}, {polynomial: [..]}, {pieces: "
        "[..]}, "
        "{table: [[x, y], ..]}, {constant: 5}");
    return {};
  }
  if (value.tree().find("stiffness")) return linear_law(value, units);
  const Fields fields(value, {"stiffness", "zero", "coefficient", "constant", "polynomial", "pieces", "table",
                              "interpolation"});
  std::vector<std::string> given;
  for (const char* key : {"coefficient", "constant", "polynomial", "pieces", "table"})
    if (fields.has(key)) given.push_back(key);
  if (given.size() != 1) {
    value.error(given.empty()
                    ? "specifies no law; one of stiffness, coefficient, constant, polynomial, pieces, table"
                    : fmt::format("specifies several laws at once: {}", joined(given)));
    return {};
  }
  const Value description = *fields.get(given[0]);
  if (given[0] == "table") return table_law(fields, description, units);
  if (given[0] == "pieces") return pieces_law(description, units);
  if (given[0] == "polynomial") {
    auto coefficients = read_coefficients(description, units);
    if (!coefficients) return {};
    return Function::polynomial(std::move(*coefficients));
  }
  const auto number =
      given[0] == "coefficient" ? description.not_negative(units.slope) : description.number(units.y);
  if (!number) return {};
  return given[0] == "coefficient" ? Function::linear(*number) : Function::constant(*number);
}

std::optional<Function> read_elastic_law(const Value& value, const LawUnits& units) {
  if (!is_plain_number(value)) return read_law(value, LawOf::coordinate, units);
  value.error(
      fmt::format("a plain number could be a stiffness or a force; write {{stiffness: {}, zero: ..}} or "
                  "{{constant: {}}}",
                  value.tree().text, value.tree().text));
  return {};
}

std::optional<Function> read_damping_law(const Value& value, const LawUnits& units) {
  if (!is_plain_number(value)) return read_law(value, LawOf::rate, units);
  const auto coefficient = value.not_negative(units.slope);
  if (!coefficient) return {};
  return Function::linear(*coefficient);
}

}  // namespace mimbre::model_file
