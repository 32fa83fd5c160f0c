#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "app/commands/interfaces.h"
#include "app/common.h"
#include "app/further_modes.h"
#include "app/json.h"
#include "app/reduce_key.h"
#include "app/targets.h"
#include "app/terminal/progress.h"
#include "app/terminal/table.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"
#include "mimbre/report.h"
#include "mimbre/result_cache.h"
#include "mimbre/run_summary.h"

/// mimbre reduce: a finite-element model as a body.
namespace mimbre::app {
namespace {

namespace fs = std::filesystem;

struct ReduceArguments {
  std::string input, output, report, mass, nodes, dofs, user_modes, stress, stress_nodes;
  InterfaceOptions interfaces;
  std::vector<std::string> materials, densities, thicknesses, loads;
  int modes = 10, free_modes = 10;
  std::string frame = "tangent", units = "SI", basis = "craig_bampton", mass_matrix = "consistent",
              beam_torsion = "section";
  double damping = 0, max_frequency = 0, krylov_frequency = 0, effective_mass = 0;
  bool json = false, stiffening = false, no_cache = false;
};

std::string formats() {
  return "Inputs, by their endings:\n" + fe::mesh_formats_help() +
         "  .mtx, .npz            stiffness as Matrix Market, Abaqus or SciPy matrix: needs --mass and "
         "--nodes\n"
         "  .bdf, .dat, .nas      Nastran bulk data: mesh, materials, properties\n"
         "  .pch, .dmig, .bdf     Nastran DMIG and GRID cards, where there are no elements (--nodes FILE: "
         "the "
         "cards'\n"
         "                        own file)\n";
}

fe::FileUnits units_of(const std::string& name) {
  if (name == "mm") return {1e-3, 1e3, 1};
  if (name == "in") return {0.0254, 175.126835, 1};  // inch, lbf s²/in, s
  return {};
}

/// "NAME=E,nu,rho" or "E,nu,rho" (SI).
std::vector<fe::NamedMaterial> materials_of(const std::vector<std::string>& texts) {
  std::vector<fe::NamedMaterial> materials;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    fe::NamedMaterial material;
    material.name = equals == std::string::npos ? "" : text.substr(0, equals);
    double* const values[] = {&material.material.young, &material.material.poisson,
                              &material.material.density};
    std::istringstream rest(equals == std::string::npos ? text : text.substr(equals + 1));
    std::string word;
    std::size_t count = 0;
    for (; count < 3 && std::getline(rest, word, ','); ++count) {
      try {
        std::size_t used = 0;
        *values[count] = std::stod(word, &used);
        if (used != word.size()) throw std::invalid_argument(word);
      } catch (const std::exception&) {
        throw UsageError(fmt::format("--material '{}': '{}' is not a number", text, word));
      }
    }
    if (count != 3 || rest.rdbuf()->in_avail() > 0)
      throw UsageError(
          fmt::format("--material '{}': Young's modulus, Poisson's ratio and density are needed, "
                      "as 2.1e11,0.3,7850",
                      text));
    materials.push_back(std::move(material));
  }
  return materials;
}

/// "NAME=VALUE" or "VALUE" (SI).
std::vector<fe::NamedNumber> numbers_of(const char* option, const std::vector<std::string>& texts) {
  std::vector<fe::NamedNumber> numbers;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    fe::NamedNumber number{equals == std::string::npos ? "" : text.substr(0, equals), 0};
    const std::string value = equals == std::string::npos ? text : text.substr(equals + 1);
    try {
      std::size_t used = 0;
      number.value = std::stod(value, &used);
      if (used != value.size()) throw std::invalid_argument(value);
    } catch (const std::exception&) {
      throw UsageError(fmt::format("{} '{}': '{}' is not a number", option, text, value));
    }
    numbers.push_back(std::move(number));
  }
  return numbers;
}

