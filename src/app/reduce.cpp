#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>

#include "app/common.h"
#include "app/progress.h"
#include "app/selection.h"
#include "app/table.h"
#include "app/targets.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"

/// mimbre reduce: a finite-element model as a body.
namespace mimbre::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string input, output, mass, nodes, dofs;
  std::vector<std::string> interfaces, means, points, materials;
  int modes = 10, free_modes = 10;
  std::string frame = "tangent", units = "SI", basis = "craig_bampton";
  double damping = 0, max_frequency = 0, krylov_frequency = 0, effective_mass = 0;
  bool json = false, stiffening = false;
};

constexpr const char* formats =
    "Inputs, by their endings:\n"
    "  .msh                  Gmsh 2.2 or 4.1, ASCII: needs --material\n"
    "  .inp                  CalculiX, Abaqus: mesh, materials, sections; the matrices of .sti, .mas and "
    ".dof\n"
    "                        of the same name where they lie beside it\n"
    "  .mtx, .npz            stiffness as Matrix Market, Abaqus or SciPy matrix: needs --mass and --nodes\n"
    "  .pch, .dmig, .bdf     Nastran DMIG and GRID cards (--nodes FILE: the cards' own file)\n";

fe::FileUnits units_of(const std::string& name) {
  if (name == "mm") return {1e-3, 1e3, 1};
  if (name == "in") return {0.0254, 175.126835, 1};  // inch, lbf s²/in, s
  return {};
}

/// "NAME=E,nu,rho" or "E,nu,rho" (SI) to the groups without a material.
void add_materials(fe::SolidMesh& mesh, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const std::string group = equals == std::string::npos ? "" : text.substr(0, equals);
    fe::NamedMaterial material;
    material.name = group.empty() ? "material" : group;
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
    const int index = static_cast<int>(mesh.materials.size());
    mesh.materials.push_back(material);
    bool used = false;
    for (fe::ElementGroup& g : mesh.groups)
      if (group.empty() ? g.material < 0 : g.name == group) {
        g.material = index;
        used = true;
      }
    if (!used && !group.empty())
      throw UsageError(fmt::format("--material: no elements belong to a group '{}'", group));
  }
}

struct Input {
  fe::SolidMesh mesh;
  fe::FeMatrices matrices;
  std::vector<Diagnostic> warnings;
};

Input read_input(const Arguments& a) {
  const fe::FileUnits units = units_of(a.units);
  const fs::path path(a.input);
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const auto with = [&](const char* extension) { return fs::path(path).replace_extension(extension); };
  if (ending == ".msh" || ending == ".inp") {
    if (ending == ".inp" && fs::exists(with(".sti")) && fs::exists(with(".mas")) &&
        fs::exists(with(".dof"))) {
      fe::ImportedMatrices read = fe::read_calculix_matrices(a.input, units);
      return {std::move(read.mesh), std::move(read.matrices), std::move(read.warnings)};
    }
    fe::ImportedMesh read = fe::read_mesh(a.input, units);
    add_materials(read.mesh, a.materials);
    try {
      fe::FeMatrices matrices = fe::assemble(read.mesh);
      return {std::move(read.mesh), std::move(matrices), std::move(read.warnings)};
    } catch (const std::invalid_argument& error) {
      throw InputError(Mark{a.input}, error.what());
    }
  }
  if (ending == ".mtx" || ending == ".npz") {
    if (a.mass.empty() || a.nodes.empty())
      throw UsageError("a stiffness matrix needs --mass FILE and --nodes FILE beside it");
    fe::ImportedMatrices read = fe::read_sparse_matrices(a.input, a.mass, a.nodes, a.dofs, units);
    return {std::move(read.mesh), std::move(read.matrices), std::move(read.warnings)};
  }
  if (ending == ".pch" || ending == ".dmig" || ending == ".bdf" || ending == ".dat") {
    fe::ImportedMatrices read = fe::read_nastran_dmig(a.input, a.nodes, "", "", units);
    return {std::move(read.mesh), std::move(read.matrices), std::move(read.warnings)};
  }
  throw UsageError(fmt::format("'{}': the ending '{}' is not known\n{}", a.input, ending, formats));
}

