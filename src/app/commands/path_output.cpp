#include "app/commands/path_output.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "app/json.h"
#include "app/terminal/progress.h"
#include "app/terminal/table.h"
#include "mimbre/equilibrium_path.h"
#include "mimbre/usage_error.h"

namespace mimbre::app {
namespace {

std::string kind_of(const PathPoint& point) { return path_point_words[static_cast<std::size_t>(point.kind)]; }

EquilibriumPath found_path(const LoadedModel& loaded, const PathArguments& given,
                           const std::vector<std::string>& loads) {
  EquilibriumPathOptions options;
  options.loads = loads;
  options.from = given.from.value_or(options.from);
  options.to = given.to.value_or(options.to);
  options.most_points = given.points.value_or(options.most_points);
  options.bifurcations = given.bifurcations.value_or(options.bifurcations);
  Progress progress(true);
  options.progress = [&](double factor, int points) {
    progress.update(fmt::format("factor {:.4g}, {} equilibria", factor, points),
                    std::min(1.0, std::abs((factor - options.from) / (options.to - options.from))));
  };
  try {
    return equilibrium_path(loaded.model, options);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

Json to_json(const EquilibriumPath& path, const std::vector<std::string>& warnings) {
  const std::vector<int> shown = shown_channels(path);
  Json json = answer("static");
  json["loads"] = path.loads;
  json["units"] = Json::object();
  for (const int k : shown)
    json["units"][path.channels[static_cast<std::size_t>(k)].name] =
        path.channels[static_cast<std::size_t>(k)].unit;
  json["branches"] = Json::array();
  for (const PathBranch& branch : path.branches) {
    Json one{{"parent", branch.parent}, {"sense", branch.sense}, {"end", branch.end}};
    if (branch.parent >= 0) one["leaves_at"] = branch.leaves_at;
    one["points"] = Json::array();
    for (const PathPoint& point : branch.points) {
      Json at{{"factor", point.factor}, {"unstable", point.unstable}, {"outputs", Json::object()}};
      if (point.kind != PathPoint::Kind::regular) {
        at["point"] = kind_of(point);
        at["moving"] = point.moving;
      }
      for (const int k : shown)
        at["outputs"][path.channels[static_cast<std::size_t>(k)].name] = point.values[k];
      one["points"].push_back(std::move(at));
    }
    json["branches"].push_back(std::move(one));
  }
  json["warnings"] = warnings;
  json["cpu_seconds"] = path.cpu_seconds;
  return json;
}

std::string to_table(const EquilibriumPath& path) {
  const std::vector<int> shown = shown_channels(path);
  std::string text;
  for (std::size_t b = 0; b < path.branches.size(); ++b) {
    const PathBranch& branch = path.branches[b];
    if (branch.parent < 0)
      text += fmt::format("equilibria under a factor of {}\n", fmt::join(path.loads, ", "));
    else
      text += fmt::format("\nbranch {}, which leaves branch {} at a factor of {:.6g}, {} the motion there\n",
                          b, branch.parent, branch.leaves_at, branch.sense > 0 ? "along" : "against");
    std::vector<std::string> head{"factor"};
    for (const int k : shown)
      head.push_back(fmt::format("{}, {}", path.channels[static_cast<std::size_t>(k)].name,
                                 path.channels[static_cast<std::size_t>(k)].unit));
    head.insert(head.end(), {"unstable", ""});
    Table table(head);
    for (const PathPoint& point : branch.points) {
      std::vector<std::string> row{fmt::format("{:.6g}", point.factor)};
      for (const int k : shown) row.push_back(fmt::format("{:.6g}", point.values[k]));
      row.push_back(fmt::format("{}", point.unstable));
      row.push_back(
          point.kind == PathPoint::Kind::regular ? "" : fmt::format("{}: {}", kind_of(point), point.moving));
      table.add(row);
    }
    text += table.text();
    if (!branch.end.empty()) text += fmt::format("ends here: {}\n", branch.end);
  }
  return text;
}

}  // namespace

void add_path_options(Parser& parser, PathArguments& a) {
  parser.add_flag("--path", a.wanted, "Follow the equilibria while loads grow, also beyond buckling");
  parser.add_option("--from", a.from, "With --path: factor of the loads at first; default: 0");
  parser.add_option("--to", a.to, "With --path: factor at last; default: 1");
  parser.add_option("--points", a.points, "With --path: equilibria of each branch at most; default: 200")
      .within(2, 100000);
  parser
      .add_option("--bifurcations", a.bifurcations,
                  "With --path: bifurcations to branch at, at most; default: 1")
      .within(0, 100);
  parser.add_option("-o,--output", a.output, "With --path: write the equilibria as CSV")
      .type_name("FILE.csv");
}

void refuse_path_options(const PathArguments& a) {
  if (a.from || a.to || a.points || a.bifurcations || !a.output.empty())
    throw UsageError("--from, --to, --points, --bifurcations and -o are options of --path, which is missing");
}

int run_path(const LoadedModel& loaded, const PathArguments& arguments, const std::vector<std::string>& loads,
             bool json, bool strict) {
  const EquilibriumPath path = found_path(loaded, arguments, loads);
  std::vector<std::string> warnings = loaded.warnings;
  for (const std::string& warning : path.warnings) {
    print_warning(warning);
    warnings.push_back(warning);
  }
  try {
    if (!arguments.output.empty()) write_csv(path, arguments.output);
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
  print_data(json ? to_text(to_json(path, warnings)) + '\n' : to_table(path));
  return done_with(!warnings.empty(), strict);
}

}  // namespace mimbre::app
