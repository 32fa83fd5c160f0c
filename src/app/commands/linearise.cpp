#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/commands/point_options.h"
#include "app/common.h"
#include "app/json.h"
#include "app/targets.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/linear_report.h"
#include "mimbre/linearise.h"

/// mimbre linearise: state-space matrices of a model about a point.
namespace mimbre::app {
namespace {

struct LineariseArguments {
  std::string model, output, frequencies;
  std::vector<std::string> settings;
  PointArguments point;
  bool json = false, strict = false;
};

/// "0.1:100:200": from, to, how many; evenly on a logarithmic scale.
std::vector<double> frequencies_of(const std::string& text) {
  if (text.empty()) return {};
  std::vector<double> parts;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next < end && *next != ':')) break;
    parts.push_back(value);
    at = next < end ? next + 1 : next;
  }
  if (at != end || parts.size() != 3 || !(parts[0] > 0) || !(parts[1] > parts[0]) || !(parts[2] >= 2) ||
      parts[2] > 1e5 || parts[2] != std::floor(parts[2]))
    throw UsageError(fmt::format("--frequencies {}: FROM:TO:COUNT in Hz is needed, as 0.1:100:200", text));
  std::vector<double> all;
  for (int k = 0; k < static_cast<int>(parts[2]); ++k)
    all.push_back(parts[0] * std::pow(parts[1] / parts[0], k / (parts[2] - 1)));
  return all;
}

std::string summary(const LinearModel& m) {
  std::string text = fmt::format(
      "point: {}\n{} states: {} coordinates, {} velocities, {} others; {} inputs, {} outputs\n", m.point,
      m.states.size(), m.coordinates, m.speeds == m.coordinates ? "as many" : fmt::format("{}", m.speeds),
      static_cast<int>(m.states.size()) - m.coordinates - m.speeds, m.inputs.size(), m.outputs.size());
  Table table({"state", "unit"});
  for (const LinearName& s : m.states) table.add({s.name, s.unit});
  return text + table.text();
}

int run_linearise(const LineariseArguments& a) {
  if (a.output.empty() && !a.json && !a.frequencies.empty())
    throw UsageError("--frequencies needs a file for the responses: --output FILE, or --json");
  const std::vector<double> frequencies = frequencies_of(a.frequencies);
  if (!a.output.empty()) {
    check_linear_path(a.output, frequencies);
    require_different(a.model, a.output);
    require_writable(a.output);
  }
  const LoadedModel loaded = load(a.model, a.settings, a.json);
  if (!a.output.empty())
    for (const std::string& file : loaded.other_files) require_different(file, a.output);
  const LinearOptions options = linear_options(a.point, loaded.model->spec().simulation);
  LinearModel model;
  {
    const Busy busy("linearising", !a.json);
    try {
      model = linearise(loaded.model, options);
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw Failure(error.what());
    }
  }
  for (const std::string& warning : model.warnings) print_warning(warning);
  if (!a.output.empty()) write_linear_file(model, a.output, frequencies);
  if (a.json)
    print_data(linear_model_json(model, frequencies) + '\n');
  else if (a.output.empty())
    print_data(summary(model));
  else
    print_data(made("linearise", a.output, false));
  return done_with(!loaded.warnings.empty() || !model.warnings.empty(), a.strict);
}

}  // namespace

Command add_linearise(CommandLine& program) {
  Parser parser = program.add_command(
      "linearise", "Write the linear model about a point: A, B, C, D, mass, damping, stiffness");
  const auto a = std::make_shared<LineariseArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, a->settings);
  parser
      .add_option("-o,--output", a->output,
                  "File: .h5, .mat (MATLAB, Octave, SciPy) or .json; .html: Bode plots at the "
                  "--frequencies")
      .type_name("FILE");
  parser
      .add_option("--frequencies", a->frequencies,
                  "Also frequency responses from the inputs to the outputs: FROM:TO:COUNT in Hz, on a "
                  "logarithmic scale")
      .type_name("RANGE");
  parser.add_flag("--json", a->json, "The model as JSON");
  add_strict_option(parser, a->strict);
  add_point_options(parser, a->point);
  parser.footer(
      "Without --output or --json, prints the states. Examples:\n  mimbre linearise car.yaml --at 2.5 -o "
      "car.mat\n"
      "  mimbre linearise robot.yaml -o robot.h5 --frequencies 0.1:100:200\n"
      "  mimbre linearise robot.yaml -o bode.html --frequencies 0.1:100:200");
  return {parser, [a] { return run_linearise(*a); }};
}

}  // namespace mimbre::app
