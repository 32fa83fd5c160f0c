#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/targets.h"
#include "app/terminal/progress.h"
#include "app/terminal/table.h"
#include "mimbre/mode_selection.h"
#include "mimbre/reduced_body.h"

/// mimbre select: the fewest modes of a body that its mechanism needs.
namespace mimbre::app {
namespace {

struct SelectArguments {
  std::string model, body, output, pre = "candidates", keep = "combinations";
  std::vector<std::string> settings;
  RunOptions method;
  double error = 1;
  std::optional<double> end;
  bool json = false;
};

int find_body(const spec::Model& model, const std::string& name) {
  std::vector<std::string> flexible;
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    if (model.bodies[k].name == name) return static_cast<int>(k);
    if (model.bodies[k].flexible) flexible.push_back(model.bodies[k].name);
  }
  std::string known;
  for (const std::string& other : flexible) known += (known.empty() ? "" : ", ") + other;
  throw UsageError(fmt::format("--body: there is no body '{}'{}; flexible bodies: {}", name,
                               did_you_mean(name, flexible), known.empty() ? "none" : known));
}

ModeSelection select(const LoadedModel& loaded, const SelectArguments& a, Progress& progress) {
  const spec::Model& model = loaded.model->spec();
  ModeSelectionOptions options;
  options.error = a.error / 100;
  options.pre = a.pre == "rigid" ? ModeSelectionOptions::Pre::rigid : ModeSelectionOptions::Pre::candidates;
  options.keep =
      a.keep == "modes" ? ModeSelectionOptions::Keep::modes : ModeSelectionOptions::Keep::combinations;
  options.end = a.end.value_or(0);
  options.run = run_options(a.method, model.simulation);
  options.progress = [&](const std::string& stage, double part) { progress.update(stage, part); };
  const int body = find_body(model, a.body);
  try {
    return select_mechanism_modes(model, body, options);
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw InputError(model.bodies[static_cast<std::size_t>(body)].mark, error.what());
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

/// The body with all its modes took long to make, and the next selection needs it.
void require_not_candidates(const spec::Model& model, const SelectArguments& a) {
  const auto& candidates = model.bodies[static_cast<std::size_t>(find_body(model, a.body))].flexible;
  if (!candidates || !is_reduced_body(a.output)) return;
  const ReducedBody there = load_reduced_body(a.output);  // it or its mirror image
  if (there.mass == candidates->mass && there.modes == candidates->modes &&
      there.mass_matrix == candidates->mass_matrix && there.stiffness == candidates->stiffness)
    throw UsageError(fmt::format(
        "'{}' has all the modes of '{}' and would be overwritten; choose another name", a.output, a.body));
}

Json to_json(const std::vector<ModeSelection::Mode>& modes) {
  Json list = Json::array();
  for (const ModeSelection::Mode& m : modes)
    list.push_back(
        {{"name", m.name}, {"frequency_hz", m.frequency}, {"participation", 100 * m.participation}});
  return list;
}

std::string to_table(const ModeSelection& s) {
  Table table({"mode", "", "Hz", "participation, %"});
  const auto add = [&](const std::vector<ModeSelection::Mode>& modes, const char* what) {
    for (const ModeSelection::Mode& m : modes)
      table.add(
          {m.name, what, fmt::format("{:.5g}", m.frequency), fmt::format("{:.3g}", 100 * m.participation)});
  };
  add(s.kept, "kept");
  add(s.dropped, "dropped");
  return table.text();
}

int run_select(const SelectArguments& a) {
  const auto start = std::chrono::steady_clock::now();
  const LoadedModel loaded = load(a.model, a.settings);
  require_different(a.model, a.output);
  require_not_candidates(loaded.model->spec(), a);
  for (const std::string& input : loaded.other_files) require_different(input, a.output);
  require_writable_body(a.output);
  Progress progress(!a.json);
  ModeSelection s = select(loaded, a, progress);
  progress.clear();
  if (!s.reached)
    throw Failure(fmt::format(
        "no {} of the {} modes reach {:.3g} %; the last {} are off by {:.3g} %. Allow more{}",
        a.keep == "modes" ? "selection" : "combinations", s.candidates, a.error, s.body.modes,
        100 * s.achieved_error,
        a.keep == "modes" ? "" : (a.pre == "rigid" ? ", or take --pre candidates" : ", or --keep modes")));
  s.body.name = std::filesystem::path(a.output).stem().string();
  save(s.body, a.output);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (a.json) {
    Json json = answer("select");
    json["output"] = a.output;
    json["modes"] = s.body.modes;
    json["candidates"] = s.candidates;
    json["estimated_error"] = 100 * s.estimated_error;
    json["achieved_error"] = 100 * s.achieved_error;
    json["kept"] = to_json(s.kept);
    json["dropped"] = to_json(s.dropped);
    json["runs"] = s.runs;
    json["seconds"] = seconds;
    print_data(to_text(json) + '\n');
    return done;
  }
  print_data(
      fmt::format("{}: {} of {} modes; deflections within {:.3g} % (estimated {:.3g} %, asked {:.3g} "
                  "%), {} runs, {:.1f} s\n\n{}",
                  a.output, s.body.modes, s.candidates, 100 * s.achieved_error, 100 * s.estimated_error,
                  a.error, s.runs, seconds, to_table(s)));
  return done;
}

}  // namespace

Command add_select(CommandLine& program) {
  Parser parser =
      program.add_command("select", "Make a body with as few modes as a mechanism needs, of one with many");
  const auto a = std::make_shared<SelectArguments>();
  parser.add_option("model", a->model, "Model file (YAML) in which the body has all its modes")
      .required()
      .type_name("MODEL");
  parser.add_option("--body", a->body, "The flexible body, by its name in the model")
      .required()
      .type_name("NAME");
  parser
      .add_option("--error", a->error,
                  "Allowed error of the deflections, mean by largest, of the worst frame; default 1")
      .above(0, 100)
      .type_name("PERCENT");
  parser
      .add_option("--keep", a->keep,
                  "combinations of the modes (default: the fewest) or some of the modes as they are")
      .choice({"combinations", "modes"});
  parser
      .add_option("--pre", a->pre,
                  "How the modes are ranked: by a run with all candidates (default), or the response to the "
                  "forces on the rigid body")
      .choice({"candidates", "rigid"});
  parser.add_option("--end", a->end, "End of the runs in s, instead of the model's").above(0).type_name("T");
  add_set_option(parser, a->settings);
  parser.add_option("-o,--output", a->output, "The body with fewer modes").required().type_name("BODY.h5");
  parser.add_flag("--json", a->json, "The same as JSON");
  add_method_options(parser, a->method);
  parser.footer("Example:\n  mimbre select suspension.yaml --body front_left.arm --error 1 -o arm-small.h5");
  return {parser, [a] { return run_select(*a); }};
}

}  // namespace mimbre::app
