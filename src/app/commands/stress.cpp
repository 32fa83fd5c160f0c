#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "app/common.h"
#include "app/json.h"
#include "app/targets.h"
#include "app/terminal/table.h"
#include "mimbre/reduced_body.h"
#include "mimbre/results.h"
#include "mimbre/section_history.h"
#include "mimbre/stress_history.h"

/// mimbre stress: where and when the bodies of a run were stressed most, and the loads in sections of bars.
namespace mimbre::app {
namespace {

struct StressArguments {
  std::string results;
  std::vector<std::string> bodies;
  int most = 5;
  double apart = 0;
  std::string loads, envelopes;
  bool json = false;
};

std::string label_of(const BodyDrawing& body, int node) {
  return body.labels.empty() ? fmt::format("{}", node)
                             : fmt::format("{}", body.labels[static_cast<std::size_t>(node)]);
}

/// Bodies with stress modes, or with sections of which something was recorded.
std::vector<std::string> bodies_with_stress(const Results& results) {
  const ResultsHeader& header = results.header;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < header.bodies.size(); ++k) {
    const auto here = [&](const RecordedSection& s) { return s.body == static_cast<int>(k); };
    if (header.bodies[k].stress.size() > 0 ||
        std::any_of(header.sections.begin(), header.sections.end(), here))
      names.push_back(header.bodies[k].name);
  }
  return names;
}

/// The hot spots of a body that has stress modes, for people added to `text`.
Json hot_spots_of(const BodyDrawing& body, const Eigen::VectorXd& time,
                  const Eigen::Ref<const Eigen::MatrixXd>& amplitudes, const StressArguments& a,
                  std::string& text) {
  const double size = (body.points.rowwise().maxCoeff() - body.points.rowwise().minCoeff()).norm();
  const StressHistory history =
      stress_history(body, time, amplitudes, a.most, a.apart > 0 ? a.apart : 0.05 * size);
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
  text += fmt::format("{}: largest von Mises stress {:.4g} MPa\n{}\n", body.name,
                      1e-6 * history.envelope.maxCoeff(), table.text());
  return spots;
}

struct Unit {
  const char* name;
  double size;  ///< in SI units
};
Unit unit_of(std::size_t component) {
  if (component < 3) return {"N", 1};
  return component < von_mises_of_section ? Unit{"N m", 1} : Unit{"MPa", 1e6};
}

/// "span at 0.45 m"
std::string section_name(const RecordedSection& section) {
  return fmt::format("{} at {:.4g} m", section.bar, section.along);
}

/// Of one body the envelopes of its sections, and for people the extremes among them.
Json envelopes_of(const Results& results, int body, std::string& text) {
  struct Extreme {
    double value = 0, time = 0;
    const RecordedSection* section = nullptr;
  };
  std::array<std::array<Extreme, 2>, section_components.size()> ends{};
  Json sections = Json::array();
  for (const RecordedSection& section : results.header.sections) {
    if (section.body != body) continue;
    Json components = Json::object();
    for (std::size_t c = 0; c < section.channels.size(); ++c) {
      if (section.channels[c] < 0) continue;
      const Extremes e = extremes(results, section.channels[c]);
      components[section_components[c]] = {
          {"min", e.least}, {"min_time", e.least_time}, {"max", e.most}, {"max_time", e.most_time}};
      auto& [least, most] = ends[c];
      if (!least.section || e.least < least.value) least = {e.least, e.least_time, &section};
      if (!most.section || e.most > most.value) most = {e.most, e.most_time, &section};
    }
    sections.push_back({{"bar", section.bar},
                        {"element", section.element},
                        {"end", section.end ? "end" : "start"},
                        {"along", section.along},
                        {"envelopes", components}});
  }
  if (sections.empty()) return sections;
  Table table({"sections", "unit", "min", "at, s", "in", "max", "at, s", "in"});
  for (std::size_t c = 0; c < ends.size(); ++c) {
    if (!ends[c][0].section) continue;
    const Unit unit = unit_of(c);
    std::vector<std::string> row{section_components[c], unit.name};
    for (const Extreme& e : ends[c]) {
      row.push_back(fmt::format("{:.4g}", e.value / unit.size));
      row.push_back(fmt::format("{:.4g}", e.time));
      row.push_back(section_name(*e.section));
    }
    table.add(row);
  }
  text +=
      fmt::format("{}: loads in {} sections of its bars\n{}\n",
                  results.header.bodies[static_cast<std::size_t>(body)].name, sections.size(), table.text());
  return sections;
}

void check_tables(const StressArguments& a) {
  for (const std::string& table : {a.loads, a.envelopes}) {
    if (table.empty()) continue;
    require_different(a.results, table);
    require_no_body(table);
    require_writable(table);
  }
  if (!a.loads.empty() && !a.envelopes.empty()) require_different(a.loads, a.envelopes);
}

int run_stress(const StressArguments& a) {
  check_tables(a);
  const Results results = read_results(a.results);
  const std::vector<std::string> names = bodies_with_stress(results);
  if (names.empty())
    throw InputError(
        Mark{a.results},
        "no body has stress modes, and no section loads were recorded; reduce a body's finite-element model "
        "with 'mimbre reduce', or ask for an output {name: loads, section_force: BODY} of a body of bars, "
        "and "
        "run the mechanism again");
  for (const std::string& name : a.bodies)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UsageError(
          fmt::format("no body '{}' with stress in the results{}", name, did_you_mean(name, names)));
  if ((!a.loads.empty() || !a.envelopes.empty()) && results.header.sections.empty())
    throw UsageError(
        "no section loads were recorded; ask for an output {name: loads, section_force: BODY}, and run the "
        "mechanism again");
  if (!a.loads.empty()) write_section_loads(results, a.bodies, a.loads);
  if (!a.envelopes.empty()) write_section_envelopes(results, a.bodies, a.envelopes);

  Json json = answer("stress");
  json["bodies"] = Json::array();
  std::string text;
  Eigen::Index first = 0;
  int index = -1;
  for (const BodyDrawing& body : results.header.bodies) {
    ++index;
    const Eigen::Index mine = first;
    first += body.modes;
    if (std::find(names.begin(), names.end(), body.name) == names.end()) continue;
    if (!a.bodies.empty() && std::find(a.bodies.begin(), a.bodies.end(), body.name) == a.bodies.end())
      continue;
    Json entry{{"name", body.name}};
    if (body.stress.size() > 0)
      entry["hot_spots"] =
          hot_spots_of(body, results.time, results.modes.middleCols(mine, body.modes), a, text);
    if (Json sections = envelopes_of(results, index, text); !sections.empty())
      entry["sections"] = std::move(sections);
    json["bodies"].push_back(std::move(entry));
  }
  print_data(a.json ? to_text(json) + '\n' : text);
  return done;
}

}  // namespace

Command add_stress(CommandLine& program) {
  Parser parser = program.add_command(
      "stress", "Print the largest stresses of a run, where and when, and the loads in sections of bars");
  const auto a = std::make_shared<StressArguments>();
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
  parser
      .add_option(
          "--loads", a->loads,
          "Write the loads in the sections of bars over time as CSV, a line for each section and time")
      .type_name("FILE.csv");
  parser
      .add_option("--envelopes", a->envelopes,
                  "Write the smallest and largest of each load in each section, and when, as CSV")
      .type_name("FILE.csv");
  parser.add_flag("--json", a->json, "Print for machines, in Pa");
  parser.footer(
      "Components of stress are in body axes, MPa; loads in the axes of their bar, on the part before the "
      "section.\nExample:\n  mimbre stress run.h5 --body arm --spots 10\n"
      "  mimbre stress run.h5 --loads loads.csv --envelopes envelopes.csv");
  return {parser, [a] { return run_stress(*a); }};
}

}  // namespace mimbre::app
