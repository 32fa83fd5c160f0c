#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/advice.h"
#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/terminal/busy.h"
#include "app/terminal/table.h"
#include "mimbre/assembly.h"
#include "mimbre/method_names.h"
#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "mimbre/text.h"

/// mimbre check: what a model is.
namespace mimbre::app {
namespace {

constexpr Eigen::Index frequencies_shown = 3;

struct CheckArguments {
  std::string model;
  std::vector<std::string> settings;
  RunOptions method;
  bool json = false, strict = false;
};

/// A body as the simulation sees it.
struct BodyLine {
  std::string name;
  double mass = 0;
  int modes = 0;
  bool flexible = false;
  std::vector<double> frequencies;  ///< Hz, the lowest few
};

std::vector<BodyLine> body_lines(const spec::Model& model) {
  std::vector<BodyLine> lines;
  for (const spec::Body& body : model.bodies) {
    BodyLine line{body.name, body.mass, 0, body.flexible != nullptr, {}};
    if (body.flexible) {
      line.mass = body.flexible->mass;
      line.modes = body.flexible->modes;
      const Eigen::VectorXd& omega = body.flexible->eigenfrequencies;
      for (Eigen::Index k = 0; k < std::min(frequencies_shown, omega.size()); ++k)
        line.frequencies.push_back(omega[k] / (2 * std::numbers::pi));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

/// The spheres of a contact, and how many pairs with surfaces and one another can touch.
struct ContactLine {
  std::string name;
  std::int64_t spheres = 0, surfaces = 0, pairs = 0;
  bool swarm = false;
};

std::vector<ContactLine> contact_lines(const spec::Model& model) {
  std::vector<ContactLine> lines;
  for (const spec::Contact& contact : model.contacts) {
    ContactLine line{contact.name, 0, std::ssize(contact.surfaces), 0, contact.swarm};
    for (const spec::Spheres& set : contact.spheres)
      line.spheres += set.surface_of < 0
                          ? std::ssize(set.frames)
                          : model.bodies[static_cast<std::size_t>(set.surface_of)].flexible->nodes.cols();
    line.pairs = line.spheres * line.surfaces;
    if (contact.among) line.pairs += line.spheres * (line.spheres - 1) / 2;
    lines.push_back(std::move(line));
  }
  return lines;
}

/// All results, gathered once for both forms.
struct Description {
  std::vector<BodyLine> bodies;
  std::vector<Model::JointLine> joints;
  std::vector<Model::ConstraintLine> constraint_lines;
  std::vector<ContactLine> contacts;
  double mass = 0;
  int loops = 0;
  int coordinates = 0, elastic_coordinates = 0, constraints = 0, degrees_of_freedom = 0;
  Method method;
  std::vector<spec::Input> inputs;  ///< tunable parameters among them
  Redundancy redundancy;
  std::vector<AssemblyChoice> choices;
  std::vector<std::string> warnings;
};

Description describe(const LoadedModel& loaded, const RunOptions& options) {
  const Model& model = *loaded.model;
  // Sets the model up for its start, so that loops that do not close are reported here and not by the run.
  const std::unique_ptr<Simulation> made = [&] {
    const Busy busy("assembling the mechanism");
    return std::make_unique<Simulation>(loaded.model, options);
  }();
  Simulation& simulation = *made;
  Description d;
  d.bodies = body_lines(model.spec());
  d.joints = model.joint_lines();
  d.constraint_lines = model.constraint_lines();
  d.contacts = contact_lines(model.spec());
  for (const BodyLine& body : d.bodies) d.mass += body.mass;
  d.loops =
      static_cast<int>(std::count_if(d.joints.begin(), d.joints.end(), [](const auto& j) { return j.cut; }));
  d.coordinates = simulation.coordinates();
  d.elastic_coordinates = model.elastic_coordinates();
  d.constraints = simulation.constraints();
  d.degrees_of_freedom = simulation.degrees_of_freedom();
  d.method = simulation.method();
  d.inputs = simulation.inputs();
  d.redundancy = simulation.redundancy();
  d.choices = assembly_choices(model);
  print_advice(simulation);
  d.warnings = loaded.warnings;
  for (const std::string& warning : simulation.warnings()) {
    print_warning(warning);
    d.warnings.push_back(warning);
  }
  return d;
}

Json to_json(const Description& d, const std::string& title) {
  Json json = answer("check");
  json["title"] = title;
  json["step"] = d.method.step;
  json["end"] = d.method.end;
  json["resolved"] = resolved_json(d.method);
  json["mass"] = d.mass;
  json["coordinates"] = d.coordinates;
  json["elastic_coordinates"] = d.elastic_coordinates;
  json["constraints"] = d.constraints;
  json["degrees_of_freedom"] = d.degrees_of_freedom;
  json["redundant_equations"] = d.redundancy.equations;
  json["redundant"] = d.redundancy.joints;
  json["redundant_between_bodies"] = d.redundancy.constraints;
  json["nearly_redundant_equations"] = d.redundancy.nearly;
  json["nearly_redundant"] = d.redundancy.nearly_joints;
  json["nearly_redundant_between_bodies"] = d.redundancy.nearly_constraints;
  json["assembly"] = Json::array();
  for (const AssemblyChoice& c : d.choices) {
    Json coordinates = Json::array();
    for (const AssemblyChoice::Coordinate& k : c.coordinates)
      coordinates.push_back(
          {{"joint", k.joint}, {"coordinate", k.coordinate}, {"unit", k.angle ? "rad" : "m"}});
    json["assembly"].push_back({{"loops", c.loops}, {"coordinates", coordinates}, {"ways", c.ways}});
  }
  json["loops"] = d.loops;
  json["bodies"] = Json::array();
  for (const BodyLine& b : d.bodies)
    json["bodies"].push_back({{"name", b.name},
                              {"mass", b.mass},
                              {"flexible", b.flexible},
                              {"modes", b.modes},
                              {"lowest_frequencies_hz", b.frequencies}});
  json["joints"] = Json::array();
  for (const Model::JointLine& j : d.joints)
    json["joints"].push_back({{"name", j.name},
                              {"type", j.type},
                              {"parent", j.parent},
                              {"child", j.child},
                              {"cut", j.cut},
                              {"coordinates", j.coordinates},
                              {"equations", j.equations}});
  json["between_bodies"] = Json::array();
  for (const Model::ConstraintLine& c : d.constraint_lines)
    json["between_bodies"].push_back(
        {{"name", c.name}, {"type", c.type}, {"between", c.between}, {"equations", c.equations}});
  json["contacts"] = Json::array();
  for (const ContactLine& c : d.contacts)
    json["contacts"].push_back({{"name", c.name},
                                {"spheres", c.spheres},
                                {"surfaces", c.surfaces},
                                {"pairs", c.pairs},
                                {"swarm", c.swarm}});
  json["inputs"] = json["tunables"] = Json::array();
  for (const spec::Input& i : d.inputs) {
    Json entry{{"name", i.name}, {"start", i.start}};
    if (!i.unit.empty()) entry["unit"] = i.unit;
    // JSON has no infinity: a side without a bound is null.
    entry["min"] = std::isfinite(i.min) ? Json(i.min) : Json();
    entry["max"] = std::isfinite(i.max) ? Json(i.max) : Json();
    if (!i.tunable) entry["hold"] = i.hold == spec::Input::Hold::linear ? "linear" : "constant";
    json[i.tunable ? "tunables" : "inputs"].push_back(std::move(entry));
  }
  json["warnings"] = d.warnings;
  return json;
}

/// What redundant constraints mean for the joints concerned.
std::string redundancy_note(const Redundancy& r) {
  if (r.equations == 0) return {};
  constexpr std::size_t named = 12;
  std::vector<std::string> all = r.joints;
  all.insert(all.end(), r.constraints.begin(), r.constraints.end());
  const std::vector<std::string> some(all.begin(), all.begin() + std::min(all.size(), named));
  return fmt::format(
      "\nIn this position {} of the constraint equations {} others. That does not change the motion, but "
      "rigid bodies do not\ndetermine how these {} share their loads; the results contain the smallest "
      "reactions: {}{}\n",
      r.equations, r.equations == 1 ? "repeats" : "repeat",
      r.constraints.empty() ? "joints" : "joints and constraints", fmt::join(some, ", "),
      all.size() > named ? fmt::format(" and {} more", all.size() - named) : "");
}

/// The ways in which loops of bodies that were drawn apart close.
std::string choices_note(const std::vector<AssemblyChoice>& choices) {
  std::string text;
  for (const AssemblyChoice& c : choices) {
    text += fmt::format(
        "\nThe loop{} through {} {} in {} ways; the first is taken, `near` at a joint takes another:\n",
        c.loops.size() == 1 ? "" : "s", fmt::join(c.loops, ", "), c.loops.size() == 1 ? "closes" : "close",
        c.ways.size());
    constexpr std::size_t shown = 6;
    std::vector<std::string> heads{"joint", ""};
    for (std::size_t w = 0; w < std::min(shown, c.ways.size()); ++w)
      heads.push_back(fmt::format("{}", w + 1));
    Table table(heads);
    for (std::size_t k = 0; k < c.coordinates.size(); ++k) {
      const AssemblyChoice::Coordinate& of = c.coordinates[k];
      std::vector<std::string> row{
          of.coordinate > 0 ? fmt::format("{}, coordinate {}", of.joint, of.coordinate) : of.joint,
          of.angle ? "rad" : "m"};
      for (std::size_t w = 0; w + 2 < heads.size(); ++w) row.push_back(fmt::format("{:.4g}", c.ways[w][k]));
      table.add(row);
    }
    text += table.text();
  }
  return text;
}

/// What a run takes.
std::string method_table(const Method& m) {
  Table table({"run", "", ""});
  table.add({"step", fmt::format("{:.6g}", m.step), "s"});
  table.add({"rows every", fmt::format("{:.6g}", m.output_interval > 0 ? m.output_interval : m.step), "s"});
  table.add({"tolerance", fmt::format("{:g}", m.tolerance), ""});
  table.add({"parts of inaccurate steps", fmt::format("{}", m.substeps), m.fixed_cost ? "(fixed cost)" : ""});
  table.add({"method", "", method_line(m)});
  if (!m.chosen.empty()) table.add({"integrator chosen", "", m.chosen});
  return table.text();
}

std::string to_tables(const Description& d, const std::string& title) {
  std::string text = title.empty() ? "" : printable(title) + "\n\n";
  Table bodies({"body", "kg", "", "modes", "lowest frequencies, Hz"});
  for (const BodyLine& b : d.bodies) {
    std::vector<std::string> hertz;
    for (const double f : b.frequencies) hertz.push_back(fmt::format("{:.4g}", f));
    bodies.add({b.name, fmt::format("{:.6g}", b.mass), b.flexible ? "flexible" : "rigid",
                b.flexible ? fmt::format("{}", b.modes) : "", fmt::format("{}", fmt::join(hertz, ", "))});
  }
  Table joints({"joint", "type", "parent", "child", "", "coordinates", "equations"});
  for (const Model::JointLine& j : d.joints)
    joints.add({j.name, j.type, j.parent, j.child, j.cut ? "cut" : "tree", fmt::format("{}", j.coordinates),
                fmt::format("{}", j.equations)});
  Table constraints({"constraint", "type", "between", "equations"});
  for (const Model::ConstraintLine& c : d.constraint_lines)
    constraints.add(
        {c.name, c.type, fmt::format("{}", fmt::join(c.between, ", ")), fmt::format("{}", c.equations)});
  Table contacts({"contact", "spheres", "surfaces", "possible pairs", "looked at"});
  for (const ContactLine& c : d.contacts)
    contacts.add({c.name, fmt::format("{}", c.spheres), fmt::format("{}", c.surfaces),
                  fmt::format("{}", c.pairs), c.swarm ? "those with surfaces, and near ones" : "all"});
  Table model({"model", "", ""});
  const auto line = [&](const char* what, int value) { model.add({what, fmt::format("{}", value), ""}); };
  model.add({"simulated time", fmt::format("{:.6g}", d.method.end),
             d.method.default_end ? "s (the default)" : "s"});
  model.add({"mass", fmt::format("{:.6g}", d.mass), "kg"});
  line("bodies", static_cast<int>(d.bodies.size()));
  line("loops", d.loops);
  line("coordinates", d.coordinates);
  line("  of them elastic", d.elastic_coordinates);
  line("constraint equations", d.constraints);
  line("degrees of freedom", d.degrees_of_freedom);
  if (d.redundancy.equations > 0) line("redundant equations", d.redundancy.equations);
  if (d.redundancy.nearly > 0) line("nearly redundant equations", d.redundancy.nearly);
  const std::string between = d.constraint_lines.empty() ? "" : constraints.text() + '\n';
  const std::string touching = d.contacts.empty() ? "" : contacts.text() + '\n';
  return text + bodies.text() + '\n' + joints.text() + '\n' + between + touching + model.text() + '\n' +
         method_table(d.method) + redundancy_note(d.redundancy) + choices_note(d.choices);
}

int run_check(const CheckArguments& arguments) {
  const LoadedModel loaded = load(arguments.model, arguments.settings);
  const Description description =
      describe(loaded, run_options(arguments.method, loaded.model->spec().simulation));
  const std::string& title = loaded.model->spec().title;
  print_data(arguments.json ? to_text(to_json(description, title)) + '\n' : to_tables(description, title));
  return done_with(!description.warnings.empty(), arguments.strict);
}

}  // namespace

Command add_check(CommandLine& program) {
  Parser parser = program.add_command("check", "Print what a model contains, or all mistakes in it");
  const auto arguments = std::make_shared<CheckArguments>();
  parser.add_option("model", arguments->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, arguments->settings);
  parser.add_flag("--json", arguments->json, "The same as JSON");
  add_strict_option(parser, arguments->strict);
  add_method_options(parser, arguments->method);
  parser.footer("Example:\n  mimbre check pendulum.yaml --set length=2");
  return {parser, [arguments] { return run_check(*arguments); }};
}

}  // namespace mimbre::app
