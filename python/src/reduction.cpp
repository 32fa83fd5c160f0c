#include "mimbre/fe_reduce.h"

#include <fmt/format.h>
#include <nanobind/eigen/dense.h>
#include <nanobind/eigen/sparse.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

#include "bindings.h"
#include "mimbre/fe_import.h"
#include "mimbre/report.h"

/// Finite-element models and what is made of them.
namespace mimbre::python {
namespace {

using Labels = std::vector<std::int64_t>;
using Selection = std::variant<std::string, Labels>;  ///< as fe::select_nodes, or nodes' labels
using Matrix = Eigen::SparseMatrix<double>;
using Dofs = std::vector<std::tuple<std::int64_t, int>>;  ///< node's label, direction from 0

/// What was wrong with the input, as such.
template <class Work>
auto checked(const Work& work) {
  try {
    return work();
  } catch (const std::invalid_argument& error) {
    throw InputError(Mark{}, error.what());
  } catch (const std::length_error& error) {
    throw InputError(Mark{}, error.what());
  }
}

/// A model with the number of each node by its label.
struct FeModel : fe::FeModel {
  double length_unit = 1;  ///< m, of coordinates in selections
  std::unordered_map<std::int64_t, int> numbers;

  explicit FeModel(fe::FeModel model, double unit = 1) : fe::FeModel(std::move(model)), length_unit(unit) {
    for (std::size_t k = 0; k < mesh.labels.size(); ++k) numbers[mesh.labels[k]] = static_cast<int>(k);
  }

