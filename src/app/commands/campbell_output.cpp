#include "app/commands/campbell_output.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/common.h"
#include "app/json.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/assembly.h"
#include "mimbre/campbell.h"
#include "mimbre/model_file.h"

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
    json["branches"].push_back(
        {{"name", b.name}, {"real", real}, {"imaginary", imaginary}, {"whirl", b.whirl}});
  }
  json["criticals"] = Json::array();
  for (const auto& c : d.criticals)
    json["criticals"].push_back(
        {{"branch", c.branch}, {"value", c.value}, {"order", c.order}, {"frequency", c.frequency}});
  json["onsets"] = Json::array();
  for (const auto& o : d.onsets)
    json["onsets"].push_back(
        {{"branch", o.branch}, {"value", o.value}, {"frequency", o.frequency}, {"grows", o.grows}});
  json["evaluations"] = d.evaluations;
  json["warnings"] = d.warnings;
  return json;
}

std::string to_text_of(const CampbellDiagram& d) {
  std::vector<std::string> heading{d.parameter};
  for (std::size_t b = 0; b < d.branches.size(); ++b) heading.push_back(fmt::format("{}: rad/s", b + 1));
  Table table(heading);
  for (std::size_t k = 0; k < d.values.size(); ++k) {
    std::vector<std::string> row{fmt::format("{:.6g}", d.values[k])};
    for (const ModeBranch& b : d.branches)
      row.push_back(std::isfinite(b.values[k].imag())
                        ? fmt::format("{:.5g}{}",
                                      b.values[k].imag() > 0 ? std::abs(b.values[k]) : b.values[k].real(),
                                      b.values[k].real() > 1e-9 * std::abs(b.values[k]) ? " grows" : "")
                        : "–");
    table.add(row);
  }
  std::string text = table.text() + "\n";
  for (std::size_t b = 0; b < d.branches.size(); ++b)
    text += fmt::format("mode {}: {}\n", b + 1, d.branches[b].name);
  for (const auto& c : d.criticals)
    text += fmt::format("critical: {} = {:.6g}, mode {} at {:.6g} rad/s\n", d.parameter, c.value,
                        c.branch + 1, c.frequency);
  for (const auto& o : d.onsets)
    text += fmt::format("{}: {} = {:.6g}, mode {} at {:.6g} rad/s\n",
                        o.grows ? "begins to grow" : "ceases to grow", d.parameter, o.value, o.branch + 1,
                        o.frequency);
  return text;
}

}  // namespace

int run_campbell(const std::string& path, const std::vector<std::string>& settings,
                 const CampbellArguments& over, const PointArguments& point, bool json, bool strict) {
  const Range range = range_of(over.over);
  const LoadedModel loaded = load(path, settings, json);
  ModesOptions options;
  options.linear = linear_options(point, loaded.model->spec().simulation);
  options.most = with_neighbours(over.most);
  bool is_input = false;
  for (const spec::Input& input : loaded.model->spec().inputs)
    is_input = is_input || input.name == range.name;
  const ModesBy by = [&](double value, ModesSolver solver) {
    ModesOptions here = options;
    here.solver = solver;
    if (is_input) {
      here.linear.run.inputs[range.name] = value;
      return find_modes(loaded.model, here);
    }
    std::map<std::string, std::string> changed = overrides(settings);
    changed[range.name] = fmt::format("{:.17g}", value);
    return find_modes(Model::compile(brought_together(load_model(path, changed))), here);
  };
  CampbellOptions diagram;
  diagram.parameter = range.name;
  diagram.most = over.most;
  diagram.rad_per_second = over.speed == "rpm"  ? std::numbers::pi / 30
                           : over.speed == "Hz" ? 2 * std::numbers::pi
                           : over.speed.empty() ? 0
                                                : 1;
  CampbellDiagram found;
  {
    const Busy busy("following the modes", !json);
    try {
      const bool few = over.most > 0 || over.solver != ModesSolver::automatic;
      const ModesSolver solver =
          few ? one_solver(by, range.values.front(), range.values.back(), over.solver) : ModesSolver::dense;
      found = campbell([&](double value) { return by(value, solver); }, range.values, diagram);
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw Failure(error.what());
    }
  }
  for (const std::string& warning : found.warnings) print_warning(warning);
  print_data(json ? to_text(to_json(found)) + '\n' : to_text_of(found));
  return done_with(!loaded.warnings.empty() || !found.warnings.empty(), strict);
}

}  // namespace mimbre::app
