#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/common.h"
#include "app/json.h"
#include "app/table.h"
#include "mimbre/results.h"
#include "mimbre/stress_history.h"

/// mimbre stress: where and when the bodies of a run were stressed most.
namespace mimbre::app {
namespace {

struct Arguments {
  std::string results;
  std::vector<std::string> bodies;
  int most = 5;
  double apart = 0;
  bool json = false;
};

std::string label_of(const BodyDrawing& body, int node) {
  return body.labels.empty() ? fmt::format("{}", node)
                             : fmt::format("{}", body.labels[static_cast<std::size_t>(node)]);
}

int run(const Arguments& a) {
  const Results results = read_results(a.results);
  std::vector<std::string> names;
  for (const BodyDrawing& body : results.header.bodies)
    if (body.stress.size() > 0) names.push_back(body.name);
  if (names.empty())
    throw InputError(
        Mark{a.results},
        "no body has stress modes; reduce its finite-element model with 'mimbre reduce', and run "
        "the mechanism again");
  for (const std::string& name : a.bodies)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UsageError(
          fmt::format("no body '{}' with stress in the results{}", name, did_you_mean(name, names)));

  Json json = answer("stress");
  json["bodies"] = Json::array();
  std::string text;
  Eigen::Index first = 0;
  for (const BodyDrawing& body : results.header.bodies) {
    const Eigen::Index mine = first;
    first += body.modes;
    if (body.stress.size() == 0) continue;
    if (!a.bodies.empty() && std::find(a.bodies.begin(), a.bodies.end(), body.name) == a.bodies.end())
      continue;
    const double size = (body.points.rowwise().maxCoeff() - body.points.rowwise().minCoeff()).norm();
    const StressHistory history =
        stress_history(body, results.time, results.modes.middleCols(mine, body.modes), a.most,
                       a.apart > 0 ? a.apart : 0.05 * size);
    Json spots = Json::array();
    Table table(
        {"node", "x, m", "y, m", "z, m", "von Mises, MPa", "at, s", "xx", "yy", "zz", "xy", "yz", "zx"});
    for (const HotSpot& spot : history.spots) {
      const Eigen::Vector3d p = body.points.col(spot.node);
      std::vector<std::string> row{label_of(body, spot.node)};
      for (const double x : p) row.push_back(fmt::format("{:.4f}", x));
      row.push_back(fmt::format("{:.4g}", 1e-6 * spot.von_mises));
      row.push_back(fmt::format("{:.4g}", spot.time));
      Json components = Json::object();
      for (int c = 0; c < 6; ++c) {
        row.push_back(fmt::format("{:.3g}", 1e-6 * spot.stress[c]));
        components[stress_components[static_cast<std::size_t>(c)]] = spot.stress[c];
      }
      table.add(row);
      spots.push_back(
          {{"node", body.labels.empty() ? spot.node : body.labels[static_cast<std::size_t>(spot.node)]},
           {"position", {p.x(), p.y(), p.z()}},
           {"von_mises", spot.von_mises},
           {"time", spot.time},
           {"stress", components}});
    }
    json["bodies"].push_back({{"name", body.name}, {"hot_spots", spots}});
    text += fmt::format("{}: largest von Mises stress {:.4g} MPa\n{}\n", body.name,
                        1e-6 * history.envelope.maxCoeff(), table.text());
  }
  print_data(a.json ? to_text(json) + '\n' : text);
  return done;
}

}  // namespace

Command add_stress(CommandLine& program) {
  Parser parser = program.add_command(
      "stress", "Tell where and when the bodies of a run were stressed most (von Mises, on their surfaces)");
  const auto a = std::make_shared<Arguments>();
  parser.add_option("results", a->results, "Results file (HDF5)").required().type_name("RESULTS.h5");
  parser.add_option("--body", a->bodies, "Only this body; several times for several")
      .type_name("NAME")
      .repeated();
  parser.add_option("--spots", a->most, "Hot spots of each body; default 5").within(1, 1000);
  parser
      .add_option("--apart", a->apart,
                  "Least distance between hot spots, m; default: a twentieth of the body's size")
      .from(0, 1e9)
      .type_name("M");
  parser.add_flag("--json", a->json, "Print for machines, in Pa");
  parser.footer("Components are in body axes, MPa.\nExample:\n  mimbre stress run.h5 --body arm --spots 10");
  return {parser, [a] { return run(*a); }};
}

}  // namespace mimbre::app