fe::FeModel read_input(const ReduceArguments& a) {
  try {
    return fe::read_model(a.input,
                          {a.mass, a.nodes, a.dofs, materials_of(a.materials),
                           numbers_of("--density", a.densities), numbers_of("--thickness", a.thicknesses),
                           a.beam_torsion == "brick" ? fe::BeamTorsion::brick : fe::BeamTorsion::section},
                          units_of(a.units));
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();
    throw UsageError(message.ends_with("is not known") ? message + '\n' + formats() : message);
  }
}

Json to_json(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double x : values) list.push_back(x);
  return list;
}

fe::ModelReduction::Frame frame_of(const std::string& name) {
  using Frame = fe::ModelReduction::Frame;
  if (name == "mean_axis") return Frame::mean_axis;
  return name == "centre_of_mass" ? Frame::centre_of_mass : Frame::tangent;
}

fe::ModelReduction::Basis basis_of(const std::string& name) {
  using Basis = fe::ModelReduction::Basis;
  if (name == "free_interface") return Basis::free_interface;
  if (name == "attachment") return Basis::attachment;
  if (name == "modal_truncation") return Basis::modal_truncation;
  return name == "krylov" ? Basis::krylov : Basis::craig_bampton;
}

/// A list per mode.
Json to_json(const Eigen::MatrixXd& columns) {
  Json list = Json::array();
  for (Eigen::Index k = 0; k < columns.cols(); ++k) list.push_back(to_json(Eigen::VectorXd(columns.col(k))));
  return list;
}

/// The number at `k` as a table has it; nothing beyond the end.
std::string entry(const Json& list, std::size_t k, const char* format = "{:.6g}") {
  if (k >= list.size()) return {};
  return list[k].is_number() ? fmt::format(fmt::runtime(format), list[k].get<double>()) : "nan";
}

std::string effective_masses(const Json& summary) {
  const Json& masses = summary.at("effective_mass");
  if (masses.empty()) return {};
  Table table({"mode", "Hz", "x, %", "y, %", "z, %", "rx, %", "ry, %", "rz, %"});
  std::vector<double> sums(6, 0);
  const auto add = [&](const std::string& name, const std::string& hertz, const Json& shares) {
    std::vector<std::string> row{name, hertz};
    for (std::size_t c = 0; c < shares.size(); ++c) row.push_back(entry(shares, c, "{:.2f}"));
    table.add(row);
  };
  for (std::size_t k = 0; k < masses.size(); ++k) {
    add(fmt::format("{}", k + 1), entry(summary.at("frequencies_hz"), k), masses[k]);
    for (std::size_t c = 0; c < sums.size(); ++c)
      if (masses[k][c].is_number()) sums[c] += masses[k][c].get<double>();
  }
  add("sum", "", sums);
  return "Effective mass of the modes with interfaces held\n" + table.text() + '\n';
}

std::string body_name(const ReduceArguments& a) { return fs::path(a.output).stem().string(); }

void print_line(const Json& text) { fmt::print(stderr, "{}\n", text.get<std::string>()); }