std::vector<fe::Interface> interfaces_of(const Arguments& a, const Input& input) {
  const double unit = units_of(a.units).length;
  std::vector<fe::Interface> interfaces;
  for (const std::string& text : a.interfaces) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw UsageError(fmt::format("--interface '{}': NAME=SELECTION is needed, as ball=group:ball", text));
    fe::Interface interface;
    interface.name = text.substr(0, equals);
    interface.nodes = select_nodes(text.substr(equals + 1), input.mesh, input.matrices.dofs, unit);
    interface.point = fe::centre_of(input.mesh, interface.nodes);
    interfaces.push_back(std::move(interface));
  }
  const auto find = [&](const std::string& name, const char* option) -> fe::Interface& {
    for (fe::Interface& interface : interfaces)
      if (interface.name == name) return interface;
    throw UsageError(fmt::format("{}: there is no interface '{}'", option, name));
  };
  for (const std::string& name : a.means) find(name, "--mean").tie = fe::Interface::Tie::mean;
  for (const std::string& text : a.points) {
    const std::size_t equals = text.find('=');
    Eigen::Vector3d point;
    char comma1 = 0, comma2 = 0;
    std::istringstream numbers(equals == std::string::npos ? "" : text.substr(equals + 1));
    if (!(numbers >> point.x() >> comma1 >> point.y() >> comma2 >> point.z()) || comma1 != ',' ||
        comma2 != ',')
      throw UsageError(fmt::format("--point '{}': NAME=x,y,z is needed", text));
    find(text.substr(0, equals), "--point").point = unit * point;
  }
  return interfaces;
}

Json to_json(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double x : values) list.push_back(x);
  return list;
}

fe::ModelReduction::Basis basis_of(const std::string& name) {
  using Basis = fe::ModelReduction::Basis;
  if (name == "free_interface") return Basis::free_interface;
  return name == "krylov" ? Basis::krylov : Basis::craig_bampton;
}

/// A list per mode.
Json to_json(const Eigen::MatrixXd& columns) {
  Json list = Json::array();
  for (Eigen::Index k = 0; k < columns.cols(); ++k) list.push_back(to_json(Eigen::VectorXd(columns.col(k))));
  return list;
}

std::string effective_masses(const fe::ReductionResult& result) {
  if (result.effective_mass.cols() == 0) return {};
  Table table({"mode", "Hz", "x, %", "y, %", "z, %", "rx, %", "ry, %", "rz, %"});
  const auto add = [&](const std::string& name, const std::string& hertz, const Eigen::VectorXd& shares) {
    std::vector<std::string> row{name, hertz};
    for (const double share : shares) row.push_back(fmt::format("{:.2f}", share));
    table.add(row);
  };
  for (Eigen::Index k = 0; k < result.effective_mass.cols(); ++k)
    add(fmt::format("{}", k + 1), fmt::format("{:.6g}", result.fixed_frequencies[k]),
        result.effective_mass.col(k));
  add("sum", "", result.effective_mass.rowwise().sum());
  return "Effective mass of the modes with interfaces held\n" + table.text() + '\n';
}

int run(const Arguments& a) {
  const auto start = std::chrono::steady_clock::now();
  require_different(a.input, a.output);
  require_writable(a.output);
  Progress progress(!a.json);
  progress.update("reading", 0);
  const Input input = read_input(a);
  progress.clear();
  for (const Diagnostic& warning : input.warnings)
    fmt::print(stderr, "{}\n", diagnostic_line(warning, "warning"));

  fe::ModelReduction options;
  options.interfaces = interfaces_of(a, input);
  options.dynamic_modes = a.modes;
  options.free_modes = a.free_modes;
  options.basis = basis_of(a.basis);
  options.max_frequency = a.max_frequency;
  options.krylov_frequency = a.krylov_frequency;
  options.effective_mass = a.effective_mass;
  options.stiffness_damping = a.damping;
  options.geometric_stiffness = a.stiffening;
  options.frame =
      a.frame == "mean_axis" ? fe::ModelReduction::Frame::mean_axis : fe::ModelReduction::Frame::tangent;
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
  body.name = fs::path(a.output).stem().string();
  save(body, a.output);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const bool passed =
      std::all_of(body.checks.begin(), body.checks.end(), [](const Check& c) { return c.passed; });

  if (a.json) {
    Json json;
    json["status"] = "ok";
    json["output"] = a.output;
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
    json["seconds"] = seconds;
    json["memory_mb"] = peak_memory_mb();
    json["passed"] = passed;
    json["checks"] = Json::array();
    for (const Check& c : body.checks)
      json["checks"].push_back({{"name", c.name}, {"passed", c.passed}, {"detail", c.detail}});
    print_data(to_text(json) + '\n');
    return done;
  }
  std::string text =
      fmt::format("{}: {} dofs, {} modes, {:.6g} kg, {:.1f} s, {:.0f} MB\n\n", a.output,
                  input.matrices.dofs.size(), body.modes, body.mass, seconds, peak_memory_mb());
  Table frequencies({"mode", "interfaces held, Hz", "free, full model, Hz", "free, reduced, Hz"});
  const auto entry = [](const Eigen::VectorXd& values, Eigen::Index k) {
    return k < values.size() ? fmt::format("{:.6g}", values[k]) : std::string();
  };
  const Eigen::Index rows = std::max(result.fixed_frequencies.size(), result.free_frequencies.size());
  for (Eigen::Index k = 0; k < rows; ++k)
    frequencies.add({fmt::format("{}", k + 1), entry(result.fixed_frequencies, k),
                     entry(result.free_frequencies, k), entry(result.reduced_free_frequencies, k)});
  text += frequencies.text() + '\n' + effective_masses(result);
  Table checks({"check", "", "detail"});
  for (const Check& c : body.checks) checks.add({c.name, c.passed ? "ok" : "NO", c.detail});
  print_data(text + checks.text());
  if (!passed) print_warning("not all checks are passed; see above before you trust this body");
  return done;
}

}  // namespace

