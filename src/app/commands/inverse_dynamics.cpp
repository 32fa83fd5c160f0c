#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

#include "app/common.h"
#include "app/json.h"
#include "app/start_inputs.h"
#include "app/targets.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/inverse_dynamics.h"
#include "mimbre/results.h"
#include "mimbre/usage_error.h"

/// mimbre inverse-dynamics: the forces that make a prescribed motion.
namespace mimbre::app {
namespace {

struct InverseArguments {
  std::string model, motion, output, flexible = "dynamic";
  std::vector<std::string> settings, inputs, forces;
  double smooth = 0, from = 0;
  std::optional<double> to, step;
  int steps = 200;
  bool json = false, strict = false;
};

InverseDynamicsOptions options_of(const InverseArguments& given, const spec::Model& model) {
  InverseDynamicsOptions options;
  options.smooth = given.smooth;
  options.start = given.from;
  options.end = given.to;
  options.steps = given.steps;
  options.inputs = start_inputs(given.inputs);
  if (given.step) options.step = *given.step;
  options.flexible = given.flexible == "quasistatic" ? InverseDynamicsOptions::Flexible::quasistatic
                                                     : InverseDynamicsOptions::Flexible::dynamic;
  for (const std::string& name : given.forces) options.forces.push_back(find_coordinate(model, name));
  return options;
}

InverseDynamics find_forces(const LoadedModel& loaded, const InverseArguments& given) {
  const InverseDynamicsOptions options = options_of(given, loaded.model->spec());
  std::optional<PrescribedMotion> motion;
  if (!given.motion.empty()) motion = read_motion_table(given.motion, loaded.model->spec());
  const Busy busy("inverse dynamics");
  try {
    return inverse_dynamics(loaded.model, motion ? &*motion : nullptr, options);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

void write_csv(const std::string& path, const InverseDynamics& found) {
  std::vector<std::string> columns;
  for (const char* quantity : {"", ".velocity", ".acceleration", ".force"})
    for (const std::string& name : found.names) columns.push_back(name + quantity);
  CsvWriter csv(path, columns);
  const Eigen::Index n = found.force.cols();
  Eigen::VectorXd values(4 * n);
  for (Eigen::Index k = 0; k < found.time.size(); ++k) {
    values << found.position.row(k).transpose(), found.velocity.row(k).transpose(),
        found.acceleration.row(k).transpose(), found.force.row(k).transpose();
    csv.add(found.time[k], values);
  }
  csv.finish();
}

/// All channels, with the forces in front.
void write_results(const std::string& path, const InverseDynamics& found) {
  ResultsHeader header = found.header;
  std::vector<ChannelInfo> forces;
  for (std::size_t k = 0; k < found.names.size(); ++k)
    forces.push_back({found.names[k] + ".force", found.units[k],
                      fmt::format("force on coordinate '{}' that makes the motion", found.names[k])});
  header.channels.insert(header.channels.begin(), forces.begin(), forces.end());
  ResultsWriter writer(path, header);
  for (std::size_t k = 0; k < found.rows.size(); ++k) {
    ResultsRow row = found.rows[k];
    Eigen::VectorXd all(found.force.cols() + row.channels.size());
    all << found.force.row(static_cast<Eigen::Index>(k)).transpose(), row.channels;
    row.channels = all;
    writer.add(row);
  }
  writer.finish("");
}

Json to_json(const InverseDynamics& found, const std::vector<std::string>& warnings) {
  Json json = answer("inverse-dynamics");
  json["instants"] = found.time.size();
  json["free"] = found.free;
  json["redundant"] = found.redundant;
  json["residual"] = found.residual;
  json["forces"] = Json::object();
  for (std::size_t k = 0; k < found.names.size(); ++k) {
    const Eigen::VectorXd force = found.force.col(static_cast<Eigen::Index>(k));
    json["forces"][found.names[k]] = {
        {"unit", found.units[k]}, {"least", force.minCoeff()}, {"largest", force.maxCoeff()}};
  }
  json["warnings"] = warnings;
  return json;
}

std::string to_table(const InverseDynamics& found) {
  Table table({"coordinate", "unit", "least force", "largest force", "largest speed"});
  for (std::size_t k = 0; k < found.names.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    table.add({found.names[k], found.units[k], fmt::format("{:.6g}", found.force.col(column).minCoeff()),
               fmt::format("{:.6g}", found.force.col(column).maxCoeff()),
               fmt::format("{:.6g}", found.velocity.col(column).cwiseAbs().maxCoeff())});
  }
  return table.text();
}

void check_output(const InverseArguments& given, const LoadedModel& loaded) {
  if (given.output.empty()) return;
  require_not_read(given.model, loaded, given.output);
  if (!given.motion.empty()) require_different(given.motion, given.output);
  require_no_body(given.output);
  require_writable(given.output);
}

int run_inverse_dynamics(const InverseArguments& given) {
  const bool csv = given.output.ends_with(".csv"), h5 = given.output.ends_with(".h5");
  if (!given.output.empty() && !csv && !h5)
    throw UsageError(fmt::format("-o '{}': a name that ends with .csv or .h5 is needed", given.output));
  const LoadedModel loaded = load(given.model, given.settings);
  check_output(given, loaded);
  const InverseDynamics found = find_forces(loaded, given);
  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : found.warnings) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  if (csv) write_csv(given.output, found);
  if (h5) write_results(given.output, found);
  print_data(given.json ? to_text(to_json(found, warnings)) + '\n' : to_table(found));
  return done_with(!warnings.empty(), given.strict);
}

}  // namespace

Command add_inverse_dynamics(CommandLine& program) {
  Parser parser = program.add_command(
      "inverse-dynamics", "Find the forces that make a prescribed motion, of drives or from a table");
  const auto given = std::make_shared<InverseArguments>();
  parser.add_option("model", given->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, given->settings);
  add_start_inputs_option(parser, given->inputs);
  parser.add_option("--motion", given->motion, "Table of joint coordinates over time, besides drives")
      .type_name("FILE.csv");
  parser.add_option("--smooth", given->smooth, "Smooth motions of the table that are shorter than this, s")
      .from(0)
      .type_name("S");
  parser
      .add_option("--force", given->forces,
                  "A joint along which a force is looked for; default: where the motion is prescribed")
      .repeated()
      .type_name("JOINT");
  parser.add_option("--flexible", given->flexible, "How flexible bodies follow")
      .one_of({"dynamic", "quasistatic"})
      .show_default();
  parser.add_option("--from", given->from, "Without a table: start, s").from(0).type_name("T");
  parser.add_option("--to", given->to, "Without a table: end, s; default: the model's")
      .from(0)
      .type_name("T");
  parser.add_option("--steps", given->steps, "Without a table: intervals between these")
      .within(1, 10000000)
      .show_default();
  parser.add_option("--step", given->step, "Step by which flexible bodies follow, s; default: the model's")
      .above(0)
      .type_name("S");
  parser
      .add_option("-o,--output", given->output, "Write coordinates and forces (.csv), or all channels (.h5)")
      .type_name("FILE");
  parser.add_flag("--json", given->json, "The same as JSON");
  add_strict_option(parser, given->strict);
  parser.footer(
      "The table has a column `time` and columns named after joints (JOINT.1 where a joint has several "
      "coordinates), if\nknown with JOINT.velocity and JOINT.acceleration. Otherwise the motion is a spline "
      "of "
      "degree 5.\nExample:\n  mimbre inverse-dynamics robot.yaml --motion path.csv -o forces.csv");
  return {parser, [given] { return run_inverse_dynamics(*given); }};
}

}  // namespace mimbre::app
