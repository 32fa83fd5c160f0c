#include "app/commands/campbell_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/common.h"
#include "app/json.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/assembly.h"
#include "mimbre/campbell.h"
#include "mimbre/diagnostics.h"
#include "mimbre/model_file.h"
#include "mimbre/trim.h"

namespace mimbre::app {
namespace {

struct Range {
  std::string name;
  std::vector<double> values;
};

Range range_of(const std::string& text) {
  const std::string wrong = fmt::format("--over {}: NAME=FROM:TO:COUNT is needed, as speed=0:400:41", text);
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw UsageError(wrong);
  std::vector<double> parts;
  const char* at = text.data() + equals + 1;
  const char* const end = text.data() + text.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next < end && *next != ':')) throw UsageError(wrong);
    parts.push_back(value);
    at = next < end ? next + 1 : next;
  }
  if (parts.size() != 3 || !(parts[1] > parts[0]) || !(parts[2] >= 2) || parts[2] > 1e5 ||
      parts[2] != std::floor(parts[2]))
    throw UsageError(wrong);
  Range range{text.substr(0, equals), {}};
  for (int k = 0; k < static_cast<int>(parts[2]); ++k)
    range.values.push_back(parts[0] + (parts[1] - parts[0]) * k / (parts[2] - 1));
  return range;
}

Json to_json(const CampbellDiagram& d) {
  Json json = answer("modes");
  json["parameter"] = d.parameter;
  json["values"] = d.values;
  json["branches"] = Json::array();
  for (const ModeBranch& b : d.branches) {
    Json real = Json::array(), imaginary = Json::array();
    for (const auto& value : b.values) {
      real.push_back(value.real());
      imaginary.push_back(value.imag());
    }
    json["branches"].push_back({{"name", b.name},
                                {"real", real},
                                {"imaginary", imaginary},
                                {"whirl", b.whirl},
                                {"half_of", b.half_of}});
  }
  json["criticals"] = Json::array();
  for (const auto& c : d.criticals)
    json["criticals"].push_back(
        {{"branch", c.branch}, {"value", c.value}, {"order", c.order}, {"frequency", c.frequency}});
  json["onsets"] = Json::array();
  for (const auto& o : d.onsets)
    json["onsets"].push_back(
        {{"branch", o.branch}, {"value", o.value}, {"frequency", o.frequency}, {"grows", o.grows}});
  json["meetings"] = Json::array();
  for (const auto& m : d.meetings)
    json["meetings"].push_back(
        {{"first", m.first}, {"second", m.second}, {"value", m.value}, {"real", m.real}, {"parts", m.parts}});
  json["evaluations"] = d.evaluations;
  json["warnings"] = d.warnings;
  return json;
}

std::string cell_of(const ModeBranch& b, std::size_t k) {
  if (b.half_of[k] >= 0) return fmt::format("with {}", b.half_of[k] + 1);
  if (!std::isfinite(b.values[k].imag())) return "–";
  return fmt::format("{:.5g}{}", b.values[k].imag() > 0 ? std::abs(b.values[k]) : b.values[k].real(),
                     b.values[k].real() > 1e-9 * std::abs(b.values[k]) ? " grows" : "");
}

std::string to_text_of(const CampbellDiagram& d) {
  std::vector<std::string> heading{d.parameter};
  for (std::size_t b = 0; b < d.branches.size(); ++b) heading.push_back(fmt::format("{}: rad/s", b + 1));
  Table table(heading);
  for (std::size_t k = 0; k < d.values.size(); ++k) {
    std::vector<std::string> row{fmt::format("{:.6g}", d.values[k])};
    for (const ModeBranch& b : d.branches) row.push_back(cell_of(b, k));
    table.add(row);
  }
  std::string text = table.text() + "\n";
  for (std::size_t b = 0; b < d.branches.size(); ++b)
    text += fmt::format("mode {}: {}\n", b + 1, d.branches[b].name);
  for (const auto& m : d.meetings)
    text += m.parts ? fmt::format("parts: {} = {:.6g}, mode {} into modes {} and {} at {:.5g} 1/s\n",
                                  d.parameter, m.value, m.first + 1, m.first + 1, m.second + 1, m.real)
                    : fmt::format("meets: {} = {:.6g}, modes {} and {} become one pair at {:.5g} 1/s\n",
                                  d.parameter, m.value, m.first + 1, m.second + 1, m.real);
  for (const auto& c : d.criticals)
    text += fmt::format("critical: {} = {:.6g}, mode {} at {:.6g} rad/s\n", d.parameter, c.value,
                        c.branch + 1, c.frequency);
  for (const auto& o : d.onsets)
    text += fmt::format("{}: {} = {:.6g}, mode {} at {:.6g} rad/s\n",
                        o.grows ? "begins to grow" : "ceases to grow", d.parameter, o.value, o.branch + 1,
                        o.frequency);
  return text;
}

/// What --over varies.
struct Varied {
  enum class Kind { parameter, input, condition } kind = Kind::parameter;
  std::string name;
};

bool is_input(const Model& model, const std::string& name) {
  const std::vector<spec::Input>& inputs = model.spec().inputs;
  return std::any_of(inputs.begin(), inputs.end(), [&](const spec::Input& i) { return i.name == name; });
}

