#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/commands/campbell_output.h"
#include "app/commands/point_options.h"
#include "app/common.h"
#include "app/json.h"
#include "app/targets.h"
#include "app/terminal/busy.h"
#include "app/terminal/progress.h"
#include "app/terminal/table.h"
#include "mimbre/linear_report.h"
#include "mimbre/modes.h"

/// mimbre modes: eigenvalues about a point, and what each mode consists of.
namespace mimbre::app {
namespace {

struct ModesArguments {
  std::string model;
  std::vector<std::string> settings;
  PointArguments point;
  CampbellArguments campbell;
  int most = 0;
  std::string solver = "automatic";
  std::string output, vtk;
  bool json = false, strict = false;
};

Json to_json(const std::vector<ModeShare>& shares) {
  Json json = Json::array();
  for (const ModeShare& s : shares) json.push_back({{"name", s.name}, {"share", s.share}});
  return json;
}

Json to_json(const LinearisedModes& found, const std::vector<std::string>& warnings) {
  Json json = answer("modes");
  json["point"] = found.model.point;
  json["time"] = found.model.time;
  json["solver"] = found.sparse ? "sparse" : "dense";
  json["coordinates"] = Json::array();
  for (const LinearName& c : found.coordinates) json["coordinates"].push_back(c.name);
  if (found.turning > 0) json["turning"] = found.turning;
  if (found.period > 0) json["period"] = found.period;
  json["modes"] = Json::array();
  for (const Mode& m : found.modes) {
    Json one;
    one["kind"] = m.kind == Mode::Kind::rigid ? "rigid" : m.kind == Mode::Kind::real ? "real" : "oscillating";
    one["real"] = m.value.real();
    one["imaginary"] = m.value.imag();
    one["frequency"] = m.frequency;
    one["damped_frequency"] = m.damped;
    one["damping_ratio"] = m.damping;
    one["grows"] = m.grows;
    one["whirl"] = m.whirl;
    if (!m.blades.empty()) one["blades"] = to_json(m.blades);
    if (found.turning > 0) one["from_ground"] = {m.fixed.real(), m.fixed.imag()};
    if (found.period > 0) one["multiplier"] = {m.multiplier.real(), m.multiplier.imag()};
    one["text"] = m.text;
    one["shares"] = {{"coordinates", to_json(m.coordinates)},
                     {"bodies", to_json(m.bodies)},
                     {"elastic", to_json(m.elastic)}};
    one["gravity"] = m.gravity;
    one["shape"] = Json::array();
    for (const std::complex<double>& x : m.motion) one["shape"].push_back({x.real(), x.imag()});
    json["modes"].push_back(std::move(one));
  }
  json["notes"] = found.model.notes;
  json["warnings"] = warnings;
  json["cpu_seconds"] = found.cpu_seconds;
  return json;
}

std::string to_table(const LinearisedModes& found) {
  const bool turns = found.turning > 0;
  std::vector<std::string> heading{"mode", "Hz", "damping ratio", "real 1/s", "imaginary 1/s"};
  if (turns) heading.emplace_back("from the ground 1/s");
  heading.emplace_back("consists of");
  Table table(heading);
  int number = 0;
  for (const Mode& m : found.modes) {
    std::vector<std::string> row{
        fmt::format("{}", ++number), fmt::format("{:.6g}", m.frequency),
        m.kind == Mode::Kind::rigid ? "–" : fmt::format("{:.4g}", m.damping == 0 ? 0 : m.damping),
        fmt::format("{:.6g}", m.value.real()), fmt::format("{:.6g}", m.value.imag())};
    if (turns)
      row.push_back(std::isfinite(m.fixed.imag()) ? fmt::format("{:.6g}", m.fixed.imag())
                                                  : "two frequencies");
    row.push_back(m.text);
    table.add(row);
  }
  std::string text = fmt::format("point: {}\n", found.model.point) + table.text();
  if (turns)
    text += fmt::format(
        "The mechanism turns as a whole with {:.6g} rad/s; its coordinates turn with it. From the ground its "
        "whirling modes have\nfrequencies that differ from those in these axes by that speed.\n",
        found.turning);
  for (const std::string& note : found.model.notes) text += note + "\n";
  return text;
}

/// Before a long computation.
void check_outputs(const ModesArguments& a) {
  if (!a.campbell.over.empty() && !(a.output.empty() && a.vtk.empty()))
    throw UsageError("--output and --vtk write the modes at one point; they do not go with --over");
  if (!a.campbell.speed.empty() && a.campbell.over.empty())
    throw UsageError("--speed: is a unit of the parameter that --over names");
  if (a.output.empty()) return;
  check_modes_path(a.output);
  require_different(a.model, a.output);
}

LinearisedModes found_modes(const LoadedModel& loaded, const ModesArguments& a, ModesSolver solver) {
  ModesOptions options;
  options.linear = linear_options(a.point, loaded.model->spec().simulation);
  options.most = a.most;
  options.solver = solver;
  options.shapes = !a.output.empty() || !a.vtk.empty();
  const Busy busy("looking for the modes", !a.json);
  try {
    return find_modes(loaded.model, options);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

/// Returns the names of what was written, a line each.
std::string write_files(const ModesArguments& a, const LinearisedModes& found) {
  std::string lines;
  if (!a.output.empty()) {
    write_modes(found, a.output);
    lines += made("modes", a.output, false);
  }
  if (a.vtk.empty()) return lines;
  Progress progress(!a.json);
  ModesVtkOptions options;
  options.progress = [&](double part) { progress.update("writing", part); };
  const std::string first = write_modes_vtk(found, a.vtk, options);
  progress.clear();
  return lines + made("modes", first, false);
}

int run_modes(const ModesArguments& a) {
  check_outputs(a);
  const ModesSolver solver = a.solver == "dense"    ? ModesSolver::dense
                             : a.solver == "sparse" ? ModesSolver::sparse
                                                    : ModesSolver::automatic;
  if (!a.campbell.over.empty()) {
    CampbellArguments over = a.campbell;
    over.most = a.most;
    over.solver = solver;
    return run_campbell(a.model, a.settings, over, a.point, a.json, a.strict);
  }
  const LoadedModel loaded = load(a.model, a.settings, a.json);
  if (!a.output.empty()) {
    for (const std::string& file : loaded.other_files) require_different(file, a.output);
    require_writable(a.output);
  }
  const LinearisedModes found = found_modes(loaded, a, solver);
  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : found.model.warnings) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  const std::string files = write_files(a, found);
  if (a.json)
    print_data(to_text(to_json(found, warnings)) + '\n');
  else
    print_data(files.empty() ? to_table(found) : files);
  return done_with(!warnings.empty(), a.strict);
}

}  // namespace

Command add_modes(CommandLine& program) {
  Parser parser =
      program.add_command("modes", "Find the modes about a point, or over a parameter (Campbell diagram)");
  const auto a = std::make_shared<ModesArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, a->settings);
  parser.add_option("--most", a->most, "So many modes, of the lowest frequencies; 0: all")
      .within(0, 100000)
      .show_default()
      .type_name("N");
  parser
      .add_option(
          "--solver", a->solver,
          "dense: all modes; sparse: the lowest ones of an equilibrium by shift and invert. By default "
          "sparse where --most asks for a few of a large model")
      .choice({"automatic", "dense", "sparse"})
      .show_default();
  parser
      .add_option(
          "--over", a->campbell.over,
          "A parameter, an input or a held condition from one value to another, with so many values: modes "
          "followed by their shapes, and where one begins to grow")
      .type_name("NAME=FROM:TO:COUNT");
  parser
      .add_option(
          "--speed", a->campbell.speed,
          "The parameter is a speed in this unit: also critical speeds, at which a mode has its frequency")
      .choice({"rad/s", "rpm", "Hz"});
  parser
      .add_option("-o,--output", a->output,
                  "File: .html, a page in which the modes are animated; .h5, the shapes by coordinate and by "
                  "body. Its name is printed in place of the table")
      .type_name("FILE");
  parser
      .add_option(
          "--vtk", a->vtk,
          "Each mode over one period as VTK files, for ParaView, with one series (mode_1.pvd, ...) each")
      .type_name("FOLDER");
  parser.add_flag("--json", a->json, "The same as JSON, with the shapes");
  add_strict_option(parser, a->strict);
  add_point_options(parser, a->point);
  parser.footer(
      "Examples:\n  mimbre modes car.yaml\n  mimbre modes rotor.yaml --over rpm=0:4000:41 --speed rpm\n"
      "  mimbre modes car.yaml -o shapes.html\n"
      "  mimbre modes car.yaml --find throttle --over hold.speed=5:40:36");
  return {parser, [a] { return run_modes(*a); }};
}

}  // namespace mimbre::app
