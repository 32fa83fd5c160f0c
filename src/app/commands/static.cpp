#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "app/commands/path_output.h"
#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/targets.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/buckling.h"
#include "mimbre/statics.h"
#include "mimbre/usage_error.h"

/// mimbre static: the model's outputs at its static equilibrium, or its buckling loads.
namespace mimbre::app {
namespace {

struct StaticArguments {
  std::string model;
  std::vector<std::string> settings;
  RunOptions method;
  std::vector<std::string> loads;
  int count = 3;
  bool json = false, strict = false, buckling = false;
  PathArguments path;
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
  json["search"] = result.sparse ? "sparse" : "dense";
  json["load_steps"] = result.load_steps;
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
  if (result.load_steps > 0)
    return table.text() +
           fmt::format(
               "found by applying the forces in {} steps: the search with all of them at once did not "
               "converge\n",
               result.load_steps);
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

Buckling buckling_of(const LoadedModel& loaded, const BucklingOptions& options) {
  const Busy busy("looking for buckling loads");
  try {
    return buckling(loaded.model, options);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

Json to_json(const Buckling& found, const std::vector<std::string>& warnings) {
  Json json = answer("static");
  json["loads"] = found.loads;
  json["buckling"] = Json::array();
  for (const BucklingMode& mode : found.modes) {
    Json one{{"factor", mode.factor}, {"text", mode.text}, {"shape", Json::object()}};
    for (std::size_t k = 0; k < found.coordinates.size(); ++k)
      one["shape"][found.coordinates[k]] = mode.shape[static_cast<Eigen::Index>(k)];
    json["buckling"].push_back(std::move(one));
  }
  json["nonlinear"] = found.nonlinear;
  json["warnings"] = warnings;
  return json;
}

std::string to_table(const Buckling& found) {
  Table table({"factor", "of", "shares of the elastic energy"});
  for (const BucklingMode& mode : found.modes)
    table.add(
        {fmt::format("{:.6g}", mode.factor), fmt::format("{}", fmt::join(found.loads, ", ")), mode.text});
  return table.text();
}

int run_buckling(const LoadedModel& loaded, const StaticArguments& arguments) {
  BucklingOptions options;
  options.loads = arguments.loads;
  options.count = arguments.count;
  const Buckling found = buckling_of(loaded, options);
  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : found.warnings) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  print_data(arguments.json ? to_text(to_json(found, warnings)) + '\n' : to_table(found));
  return done_with(!warnings.empty(), arguments.strict);
}

int run_static(const StaticArguments& arguments) {
  const PathArguments& path = arguments.path;
  if (!arguments.buckling && !path.wanted && !arguments.loads.empty())
    throw UsageError("--load selects the loads of --buckling or --path, which are missing");
  if (arguments.buckling && path.wanted) throw UsageError("--buckling and --path exclude each other");
  if (!path.wanted) refuse_path_options(path);
  if (path.wanted && (arguments.method.formulation || arguments.method.inertia))
    throw UsageError("--path works in relative coordinates with shape integrals, whatever the options state");
  const LoadedModel loaded = load(arguments.model, arguments.settings);
  if (path.wanted) {
    if (!path.output.empty()) {
      require_not_read(arguments.model, loaded, path.output);
      require_writable(path.output);
    }
    return run_path(loaded, path, arguments.loads, arguments.json, arguments.strict);
  }
  if (arguments.buckling) return run_buckling(loaded, arguments);
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
  parser.add_flag("--buckling", arguments->buckling, "Find the factors of the loads at which it buckles");
  parser
      .add_option("--load", arguments->loads,
                  "With --buckling, --path: a load that grows, or gravity; default: all loads, or gravity")
      .repeated()
      .type_name("LOAD");
  parser.add_option("--count", arguments->count, "With --buckling: factors at most, of each sign")
      .within(1, 1000)
      .show_default();
  add_path_options(parser, arguments->path);
  parser.add_flag("--json", arguments->json, "The same as JSON");
  add_strict_option(parser, arguments->strict);
  // At rest it does not matter how constraints and steps are made.
  add_method_options(parser, arguments->method, {.steps = false});
  parser.footer(
      "Example:\n  mimbre static suspension.yaml --json\n  mimbre static column.yaml --buckling --load "
      "press\n  mimbre static column.yaml --path --to 2 -o path.csv");
  return {parser, [arguments] { return run_static(*arguments); }};
}

}  // namespace mimbre::app