/// Makes the body and writes it; the summary of it, and the warnings.
Json reduce_anew(const ReduceArguments& a) {
  Progress progress(!a.json);
  progress.update("reading", 0);
  const fe::FeModel input = read_input(a);
  progress.clear();
  Json warnings = Json::array();
  for (const Diagnostic& warning : input.warnings) {
    warnings.push_back(diagnostic_line(warning, "warning"));
    print_line(warnings.back());
  }

  fe::ModelReduction options;
  options.interfaces =
      read_interfaces(a.interfaces, input.mesh, input.matrices.dofs, units_of(a.units).length);
  options.loads = loads_of(a.loads, input.mesh, input.matrices.dofs, units_of(a.units).length);
  if (!a.user_modes.empty())
    options.user_modes = fe::read_user_modes(a.user_modes, input.mesh, units_of(a.units));
  if (!a.stress.empty())
    options.stress = fe::read_stress_matrix(a.stress, a.stress_nodes, input.mesh, input.matrices,
                                            input.file_dofs, units_of(a.units));
  else if (!a.stress_nodes.empty())
    throw UsageError("--stress-nodes belongs to --stress FILE: it lists the nodes of its rows");
  options.dynamic_modes = a.modes;
  options.free_modes = a.free_modes;
  options.basis = basis_of(a.basis);
  options.max_frequency = a.max_frequency;
  options.krylov_frequency = a.krylov_frequency;
  options.effective_mass = a.effective_mass;
  options.stiffness_damping = a.damping;
  options.geometric_stiffness = a.stiffening;
  options.frame = frame_of(a.frame);
  if (a.mass_matrix == "lumped") options.mass_matrix = fe::MassMatrix::lumped;
  options.progress = [&](const std::string& stage, double part) { progress.update(stage, part); };
  fe::ReductionResult result = [&] {
    try {
      return fe::reduce(input.mesh, input.matrices, options);
    } catch (const std::invalid_argument& error) {
      progress.clear();
      throw InputError(Mark{a.input}, error.what());
    }
  }();
  progress.clear();
  ReducedBody& body = result.body;
  body.name = body_name(a);
  save(body, a.output);
  Json json;
  json["status"] = "ok";
  json["output"] = a.output;
  json["cached"] = false;
  json["dofs"] = input.matrices.dofs.size();
  json["interfaces"] = Json::array();
  for (const fe::Interface& i : options.interfaces)
    json["interfaces"].push_back({{"name", i.name},
                                  {"nodes", i.nodes.size()},
                                  {"point", {i.point.x(), i.point.y(), i.point.z()}},
                                  {"tie", i.tie == fe::Interface::Tie::rigid ? "rigid" : "mean"}});
  json["basis"] = a.basis;
  json["modes"] = body.modes;
  json["frequencies_hz"] = to_json(result.fixed_frequencies);
  json["effective_mass"] = to_json(result.effective_mass);
  json["free_frequencies_hz"] = to_json(result.free_frequencies);
  json["reduced_free_frequencies_hz"] = to_json(result.reduced_free_frequencies);
  json["mass"] = body.mass;
  json["seconds"] = 0;
  json["memory_mb"] = 0;
  json["passed"] =
      std::all_of(body.checks.begin(), body.checks.end(), [](const Check& c) { return c.passed; });
  json["checks"] = Json::array();
  for (const Check& c : body.checks)
    json["checks"].push_back({{"name", c.name}, {"passed", c.passed}, {"detail", c.detail}});
  return {{"summary", json}, {"warnings", warnings}};
}

/// What was kept of the same reduction, its body written; null when there is nothing.
Json reduce_from(const ResultCache& cache, const std::string& key, const ReduceArguments& a) {
  const auto kept = cache.fetch(key, a.output);
  if (!kept) return nullptr;
  Json found = Json::parse(*kept);
  for (const Json& warning : found.at("warnings")) print_line(warning);
  found.at("summary")["cached"] = true;
  found.at("summary")["output"] = a.output;
  return found;
}

std::string summary_text(const Json& summary) {
  std::string text = fmt::format("{}: {} dofs, {} modes, {:.6g} kg, {:.1f} s, {:.0f} MB{}\n\n",
                                 summary.at("output").get<std::string>(), summary.at("dofs").get<int>(),
                                 summary.at("modes").get<int>(), summary.at("mass").get<double>(),
                                 summary.at("seconds").get<double>(), summary.at("memory_mb").get<double>(),
                                 summary.at("cached").get<bool>() ? ", from cache" : "");
  Table frequencies({"mode", "interfaces held, Hz", "free, full model, Hz", "free, reduced, Hz"});
  const Json &held = summary.at("frequencies_hz"), &free = summary.at("free_frequencies_hz"),
             &reduced = summary.at("reduced_free_frequencies_hz");
  for (std::size_t k = 0; k < std::max(held.size(), free.size()); ++k)
    frequencies.add({fmt::format("{}", k + 1), entry(held, k), entry(free, k), entry(reduced, k)});
  text += frequencies.text() + '\n' + effective_masses(summary);
  Table checks({"check", "", "detail"});
  for (const Json& c : summary.at("checks"))
    checks.add({c.at("name").get<std::string>(), c.at("passed").get<bool>() ? "ok" : "NO",
                c.at("detail").get<std::string>()});
  return text + checks.text();
}

