#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/statics.h"

/// mimbre static: the model's outputs at its static equilibrium.
namespace mimbre::app {
namespace {

struct StaticArguments {
  std::string model;
  std::vector<std::string> settings;
  RunOptions method;
  bool json = false, strict = false;
};

Json to_json(const StaticResult& result, const Json& method, const std::vector<std::string>& warnings) {
  Json json = answer("static");
  json["formulation"] = method.at("formulation");
  json["inertia"] = method.at("inertia");
  json["outputs"] = json["units"] = Json::object();
  for (int k = 0; k < result.output_count; ++k) {
    json["outputs"][result.channels[k].name] = result.values[k];
    json["units"][result.channels[k].name] = result.channels[k].unit;
  }
  json["iterations"] = result.iterations;
  json["residual"] = result.residual;
  json["stable"] = result.stable;
  json["warnings"] = warnings;
  json["cpu_seconds"] = result.cpu_seconds;
  return json;
}

std::string to_table(const StaticResult& result) {
  Table table({"output", "value", "unit", "meaning"});
  for (int k = 0; k < result.output_count; ++k) {
    const ChannelInfo& channel = result.channels[k];
    table.add({channel.name, fmt::format("{:.9g}", result.values[k]), channel.unit, channel.meaning});
  }
  return table.text();
}

StaticResult equilibrium(const LoadedModel& loaded, const RunOptions& options) {
  const Busy busy("looking for the equilibrium");
  try {
    return static_equilibrium(loaded.model, options);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

int run_static(const StaticArguments& arguments) {
  const LoadedModel loaded = load(arguments.model, arguments.settings);
  const spec::Simulation& given = loaded.model->spec().simulation;
  const RunOptions options = run_options(arguments.method, given);
  const StaticResult result = equilibrium(loaded, options);
  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : result.warnings) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  const Json method = method_json(resolve_method(given, options));
  print_data(arguments.json ? to_text(to_json(result, method, warnings)) + '\n' : to_table(result));
  return done_with(!warnings.empty(), arguments.strict);
}

}  // namespace

Command add_static(CommandLine& program) {
  Parser parser = program.add_command("static", "Find the static equilibrium and print the outputs there");
  const auto arguments = std::make_shared<StaticArguments>();
  parser.add_option("model", arguments->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, arguments->settings);
  parser.add_flag("--json", arguments->json, "The same as JSON");
  add_strict_option(parser, arguments->strict);
  // At rest it does not matter how constraints and steps are made.
  add_method_options(parser, arguments->method, {.steps = false});
  parser.footer("Example:\n  mimbre static suspension.yaml --json");
  return {parser, [arguments] { return run_static(*arguments); }};
}

}  // namespace mimbre::app
