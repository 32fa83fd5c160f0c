#include "portable/fmu/extra.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "mimbre/build.h"
#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "portable/fmu/xml.h"

/// Written from FMI-LS-REF 1.0.0-alpha.1 (github.com/modelica/fmi-ls-ref) and the experiments format that it
/// names (github.com/modelica/ma-hs-experiments, 2026). Columns of arrays are as FMPy and the FMI cross-check
/// have them: values with blanks between them.
namespace mimbre::portable {
namespace {

using Role = FmuVariable::Role;

constexpr const char* references_folder = "extra/org.fmi-standard.fmi-ls-ref/";
constexpr const char* own_folder = "extra/org.mimbre/";

/// A field of CSV.
std::string field(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

/// Of each output of the code.
std::vector<Simulation::Channel> channels_of(const FmuCode& fmu, const Simulation& simulation) {
  std::vector<Simulation::Channel> out;
  for (const GeneratedVariable& v : fmu.code.outputs) {
    const bool own = std::any_of(simulation.channels().begin(), simulation.channels().end(),
                                 [&](const ChannelInfo& c) { return c.name == v.name; });
    out.push_back(simulation.channel(own ? v.name : "signal." + v.name));
  }
  return out;
}

/// A run of the library, and when it ended.
struct Reference {
  std::string csv;
  double start = 0, end = 0;  ///< s
};

Reference reference_run(const FmuCode& fmu, const std::shared_ptr<const Model>& model,
                        const RunOptions& options, double seconds) {
  RunOptions fixed = options;
  if (fmu.kind == FmuOptions::Kind::co_simulation && !fmu.with_library) fixed.fixed_cost = true;
  fixed.energies = fixed.validity = fixed.warnings = false;
  Simulation simulation(model, fixed);
  const std::vector<Simulation::Channel> channels = channels_of(fmu, simulation);
  Reference out;
  out.start = simulation.time();
  out.csv = "\"time\"";
  for (const FmuVariable& v : fmu.variables)
    if (v.role == Role::output) out.csv += "," + field(v.name);
  const auto row = [&] {
    out.end = simulation.time();
    out.csv += fmt::format("\n{}", simulation.time());
    for (const FmuVariable& v : fmu.variables)
      for (std::size_t k = 0; k < v.outputs.size(); ++k)
        out.csv += fmt::format("{}{}", k == 0 ? "," : " ",
                               simulation.value(channels[static_cast<std::size_t>(v.outputs[k])]));
  };
  row();
  const long steps = std::lround(seconds / fmu.code.step);
  for (long k = 0; k < steps && simulation.step().ok(); ++k) row();
  out.csv += "\n";
  return out;
}

/// Inputs at their starts, from the first instant to the last. Empty: there are none.
std::string stimuli(const FmuCode& fmu, const Reference& run) {
  std::string head = "\"time\"", values;
  for (const FmuVariable& v : fmu.variables) {
    if (v.role != Role::input) continue;
    head += "," + field(v.name);
    values += fmt::format(",{}", v.start);
  }
  if (values.empty()) return {};
  return fmt::format("{0}\n{2}{1}\n{3}{1}\n", head, values, run.start, run.end);
}

std::string experiments(const FmuCode& fmu, const Reference& run, bool has_stimuli) {
  pugi::xml_document document;
  pugi::xml_node root = begin_xml(document, "Experiments");
  set(root, "name", fmu.code.name);
  set(root, "description", "The first part of the model's own run");
  pugi::xml_node experiment = root.append_child("Experiment");
  set(experiment, "name", "reference");
  set(experiment, "description", "Inputs and parameters at their start values");
  if (fmu.kind == FmuOptions::Kind::model_exchange) set(experiment, "tolerance", 1e-8);
  pugi::xml_node simulation = experiment.append_child("TransientSimulation");
  set(simulation, "startTime", run.start);
  set(simulation, "stopTime", run.end);
  set(simulation, "stepSize", fmu.code.step);
  if (has_stimuli) set(experiment.append_child("Stimuli"), "source", "stimuli.csv");
  set(experiment.append_child("References"), "source", "reference.csv");
  return text_of(document);
}

/// The reduced bodies of a model, with what their files state about their errors. Empty: it has none.
std::string reduced_bodies(const spec::Model& model) {
  nlohmann::ordered_json bodies = nlohmann::ordered_json::array();
  for (const spec::Body& b : model.bodies) {
    if (!b.flexible) continue;
    const ReducedBody& r = *b.flexible;
    nlohmann::ordered_json checks = nlohmann::ordered_json::array();
    bool passed = true;
    for (const Check& c : r.checks) {
      checks.push_back({{"name", c.name}, {"passed", c.passed}, {"detail", c.detail}});
      passed = passed && c.passed;
    }
    nlohmann::ordered_json body{{"name", b.name}, {"modes", r.modes}, {"mass", r.mass}};
    std::vector<double> frequencies;
    for (const double rate : r.eigenfrequencies) frequencies.push_back(rate / (2 * M_PI));
    if (!frequencies.empty()) body["frequencies_Hz"] = frequencies;
    body["passed"] = r.checks.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(passed);
    body["checks"] = std::move(checks);
    bodies.push_back(std::move(body));
  }
  if (bodies.empty()) return {};
  return nlohmann::ordered_json{{"mimbre", build_info().version}, {"reduced_bodies", std::move(bodies)}}.dump(
             2) +
         "\n";
}

struct Related {
  std::string type, source, role, description;
};

std::string manifest(const std::vector<Related>& list) {
  pugi::xml_document document;
  pugi::xml_node root = begin_xml(document, "fmiReferences");
  set(root, "xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest");
  set(root, "fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref");
  set(root, "fmi-ls:fmi-ls-version", "1.0.0-alpha.1");
  set(root, "fmi-ls:fmi-ls-description",
      "Layered Standard providing information on related files included in an FMU.");
  for (const Related& r : list) {
    pugi::xml_node node = root.append_child("Related");
    set(node, "type", r.type);
    set(node, "source", r.source);
    set(node, "role", r.role);
    set(node, "description", r.description);
  }
  return text_of(document);
}

}  // namespace

void add_extra_files(const FmuCode& fmu, const std::shared_ptr<const Model>& model, const RunOptions& options,
                     double seconds, ArchiveFiles& files) {
  const std::string folder = references_folder;
  std::vector<Related> related;
  if (seconds > 0) {
    Reference run = reference_run(fmu, model, options, seconds);
    std::string inputs = stimuli(fmu, run);
    related.push_back({"application/x-ma-hs-experiments", "reference.exp", "experiment/smoke-test",
                       "The first part of the model's own run"});
    related.push_back({"text/csv", "reference.csv", "result", "Outputs as mimbre's library computes them"});
    files.emplace_back(folder + "reference.exp", experiments(fmu, run, !inputs.empty()));
    files.emplace_back(folder + "reference.csv", std::move(run.csv));
    if (!inputs.empty()) {
      related.push_back({"text/csv", "stimuli.csv", "other", "Inputs of the experiment"});
      files.emplace_back(folder + "stimuli.csv", std::move(inputs));
    }
  }
  if (std::string bodies = reduced_bodies(model->spec()); !bodies.empty()) {
    related.push_back({"application/json", "../org.mimbre/reduced-bodies.json", "report",
                       "Validation reports of the reduced flexible bodies"});
    files.emplace_back(std::string(own_folder) + "reduced-bodies.json", std::move(bodies));
  }
  related.push_back(
      {"text/html", "../../documentation/index.html", "document", "Variables and steps of the FMU"});
  files.emplace_back(folder + "fmi-ls-manifest.xml", manifest(related));
}

}  // namespace mimbre::portable