/// All files that are read, those that the input names included.
std::vector<std::string> inputs_of(const ReduceArguments& a) {
  std::vector<std::string> inputs;
  for (const std::string& given : {a.input, a.mass, a.nodes, a.dofs, a.user_modes, a.stress, a.stress_nodes})
    if (!given.empty()) inputs.push_back(given);
  for (const std::string& interface : a.interfaces.interfaces)
    if (const auto file = interface.find("=nodes:"); file != std::string::npos)
      inputs.push_back(interface.substr(file + std::string_view("=nodes:").size()));
  for (const std::string& neighbour : fe::files_beside(a.input)) inputs.push_back(neighbour);
  return inputs;
}

int run_reduce(const ReduceArguments& a, const Parser& command) {
  const auto start = std::chrono::steady_clock::now();
  const std::vector<std::string> inputs = inputs_of(a);
  for (const std::string& made : {a.output, a.report}) {
    if (made.empty()) continue;
    for (const std::string& input : inputs) require_different(input, made);
    made == a.output ? require_writable_body(made) : require_writable(made);
  }
  if (!a.report.empty()) require_different(a.output, a.report);
  const std::string key =
      a.no_cache ? std::string()
                 : reduction_key(command, body_name(a), {"--output", "--report", "--json", "--no-cache"});
  const ResultCache cache(key.empty() ? fs::path() : ResultCache::user_folder());
  Json result = reduce_from(cache, key, a);
  if (result.is_null()) {
    result = reduce_anew(a);
    cache.store(key, to_text(result), a.output);
  }
  if (!a.report.empty()) write_modes_report(load_reduced_body(a.output), a.report);
  Json& summary = result.at("summary");
  summary["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary["memory_mb"] = peak_memory_mb();
  if (a.json) {
    Json json = answer("reduce");
    json.update(summary);
    json["warnings"] = result.at("warnings");
    print_data(to_text(json) + '\n');
  } else {
    print_data(summary_text(summary));
  }
  if (summary.at("passed").get<bool>()) return done;
  print_warning("some checks failed: read the validation report before you use this body");
  return warned;
}

/// Properties that the file lacks, and the files of a model that is given by its matrices.
void add_file_options(Parser& parser, ReduceArguments& a) {
  parser
      .add_option("--material", a.materials, "E,nu,rho in SI, of all elements without material or of a group")
      .repeated()
      .type_name("[GROUP=]E,NU,RHO");
  parser
      .add_option("--density", a.densities,
                  "kg/m³, of all materials of the file without a density or of one by its name")
      .repeated()
      .type_name("[MATERIAL=]RHO");
  parser
      .add_option("--thickness", a.thicknesses,
                  "m, of all shells of the file without a thickness or of a group")
      .repeated()
      .type_name("[GROUP=]T");
  parser.add_option("--damping", a.damping, "Damping proportional to stiffness, s; default 0")
      .not_negative()
      .type_name("S");
  parser
      .add_option("--mass-matrix", a.mass_matrix,
                  "consistent (default), or lumped: masses at the nodes of solids and beams")
      .choice({"consistent", "lumped"});
  parser
      .add_option("--beam-torsion", a.beam_torsion,
                  "Torsion constant of an .inp file's beams: of the section (default), or of the brick into "
                  "which CalculiX expands it")
      .choice({"section", "brick"});
  parser.add_flag("--geometric-stiffness", a.stiffening,
                  "Stiffen the body by forces of inertia, gravity and at its interfaces (solids)");
  parser.add_option("--units", a.units, "Of the file: SI (default), mm (mm, tonnes, s), in (inch, lbf, s)")
      .choice({"SI", "mm", "in"});
  parser.add_option("--mass", a.mass, "Mass matrix").type_name("FILE");
  parser.add_option("--nodes", a.nodes, "Nodes: CSV label,x,y,z, or a mesh").type_name("FILE");
  parser.add_option("--dofs", a.dofs, "Dofs of the rows: CSV row,node,direction").type_name("FILE");
  parser
      .add_option(
          "--stress", a.stress,
          "Stress by displacements: .npz of SciPy; rows xx yy zz xy yz zx of each node, columns as the "
          "stiffness matrix")
      .type_name("FILE");
  parser
      .add_option("--stress-nodes", a.stress_nodes,
                  "Nodes of its rows: CSV, labels in the first column; default: all, in order")
      .type_name("FILE");
}

}  // namespace

