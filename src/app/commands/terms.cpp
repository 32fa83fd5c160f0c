#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/targets.h"
#include "app/terminal/progress.h"
#include "app/terminal/table.h"
#include "mimbre/inertia_study.h"
#include "mimbre/unknown_name.h"

/// mimbre terms: which terms of flexible bodies' inertia a model can do without.
namespace mimbre::app {
namespace {

struct TermsArguments {
  std::string model, output, error = "0.1%";
  std::vector<std::string> settings, outputs;
  RunOptions method;
  std::optional<double> end;
  bool json = false;
};

/// "0.1%" or "0.1", in per cent.
double error_of(const std::string& text) {
  std::size_t read = 0;
  double percent = 0;
  try {
    percent = std::stod(text, &read);
  } catch (const std::exception&) {
    read = 0;
  }
  const std::string rest = text.substr(read);
  if (read == 0 || !(rest.empty() || rest == "%") || !(percent > 0 && percent <= 100))
    throw UsageError(
        fmt::format("--error: '{}' is no share above 0 and up to 100 %, for example 0.1%", text));
  return percent / 100;
}

std::string in_percent(double share) { return fmt::format("{:.2g}", 100 * share); }

std::string tables_of(const TermsArguments& a, const InertiaStudy& s, double asked) {
  Table terms({"neglected in all bodies", "", "estimate, %", "error, %", "time of a step"});
  for (const InertiaStudy::Term& t : s.terms) {
    const InertiaTermInfo& info = inertia_terms[static_cast<std::size_t>(t.term)];
    const bool runs = std::isfinite(t.error);
    terms.add({info.name, info.about, in_percent(t.estimate), runs ? in_percent(t.error) : "fails",
               runs ? fmt::format("{:.2f}", t.cost) : ""});
  }
  Table bodies({"body", "does without"});
  for (const InertiaStudy::Body& body : s.bodies)
    bodies.add({body.name,
                body.neglected.empty() ? "-" : fmt::format("{}", fmt::join(names_of(body.neglected), ", "))});
  std::string text = fmt::format("{}\n{}\n", terms.text(), bodies.text());
  text += fmt::format(
      "{} off by up to {} % of {}{} (asked {} %); a step takes {:.2f} of the time, without all terms {:.2f}; "
      "{} runs\n",
      s.outputs.size() == 1 ? "1 output is" : fmt::format("{} outputs are", s.outputs.size()),
      in_percent(s.error), s.outputs.size() == 1 ? "its range" : "their ranges",
      s.worst.empty() ? "" : fmt::format(", '{}'", s.worst), in_percent(asked), s.cost, s.cost_without_any,
      s.runs);
  for (const std::string& note : s.notes) text += fmt::format("Note: {}\n", note);
  if (!a.output.empty()) text += fmt::format("{}: the model without these terms\n", a.output);
  return text;
}

Json json_of(const InertiaStudy& s, double asked) {
  Json json = answer("terms");
  json["asked_error"] = 100 * asked;
  json["error"] = 100 * s.error;
  json["worst"] = s.worst;
  json["cost"] = s.cost;
  json["cost_without_any"] = s.cost_without_any;
  json["runs"] = s.runs;
  json["outputs"] = s.outputs;
  json["notes"] = s.notes;
  for (const InertiaStudy::Term& t : s.terms)
    json["terms"].push_back({{"term", inertia_terms[static_cast<std::size_t>(t.term)].name},
                             {"estimate", 100 * t.estimate},
                             {"error", 100 * t.error},
                             {"cost", t.cost}});
  json["neglected"] = Json::object();
  for (const InertiaStudy::Body& body : s.bodies)
    if (!body.neglected.empty()) json["neglected"][body.name] = names_of(body.neglected);
  return json;
}

int run_terms(const TermsArguments& a) {
  InertiaStudyOptions options;
  options.error = error_of(a.error);
  const LoadedModel loaded = load(a.model, a.settings);
  const spec::Model& model = loaded.model->spec();
  if (!a.output.empty()) {
    require_not_read(a.model, loaded, a.output);
    for (const spec::Body& body : model.bodies)
      if (!body.neglected.empty())
        throw InputError(body.mark,
                         "the model neglects terms already, and a choice cannot be added to it; take "
                         "its section neglected_inertia out first");
    require_writable(a.output);
  }
  options.outputs = a.outputs;
  options.end = a.end.value_or(0);
  options.run = run_options(a.method, model.simulation);
  Progress progress(!a.json);
  options.progress = [&](const std::string& stage, double part) { progress.update(stage, part); };
  InertiaStudy study;
  try {
    study = study_inertia(model, options);
  } catch (const UnknownName& error) {
    throw UsageError(fmt::format("--outputs: {}", error.what()));
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw InputError({a.model, 0, 0}, error.what());
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
  progress.clear();
  if (!a.output.empty()) {
    std::vector<std::string> given = a.settings;
    if (model.simulation.inertia != spec::Simulation::Inertia::integrals)
      given.emplace_back("--inertia integrals");
    write_choice(study, a.model, a.output, given);
  }
  if (a.json) {
    Json json = json_of(study, options.error);
    if (!a.output.empty()) json["output"] = a.output;
    print_data(to_text(json) + '\n');
  } else {
    print_data(tables_of(a, study, options.error));
  }
  return done;
}

}  // namespace

Command add_terms(CommandLine& program) {
  Parser parser = program.add_command(
      "terms", "Find the terms of flexible bodies' inertia that a model can do without, and what they cost");
  const auto a = std::make_shared<TermsArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  parser
      .add_option("--error", a->error,
                  "What an output may be off by, in per cent of its range in the run; default 0.1%")
      .type_name("PERCENT");
  parser
      .add_option(
          "--outputs", a->outputs,
          "Channels that are compared; default: the model's outputs, or the coordinates of its joints")
      .type_name("NAME");
  parser.add_option("--end", a->end, "End of the runs in s, instead of the model's").above(0).type_name("T");
  add_set_option(parser, a->settings);
  parser.add_option("-o,--output", a->output, "A model file: the model without the terms")
      .type_name("FILE.yaml");
  parser.add_flag("--json", a->json, "The same as JSON");
  add_method_options(parser, a->method);
  parser.footer("Example:\n  mimbre terms vehicle.yaml --error 0.1% -o lean.yaml");
  return {parser, [a] { return run_terms(*a); }};
}

}  // namespace mimbre::app