/// Whether the file has such a parameter.
bool is_parameter(const std::string& path, const std::vector<std::string>& settings, const std::string& name,
                  double value) {
  std::map<std::string, std::string> changed = overrides(settings);
  changed[name] = fmt::format("{:.17g}", value);
  try {
    load_model(path, changed);
  } catch (const InputError& error) {
    return std::none_of(error.diagnostics().begin(), error.diagnostics().end(), [&](const Diagnostic& d) {
      return d.message.starts_with(fmt::format("there is no parameter '{}'", name));
    });
  }
  return true;
}

/// "hold.NAME" is a held condition, "model.NAME" an input or parameter. NAME alone is what the model has,
/// else a condition; refused where the model has it and --hold names it, too.
Varied varied(const Range& range, const std::string& path, const std::vector<std::string>& settings,
              const PointArguments& point, const Model& model) {
  using Kind = Varied::Kind;
  TrimConditions none;
  std::string name = range.name;
  const std::string hold = "hold.", of_model = "model.";
  if (name.starts_with(hold)) {
    name.erase(0, hold.size());
    if (!held_condition(none, name))
      throw UsageError(fmt::format(
          "--over {}: of steady driving speed, lateral_acceleration, yaw_rate or radius can be held",
          range.name));
    return {Kind::condition, name};
  }
  const bool unambiguous = name.starts_with(of_model);
  if (unambiguous) name.erase(0, of_model.size());
  if (is_input(model, name)) {
    if (std::find(point.find.begin(), point.find.end(), name) != point.find.end())
      throw UsageError(fmt::format("--over {}: --find looks for this input", range.name));
  }
  const Kind kind = is_input(model, name) ? Kind::input : Kind::parameter;
  if (unambiguous || !drives_steadily(point) || !held_condition(none, name)) return {kind, name};
  if (kind == Kind::parameter && !is_parameter(path, settings, name, range.values.front()))
    return {Kind::condition, name};
  if (std::any_of(point.hold.begin(), point.hold.end(),
                  [&](const std::string& held) { return held.starts_with(name + "="); }))
    throw UsageError(fmt::format(
        "--over {0}: the model has {1} '{0}', and --hold names that condition; write hold.{0} for the "
        "condition, model.{0} for the {2} of the model",
        name, kind == Kind::input ? "an input" : "a parameter", kind == Kind::input ? "input" : "parameter"));
  return {kind, name};
}

/// The point, of which the condition that is varied has the first value.
PointArguments with_condition(PointArguments point, const Varied& over, double value) {
  if (over.kind != Varied::Kind::condition) return point;
  std::erase_if(point.hold, [&](const std::string& held) { return held.starts_with(over.name + "="); });
  point.hold.push_back(fmt::format("{}={:.17g}", over.name, value));
  return point;
}

CampbellOptions diagram_options(const CampbellArguments& over, const std::string& parameter) {
  CampbellOptions out;
  out.parameter = parameter;
  out.most = over.most;
  out.rad_per_second = over.speed == "rpm"  ? std::numbers::pi / 30
                       : over.speed == "Hz" ? 2 * std::numbers::pi
                       : over.speed.empty() ? 0
                                            : 1;
  return out;
}

CampbellDiagram follow(const ModesBy& by, const std::vector<double>& values, const CampbellArguments& over,
                       const CampbellOptions& options, bool driven) {
  try {
    // Only equilibria have a sparse solver.
    const bool few = !driven && (over.most > 0 || over.solver != ModesSolver::automatic);
    const ModesSolver solver = few ? one_solver(by, values.front(), values.back(), over.solver)
                               : over.solver == ModesSolver::sparse ? over.solver
                                                                    : ModesSolver::dense;
    return campbell([&](double value) { return by(value, solver); }, values, options);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

}  // namespace

int run_campbell(const std::string& path, const std::vector<std::string>& settings,
                 const CampbellArguments& over, const PointArguments& point, bool json, bool strict) {
  const Range range = range_of(over.over);
  const LoadedModel loaded = load(path, settings, json);
  const Varied of = varied(range, path, settings, point, *loaded.model);
  ModesOptions options;
  options.linear =
      linear_options(with_condition(point, of, range.values.front()), loaded.model->spec().simulation);
  options.most = with_neighbours(over.most);
  NeighbouringModes modes;
  const ModesBy by = [&](double value, ModesSolver solver) {
    ModesOptions here = options;
    here.solver = solver;
    if (of.kind == Varied::Kind::condition) *held_condition(here.linear.trim, of.name) = value;
    if (of.kind == Varied::Kind::input) here.linear.run.inputs[of.name] = value;
    if (of.kind != Varied::Kind::parameter) return modes.find(value, loaded.model, here);
    std::map<std::string, std::string> changed = overrides(settings);
    changed[of.name] = fmt::format("{:.17g}", value);
    return modes.find(value, Model::compile(brought_together(load_model(path, changed))), here);
  };
  CampbellDiagram found;
  {
    const Busy busy("following the modes", !json);
    found = follow(by, range.values, over, diagram_options(over, of.name),
                   options.linear.point.at == LinearPoint::At::trim);
  }
  for (const std::string& warning : found.warnings) print_warning(warning);
  print_data(json ? to_text(to_json(found)) + '\n' : to_text_of(found));
  return done_with(!loaded.warnings.empty() || !found.warnings.empty(), strict);
}

}  // namespace mimbre::app