Command add_reduce(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "reduce", "Make a body of a finite-element model: interface and dynamic modes, with a certificate");
  const auto a = std::make_shared<Arguments>();
  parser->add_option("input", a->input, "The model; formats: below")->required()->type_name("INPUT");
  parser
      ->add_option("--interface", a->interfaces,
                   "Where joints and forces take hold: group:NAME, set:NAME, nodes:FILE, "
                   "box(x0,y0,z0, x1,y1,z1), cylinder(px,py,pz, ax,ay,az, r); several options, several "
                   "interfaces. The body frame of a tangent frame moves with the first")
      ->required()
      ->take_all()
      ->allow_extra_args(false)
      ->type_name("NAME=SELECTION");
  parser
      ->add_option("--mean", a->means,
                   "Interface that moves as its nodes do in the mean (RBE3), not rigidly (RBE2)")
      ->allow_extra_args(false)
      ->type_name("NAME");
  parser->add_option("--point", a->points, "Reference point of an interface; default: the mean of its nodes")
      ->allow_extra_args(false)
      ->type_name("NAME=x,y,z");
  parser->add_option("--basis", a->basis, "Modes that the body gets; default craig_bampton")
      ->check(CLI::IsMember({"craig_bampton", "free_interface", "krylov"}));
  CLI::Option* const modes =
      parser->add_option("--modes", a->modes, "Dynamic modes, or vectors of the Krylov basis; default 10")
          ->check(CLI::Range(0, 1000))
          ->type_name("N");
  parser->add_option("--max-frequency", a->max_frequency, "All dynamic modes up to it, in place of --modes")
      ->check(CLI::PositiveNumber)
      ->excludes(modes)
      ->type_name("HZ");
  parser
      ->add_option("--krylov-frequency", a->krylov_frequency,
                   "Frequency about which the Krylov basis matches the response; default 0")
      ->check(CLI::NonNegativeNumber)
      ->type_name("HZ");
  parser
      ->add_option("--effective-mass", a->effective_mass,
                   "Of the dynamic modes only those that reach this share of the body's mass")
      ->check(CLI::Range(0.0, 100.0))
      ->type_name("PERCENT");
  parser->add_option("--free-modes", a->free_modes, "Modes of the free model to compare with; default 10")
      ->check(CLI::Range(0, 1000))
      ->type_name("N");
  parser->add_option("--frame", a->frame, "Reference frame; default tangent")
      ->check(CLI::IsMember({"tangent", "mean_axis"}));
  parser
      ->add_option("--material", a->materials,
                   "E,nu,rho in SI, of all elements without material or of a group")
      ->allow_extra_args(false)
      ->type_name("[GROUP=]E,NU,RHO");
  parser->add_option("--damping", a->damping, "Damping proportional to stiffness, s; default 0")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S");
  parser->add_flag("--geometric-stiffness", a->stiffening,
                   "Stiffen the body by forces of inertia, gravity and at its interfaces (solids)");
  parser->add_option("--units", a->units, "Of the file: SI (default), mm (mm, tonnes, s), in (inch, lbf, s)")
      ->check(CLI::IsMember({"SI", "mm", "in"}));
  parser->add_option("--mass", a->mass, "Mass matrix")->type_name("FILE");
  parser->add_option("--nodes", a->nodes, "Nodes: CSV label,x,y,z, or a mesh")->type_name("FILE");
  parser->add_option("--dofs", a->dofs, "Dofs of the rows: CSV row,node,direction")->type_name("FILE");
  parser->add_option("-o,--output", a->output, "The body")->required()->type_name("BODY.h5");
  parser->add_flag("--json", a->json, "Print a summary for machines");
  parser->footer(
      std::string(formats) +
      "Example:\n  mimbre reduce arm.inp --interface pivot=set:pivot --interface ball=set:ball --modes 10 "
      "-o arm.h5");
  return {parser, [a] { return run(*a); }};
}

}  // namespace mimbre::app