  int number(std::int64_t label) const {
    const auto found = numbers.find(label);
    if (found == numbers.end()) throw InputError(Mark{}, fmt::format("there is no node {}", label));
    return found->second;
  }
  std::vector<int> nodes(const Selection& selection) const {
    if (const auto* text = std::get_if<std::string>(&selection))
      return fe::select_nodes(*text, mesh, matrices.dofs, length_unit);
    std::vector<int> list;
    for (const std::int64_t label : std::get<Labels>(selection)) list.push_back(number(label));
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
  }
};

using Units = std::array<double, 3>;  ///< of length, mass, time
using Materials = std::map<std::string, std::array<double, 3>>;

std::vector<fe::NamedMaterial> materials_of(const Materials& given) {
  std::vector<fe::NamedMaterial> list;
  for (const auto& [name, m] : given) list.push_back({name, {m[0], m[1], m[2]}});
  return list;
}

using Numbers = std::map<std::string, double>;  ///< by name; "": of all that are left

std::vector<fe::NamedNumber> numbers_of(const Numbers& given) {
  std::vector<fe::NamedNumber> list;
  for (const auto& [name, value] : given) list.push_back({name, value});
  return list;
}

FeModel read(const std::string& path, const std::string& mass, const std::string& nodes,
             const std::string& dofs, const Materials& materials, const Numbers& densities,
             const Numbers& thicknesses, int beam_torsion, const Units& units) {
  const nb::gil_scoped_release others_run;
  return checked([&] {
    return FeModel(fe::read_model(path,
                                  {mass, nodes, dofs, materials_of(materials), numbers_of(densities),
                                   numbers_of(thicknesses), static_cast<fe::BeamTorsion>(beam_torsion)},
                                  {units[0], units[1], units[2]}),
                   units[0]);
  });
}

fe::StressMatrix read_stress(const FeModel& model, const std::string& path, const std::string& nodes,
                             const Units& units) {
  const nb::gil_scoped_release others_run;
  return checked([&] {
    return fe::read_stress_matrix(path, nodes, model.mesh, model.matrices, model.file_dofs,
                                  {units[0], units[1], units[2]});
  });
}

fe::SolidMesh mesh_of(const Eigen::MatrixX3d& nodes) {
  fe::SolidMesh mesh;
  mesh.nodes = nodes.transpose();
  for (Eigen::Index k = 0; k < nodes.rows(); ++k) mesh.labels.push_back(k);
  return mesh;
}

/// Matrices of any program: `dofs` of the rows; nodes ascending, as the library wants them, in any order
/// here.
FeModel from_matrices(const Matrix& stiffness, const Matrix& mass, const Eigen::MatrixX3d& nodes,
                      const Dofs& dofs) {
  fe::FeModel model;
  model.mesh = mesh_of(nodes);
  for (const auto& [label, direction] : dofs) {
    if (label < 0 || label >= nodes.rows() || direction < 0 || direction > 5)
      throw InputError(Mark{}, fmt::format("dofs: ({}, {}) is no node and direction; nodes are 0 to {}, "
                                           "directions 0 to 5",
                                           label, direction, nodes.rows() - 1));
    model.file_dofs.push_back({static_cast<int>(label), direction});
  }
  const auto count = static_cast<Eigen::Index>(dofs.size());
  for (const Matrix* matrix : {&stiffness, &mass})
    if (matrix->rows() != count || matrix->cols() != count)
      throw InputError(Mark{}, fmt::format("a matrix is {} × {}, but there are {} dofs", matrix->rows(),
                                           matrix->cols(), count));
  // The order by nodes, as a permutation.
  std::vector<std::tuple<int, int, int>> order;  // node, direction, row
  for (const fe::Dof& dof : model.file_dofs)
    order.emplace_back(dof.node, dof.direction, static_cast<int>(order.size()));
  std::sort(order.begin(), order.end());
  Eigen::PermutationMatrix<Eigen::Dynamic> to(count);
  for (const auto& [node, direction, row] : order) {
    std::vector<fe::Dof>& sorted = model.matrices.dofs;
    if (!sorted.empty() && sorted.back().node == node && sorted.back().direction == direction)
      throw InputError(Mark{}, fmt::format("dofs: node {} has direction {} twice", node, direction));
    to.indices()[row] = static_cast<int>(sorted.size());
    sorted.push_back({node, direction});
  }
  const auto lower = [&](const Matrix& full) {
    Matrix sorted;
    sorted = full.twistedBy(to);
    Matrix triangle = sorted.triangularView<Eigen::Lower>();
    triangle.makeCompressed();
    return triangle;
  };
  model.matrices.stiffness = lower(stiffness);
  model.matrices.mass = lower(mass);
  return FeModel(std::move(model));
}

/// Elements of one kind and material: type, name, nodes, thickness.
using Group = std::tuple<std::string, std::string, std::vector<int>, double>;

FeModel from_mesh(const Eigen::MatrixX3d& nodes, const std::vector<Group>& groups, const Materials& materials,
                  const std::map<std::string, Labels>& node_sets) {
  static const std::map<std::string, fe::ElementType> types{
      {"tetra", fe::ElementType::tet4},       {"tetra10", fe::ElementType::tet10},
      {"hexahedron", fe::ElementType::hex8},  {"hexahedron20", fe::ElementType::hex20},
      {"wedge", fe::ElementType::wedge6},     {"wedge15", fe::ElementType::wedge15},
      {"pyramid", fe::ElementType::pyramid5}, {"pyramid13", fe::ElementType::pyramid13},
      {"triangle", fe::ElementType::tri3},    {"quad", fe::ElementType::quad4}};
  fe::FeModel model;
  model.mesh = mesh_of(nodes);
  model.mesh.materials = materials_of(materials);
  const auto material_of = [&](const std::string& group) {
    for (const std::string& name : {group, std::string()})
      for (std::size_t k = 0; k < model.mesh.materials.size(); ++k)
        if (model.mesh.materials[k].name == name) return static_cast<int>(k);
    return -1;
  };
  for (const auto& [type, name, elements, thickness] : groups) {
    const auto found = types.find(type);
    if (found == types.end())
      throw InputError(Mark{},
                       fmt::format("cells of type '{}' are not known; there are tetra, tetra10, hexahedron, "
                                   "hexahedron20, wedge, wedge15, triangle, quad",
                                   type));
    fe::ElementGroup group{found->second, name, material_of(name), thickness, elements, {}};
    for (int k = 0; k < group.size(); ++k) group.labels.push_back(k);
    model.mesh.groups.push_back(std::move(group));
  }
  for (const auto& [name, labels] : node_sets) {
    fe::NodeSet set{name, {}};
    for (const std::int64_t label : labels) {
      if (label < 0 || label >= nodes.rows())
        throw InputError(Mark{}, fmt::format("node set '{}': there is no node {}", name, label));
      set.nodes.push_back(static_cast<int>(label));
    }
    std::sort(set.nodes.begin(), set.nodes.end());
    set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
    model.mesh.node_sets.push_back(std::move(set));
  }
  const nb::gil_scoped_release others_run;
  return checked([&] {
    model.matrices = fe::assemble(model.mesh);
    return FeModel(std::move(model));
  });
}

/// Name, nodes, whether the tie is a mean, point, axes, motions (fe::Interface::Motion).
using InterfaceTuple = std::tuple<std::string, Selection, bool, std::optional<Eigen::Vector3d>,
                                  std::optional<Eigen::Matrix3d>, std::array<int, 6>>;
using LoadTuple = std::tuple<std::string, Selection, Eigen::Vector3d>;

/// Options by their names, so that the list of them stands once, in mimbre/reduction.py.
struct Options : fe::ModelReduction {
  std::vector<InterfaceTuple> interface_list;
  std::vector<LoadTuple> load_list;
  Dofs user_dofs;
  std::optional<nb::callable> report;
};

fe::ReductionResult reduce(const FeModel& model, const Options& given, const std::string& name) {
  fe::ModelReduction options = given;
  const std::optional<nb::callable> report = given.report;
  return checked([&] {
    for (const auto& [interface_name, selection, mean, point, axes, motions] : given.interface_list) {
      fe::Interface interface;
      interface.name = interface_name;
      interface.nodes = model.nodes(selection);
      if (interface.nodes.empty())
        throw InputError(Mark{}, fmt::format("interface '{}' has no nodes", interface_name));
      interface.point =
          point ? Eigen::Vector3d(model.length_unit * *point) : fe::centre_of(model.mesh, interface.nodes);
      if (axes) interface.axes = *axes;
      if (mean) interface.tie = fe::Interface::Tie::mean;
      for (std::size_t k = 0; k < 6; ++k)
        interface.motions[k] = static_cast<fe::Interface::Motion>(motions[k]);
      options.interfaces.push_back(std::move(interface));
    }
    for (const auto& [load_name, selection, force] : given.load_list)
      options.loads.push_back({load_name, model.nodes(selection), force});
    for (const auto& [label, direction] : given.user_dofs)
      options.user_modes.dofs.push_back({model.number(label), direction});
    // Between the stages: what Python raises goes through the library, which holds nothing that is not freed.
    options.progress = [&](const std::string& stage, double done) {
      const nb::gil_scoped_acquire locked;
      if (PyErr_CheckSignals() != 0) nb::raise_python_error();
      if (report) (*report)(stage, done);
    };
    const nb::gil_scoped_release others_run;
    fe::ReductionResult result = fe::reduce(model.mesh, model.matrices, options);
    result.body.name = name;
    return result;
  });
}

template <class Enumeration>
Enumeration numbered(int k) {
  return static_cast<Enumeration>(k);
}

}  // namespace

void bind_reduction(nb::module_& module) {
  nb::class_<FeModel>(module, "FeModel", "A finite-element model, ready to be reduced.")
      .def_prop_ro("dofs", [](const FeModel& m) { return m.matrices.dofs.size(); })
      .def_prop_ro("nodes", [](const FeModel& m) { return Eigen::MatrixX3d(m.mesh.nodes.transpose()); })
      .def_prop_ro("labels", [](const FeModel& m) { return m.mesh.labels; })
      .def_prop_ro("node_sets",
                   [](const FeModel& m) {
                     std::map<std::string, Labels> sets;
                     for (const fe::NodeSet& set : m.mesh.node_sets)
                       for (const int node : set.nodes)
                         sets[set.name].push_back(m.mesh.labels[static_cast<std::size_t>(node)]);
                     return sets;
                   })
      .def_prop_ro("warnings", [](const FeModel& m) {
        std::vector<std::string> list;
        for (const Diagnostic& warning : m.warnings) list.push_back(to_string(warning));
        return list;
      });
  module.def("read_fe", &read, nb::arg("path"), nb::arg("mass"), nb::arg("nodes"), nb::arg("dofs"),
             nb::arg("materials"), nb::arg("densities"), nb::arg("thicknesses"), nb::arg("beam_torsion"),
             nb::arg("units"));
  nb::class_<fe::StressMatrix>(module, "StressMatrix", "Stress by displacements as another program has it.");
  module.def("read_stress", &read_stress, nb::arg("model"), nb::arg("path"), nb::arg("nodes"),
             nb::arg("units"));
  module.def("fe_from_matrices", &from_matrices, nb::arg("stiffness"), nb::arg("mass"), nb::arg("nodes"),
             nb::arg("dofs"));
  module.def("fe_from_mesh", &from_mesh, nb::arg("nodes"), nb::arg("groups"), nb::arg("materials"),
             nb::arg("node_sets"));

  nb::class_<Options>(module, "ReductionOptions")
      .def(nb::init<>())
      .def_rw("interfaces", &Options::interface_list)
      .def_rw("loads", &Options::load_list)
      .def_rw("user_dofs", &Options::user_dofs)
      .def_prop_rw(
          "user_shapes", [](const Options& o) { return o.user_modes.shapes; },
          [](Options& o, const Eigen::MatrixXd& shapes) { o.user_modes.shapes = shapes; })
      .def_prop_rw(
          "basis", [](const Options& o) { return static_cast<int>(o.basis); },
          [](Options& o, int k) { o.basis = numbered<fe::ModelReduction::Basis>(k); })
      .def_prop_rw(
          "frame", [](const Options& o) { return static_cast<int>(o.frame); },
          [](Options& o, int k) { o.frame = numbered<fe::ModelReduction::Frame>(k); })
      .def_prop_rw(
          "mass_matrix", [](const Options& o) { return static_cast<int>(o.mass_matrix); },
          [](Options& o, int k) { o.mass_matrix = numbered<fe::MassMatrix>(k); })
      .def_rw("modes", &Options::dynamic_modes)
      .def_rw("free_modes", &Options::free_modes)
      .def_rw("max_frequency", &Options::max_frequency)
      .def_rw("krylov_frequency", &Options::krylov_frequency)
      .def_rw("effective_mass", &Options::effective_mass)
      .def_rw("damping", &Options::stiffness_damping)
      .def_rw("geometric_stiffness", &Options::geometric_stiffness)
      .def_prop_rw(
          "stress", [](const Options& o) { return o.stress; },
          [](Options& o, const fe::StressMatrix& stress) { o.stress = stress; })
      .def_rw("report", &Options::report);
  nb::class_<fe::ReductionResult>(module, "Reduction")
      .def_prop_ro("body", [](const fe::ReductionResult& r) { return std::make_shared<ReducedBody>(r.body); })
      .def_ro("frequencies", &fe::ReductionResult::fixed_frequencies)
      .def_ro("effective_mass", &fe::ReductionResult::effective_mass)
      .def_ro("free_frequencies", &fe::ReductionResult::free_frequencies)
      .def_ro("reduced_free_frequencies", &fe::ReductionResult::reduced_free_frequencies);
  module.def("reduce", &reduce, nb::arg("model"), nb::arg("options"), nb::arg("name"));

  nb::class_<ReducedBody>(module, "ReducedBody")
      .def_ro("name", &ReducedBody::name)
      .def_ro("modes", &ReducedBody::modes)
      .def_ro("mode_names", &ReducedBody::mode_names)
      .def_ro("mass", &ReducedBody::mass)
      .def_ro("mass_matrix", &ReducedBody::mass_matrix)
      .def_ro("stiffness", &ReducedBody::stiffness)
      .def_ro("damping", &ReducedBody::damping)
      .def_ro("nodes", &ReducedBody::nodes)
      .def_ro("node_shapes", &ReducedBody::node_shapes)
      .def_ro("node_labels", &ReducedBody::node_labels)
      .def_ro("stress", &ReducedBody::stress)
      .def_ro("strain", &ReducedBody::strain)
      .def_ro("first_moment", &ReducedBody::first_moment)
      .def_ro("second_moment", &ReducedBody::second_moment)
      .def_ro("eigenfrequencies", &ReducedBody::eigenfrequencies)
      .def_prop_ro("frames",
                   [](const ReducedBody& body) {
                     std::map<std::string, Eigen::Vector3d> frames;
                     for (const BodyFrame& frame : body.frames) frames[frame.name] = frame.position;
                     return frames;
                   })
      .def_prop_ro("checks",
                   [](const ReducedBody& body) {
                     std::vector<std::tuple<std::string, bool, std::string>> checks;
                     for (const Check& c : body.checks) checks.emplace_back(c.name, c.passed, c.detail);
                     return checks;
                   })
      .def(
          "save",
          [](const ReducedBody& body, const std::string& path) {
            checked([&] { return fe::write_body(body, path, fe::body_format(path)), 0; });
          },
          nb::arg("path"), nb::call_guard<nb::gil_scoped_release>())
      .def(
          "write_report",
          [](const ReducedBody& body, const std::string& path) { write_modes_report(body, path); },
          nb::arg("path"), nb::call_guard<nb::gil_scoped_release>());
  module.def(
      "read_body",
      [](const std::string& path) {
        return checked([&] { return std::make_shared<ReducedBody>(fe::read_body(path).body); });
      },
      nb::arg("path"), nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace mimbre::python
