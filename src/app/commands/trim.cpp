#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands/point_options.h"
#include "app/common.h"
#include "app/json.h"
#include "app/start_inputs.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/trim.h"

/// mimbre trim: what the inputs must be for steady driving, and the outputs then.
namespace mimbre::app {
namespace {

struct TrimArguments {
  std::string model;
  std::vector<std::string> settings;
  PointArguments point;
  bool json = false, strict = false;
};

TrimResult trimmed(const LoadedModel& loaded, const TrimArguments& given) {
  const Busy busy("looking for steady driving", !given.json);
  RunOptions options;
  options.inputs = start_inputs(given.point.inputs);
  try {
    return trim(loaded.model, trim_conditions(given.point), options);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

Json to_json(const TrimResult& found, const std::vector<std::string>& warnings) {
  Json json = answer("trim");
  json["body"] = found.body;
  json["speed"] = found.speed;
  json["yaw_rate"] = found.yaw_rate;
  json["lateral_acceleration"] = found.lateral_acceleration;
  json["sideslip"] = found.sideslip;
  json["inputs"] = json["outputs"] = json["units"] = Json::object();
  for (const TrimResult::Input& input : found.found) json["inputs"][input.name] = input.value;
  for (int k = 0; k < found.output_count; ++k) {
    json["outputs"][found.channels[k].name] = found.values[k];
    json["units"][found.channels[k].name] = found.channels[k].unit;
  }
  json["iterations"] = found.iterations;
  json["residual"] = found.residual;
  json["warnings"] = warnings;
  json["cpu_seconds"] = found.cpu_seconds;
  return json;
}

std::string to_table(const TrimResult& found) {
  Table table({"quantity", "value", "unit", "meaning"});
  const auto add = [&](const std::string& name, double value, const std::string& unit,
                       const std::string& meaning) {
    table.add({name, fmt::format("{:.9g}", value), unit, meaning});
  };
  add("speed", found.speed, "m/s", fmt::format("of body '{}', along the plane across gravity", found.body));
  add("yaw_rate", found.yaw_rate, "rad/s", "to the left");
  add("lateral_acceleration", found.lateral_acceleration, "m/s^2", "yaw rate times speed");
  add("sideslip", found.sideslip, "rad", "from the x axis of the body to its velocity, to the left");
  for (const TrimResult::Input& input : found.found)
    add(input.name, input.value, input.unit, "input that was found");
  for (int k = 0; k < found.output_count; ++k) {
    const ChannelInfo& channel = found.channels[k];
    add(channel.name, found.values[k], channel.unit, channel.meaning);
  }
  return table.text();
}

int run_trim(const TrimArguments& given) {
  const LoadedModel loaded = load(given.model, given.settings, given.json);
  const TrimResult found = trimmed(loaded, given);
  print_data(given.json ? to_text(to_json(found, loaded.warnings)) + '\n' : to_table(found));
  return done_with(!loaded.warnings.empty(), given.strict);
}

}  // namespace

Command add_trim(CommandLine& program) {
  Parser parser =
      program.add_command("trim", "Find the inputs of steady driving, straight on or around a circle");
  const auto given = std::make_shared<TrimArguments>();
  parser.add_option("model", given->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, given->settings);
  add_trim_options(parser, given->point);
  add_start_inputs_option(parser, given->point.inputs);
  parser.add_flag("--json", given->json, "The same as JSON");
  add_strict_option(parser, given->strict);
  parser.footer(
      "The start needs velocities: joints that turn there go on turning. For eigenvalues about that motion\n"
      "give the same options to mimbre modes --at steady.\nExample:\n"
      "  mimbre trim car.yaml --hold speed=20 --hold lateral_acceleration=2 --find steering --find throttle");
  return {parser, [given] { return run_trim(*given); }};
}

}  // namespace mimbre::app
