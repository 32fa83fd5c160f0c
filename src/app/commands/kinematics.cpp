#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <optional>

#include "app/common.h"
#include "app/json.h"
#include "app/start_inputs.h"
#include "app/targets.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/kinematics.h"
#include "mimbre/results.h"
#include "mimbre/usage_error.h"

/// mimbre kinematics: the motion by drives alone, mobility and singular positions.
namespace mimbre::app {
namespace {

struct KinematicsArguments {
  std::string model, output;
  std::vector<std::string> settings, inputs;
  double from = 0;
  std::optional<double> to;
  int steps = 200;
  bool json = false, strict = false;
};

constexpr const char* kind_words[] = {"dead_centre", "change_point", "limit", "reversal"};

Kinematics follow(const LoadedModel& loaded, const KinematicsArguments& given) {
  const Busy busy("kinematics");
  KinematicsOptions options;
  options.start = given.from;
  options.end = given.to;
  options.steps = given.steps;
  options.inputs = start_inputs(given.inputs);
  return kinematics(loaded.model, options);
}

void write_csv(const std::string& path, const Kinematics& found) {
  std::vector<std::string> columns;
  for (const char* quantity : {"", ".velocity", ".acceleration"})
    for (const std::string& name : found.names) columns.push_back(name + quantity);
  CsvWriter csv(path, columns);
  Eigen::VectorXd values(3 * found.position.cols());
  for (Eigen::Index k = 0; k < found.time.size(); ++k) {
    values << found.position.row(k).transpose(), found.velocity.row(k).transpose(),
        found.acceleration.row(k).transpose();
    csv.add(found.time[k], values);
  }
  csv.finish();
}

Json to_json(const Kinematics& found, const std::vector<std::string>& warnings) {
  Json json = answer("kinematics");
  json["coordinates"] = found.coordinates;
  json["equations"] = found.equations;
  json["mobility"] = found.mobility;
  json["drives"] = found.drives;
  json["free"] = found.free;
  json["free_joints"] = found.free_joints;
  json["redundant"] = found.redundant;
  json["redundant_names"] = found.redundant_names;
  json["instants"] = found.time.size();
  json["complete"] = found.complete;
  json["special"] = Json::array();
  for (const SpecialPosition& at : found.special)
    json["special"].push_back({{"kind", kind_words[static_cast<std::size_t>(at.kind)]},
                               {"time", at.time},
                               {"joint", at.joint},
                               {"position", at.position},
                               {"driven", at.driven},
                               {"text", at.text}});
  json["warnings"] = warnings;
  return json;
}

std::string to_text_report(const Kinematics& found) {
  std::string text = fmt::format(
      "{} coordinates of joints, {} equations of loops and constraints, {} redundant{}\nmobility {}, {} "
      "drive{}, {} free{}\n",
      found.coordinates, found.equations, found.redundant,
      found.redundant_names.empty() ? "" : fmt::format(" ('{}')", fmt::join(found.redundant_names, "', '")),
      found.mobility, found.drives, found.drives == 1 ? "" : "s", found.free,
      found.free_joints.empty() ? "" : fmt::format(" ('{}')", fmt::join(found.free_joints, "', '")));
  Table table({"coordinate", "least", "largest", "largest speed", "largest acceleration"});
  for (std::size_t k = 0; k < found.names.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    table.add({found.names[k], fmt::format("{:.6g}", found.position.col(column).minCoeff()),
               fmt::format("{:.6g}", found.position.col(column).maxCoeff()),
               fmt::format("{:.6g}", found.velocity.col(column).cwiseAbs().maxCoeff()),
               fmt::format("{:.6g}", found.acceleration.col(column).cwiseAbs().maxCoeff())});
  }
  if (!found.names.empty()) text += table.text();
  for (const SpecialPosition& at : found.special) text += at.text + '\n';
  return text;
}

int run_kinematics(const KinematicsArguments& given) {
  const bool csv = given.output.ends_with(".csv"), h5 = given.output.ends_with(".h5");
  if (!given.output.empty() && !csv && !h5)
    throw UsageError(fmt::format("-o '{}': a name that ends with .csv or .h5 is needed", given.output));
  const LoadedModel loaded = load(given.model, given.settings);
  if (!given.output.empty()) {
    require_not_read(given.model, loaded, given.output);
    require_no_body(given.output);
    require_writable(given.output);
  }
  const Kinematics found = follow(loaded, given);
  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : found.warnings) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  if (csv) write_csv(given.output, found);
  if (h5) {
    ResultsWriter writer(given.output, found.header);
    for (const ResultsRow& row : found.rows) writer.add(row);
    writer.finish("");
  }
  print_data(given.json ? to_text(to_json(found, warnings)) + '\n' : to_text_report(found));
  if (!found.complete) {
    print_error(fmt::format("the drives can be followed to t = {:.6g} s only: {}",
                            found.time[found.time.size() - 1], found.special.back().text));
    return failed;
  }
  return done_with(!warnings.empty(), given.strict);
}

}  // namespace

Command add_kinematics(CommandLine& program) {
  Parser parser =
      program.add_command("kinematics", "Follow the motion of drives alone; mobility, singular positions");
  const auto given = std::make_shared<KinematicsArguments>();
  parser.add_option("model", given->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, given->settings);
  add_start_inputs_option(parser, given->inputs);
  parser.add_option("--from", given->from, "Start, s").from(0).show_default().type_name("T");
  parser.add_option("--to", given->to, "End, s; default: the model's").from(0).type_name("T");
  parser.add_option("--steps", given->steps, "Intervals between these").within(1, 10000000).show_default();
  parser
      .add_option("-o,--output", given->output,
                  "Write joint coordinates, rates and accelerations (.csv), or channels of the motion (.h5)")
      .type_name("FILE");
  parser.add_flag("--json", given->json, "The same as JSON");
  add_strict_option(parser, given->strict);
  parser.footer(
      "Dead centres, change points, limits of drives and coordinates that turn back are found between the "
      "instants too.\nExit code 3: a drive cannot be followed to the end.\nExample:\n  mimbre kinematics "
      "crank.yaml --to 1 -o motion.csv");
  return {parser, [given] { return run_kinematics(*given); }};
}

}  // namespace mimbre::app