Command add_reduce(CommandLine& program) {
  Parser parser = program.add_command(
      "reduce",
      "Reduce a finite-element model to a body: interface and dynamic modes, with a validation report");
  const auto a = std::make_shared<ReduceArguments>();
  parser.add_option("input", a->input, "The model; formats: below").required().type_name("INPUT");
  add_interface_options(parser, a->interfaces);
  parser.add_option("--basis", a->basis, "Modes that the body gets; default craig_bampton")
      .choice({"craig_bampton", "free_interface", "krylov", "attachment", "modal_truncation"});
  const Option modes =
      parser.add_option("--modes", a->modes, "Dynamic modes, or vectors of the Krylov basis; default 10")
          .within(0, 1000)
          .type_name("N");
  parser.add_option("--max-frequency", a->max_frequency, "All dynamic modes up to it, in place of --modes")
      .positive()
      .excludes(modes)
      .type_name("HZ");
  parser
      .add_option("--krylov-frequency", a->krylov_frequency,
                  "Frequency about which the Krylov basis matches the response; default 0")
      .not_negative()
      .type_name("HZ");
  parser
      .add_option("--effective-mass", a->effective_mass,
                  "Of the dynamic modes only those that reach this share of the body's mass")
      .within(0.0, 100.0)
      .type_name("PERCENT");
  parser
      .add_option("--load", a->loads,
                  "A force in equal parts on a selection of nodes: how it deflects the body becomes a mode")
      .repeated()
      .type_name("NAME=SELECTION,FX,FY,FZ");
  parser
      .add_option("--user-modes", a->user_modes,
                  "Further modes, as measured: CSV node,direction,mode 1,mode 2,... or .npz with label, "
                  "direction, shapes; with --modes 0 in place of the dynamic modes")
      .type_name("FILE");
  parser.add_option("--free-modes", a->free_modes, "Modes of the free model to compare with; default 10")
      .within(0, 1000)
      .type_name("N");
  parser.add_option("--frame", a->frame, "Reference frame; default tangent")
      .choice({"tangent", "centre_of_mass", "mean_axis"});
  add_file_options(parser, *a);
  parser.add_option("-o,--output", a->output, "The body").required().type_name("BODY.h5");
  parser
      .add_option("--report", a->report,
                  "A page of the body's modes and validation report, as `mimbre report` writes")
      .type_name("FILE.html");
  parser.add_flag("--no-cache", a->no_cache, "Neither look for the same reduction in the cache nor keep it");
  parser.add_flag("--json", a->json, "Print a summary for machines");
  parser.footer(
      formats() +
      "Example:\n  mimbre reduce arm.inp --interface pivot=set:pivot --interface ball=set:ball --modes 10 "
      "-o arm.h5");
  return {parser, [a, parser] { return run_reduce(*a, parser); }};
}

}  // namespace mimbre::app
