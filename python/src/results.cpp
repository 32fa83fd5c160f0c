#include "mimbre/results.h"

#include <fmt/format.h>
#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <utility>

#include "bindings.h"
#include "mimbre/report.h"
#include "mimbre/vtk.h"

namespace mimbre::python {
namespace {

/// What NumPy sees of memory that belongs to a Results.
using View1 = nb::ndarray<nb::numpy, const double, nb::ndim<1>>;
using View2 = nb::ndarray<nb::numpy, const double, nb::ndim<2>>;
using Copy3 = nb::ndarray<nb::numpy, double, nb::ndim<3>>;
using Self = nb::handle_t<Results>;

const Results& get(Self self) { return nb::cast<const Results&>(self); }

View1 time_of(Self self) {
  const Results& results = get(self);
  return View1(results.time.data(), {static_cast<std::size_t>(results.time.size())}, self);
}

View1 column_of(Self self, Eigen::Index column) {
  const Results& results = get(self);
  if (column < 0 || column >= results.channels.cols())
    throw nb::index_error(fmt::format("there is no channel number {}", column).c_str());
  return View1(results.channels.col(column).data(), {static_cast<std::size_t>(results.channels.rows())},
               self);
}

View2 modes_of(Self self) {
  const Eigen::MatrixXd& modes = get(self).modes;
  return View2(modes.data(), {static_cast<std::size_t>(modes.rows()), static_cast<std::size_t>(modes.cols())},
               self, {1, modes.rows()});
}

/// Instants × bodies × (position, quaternion w x y z).
Copy3 poses_of(const Results& results) {
  const std::size_t instants = results.poses.size(), bodies = results.header.bodies.size(),
                    size = instants * bodies * 7;
  auto values = std::make_unique<double[]>(size);
  double* to = values.get();
  for (const auto& poses : results.poses) to = std::copy(poses.data(), poses.data() + poses.size(), to);
  const nb::capsule owner(values.get(), [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return Copy3(values.release(), {instants, bodies, 7}, owner);
}

/// Bodies that have stress: name, the first of their modes among all, how many they have.
std::vector<std::tuple<std::string, Eigen::Index, int>> stressed_bodies(const Results& results) {
  std::vector<std::tuple<std::string, Eigen::Index, int>> list;
  Eigen::Index first = 0;
  for (const BodyDrawing& body : results.header.bodies) {
    if (body.stress.size() > 0) list.emplace_back(body.name, first, body.modes);
    first += body.modes;
  }
  return list;
}

/// Points × 3, their labels (numbers where these are not known), 6·points × modes.
auto body_stress(const Results& results, const std::string& name) {
  for (const BodyDrawing& body : results.header.bodies) {
    if (body.name != name) continue;
    std::vector<std::int64_t> labels = body.labels;
    for (std::int64_t k = std::ssize(labels); k < body.points.cols(); ++k) labels.push_back(k);
    return std::tuple(Eigen::MatrixX3d(body.points.transpose()), labels, body.stress);
  }
  throw nb::key_error(name.c_str());
}

void write(const Results& results, const std::string& path) {
  const nb::gil_scoped_release others_run;
  ResultsWriter writer(path, results.header);
  for (Eigen::Index k = 0; k < results.time.size(); ++k)
    writer.add({results.time[k], results.channels.row(k).transpose(),
                results.poses[static_cast<std::size_t>(k)], results.modes.row(k).transpose()});
  writer.finish(results.summary_json);
}

/// `progress` is called with the share that is done.
std::string export_vtk(const Results& results, const std::string& folder, int instants,
                       const std::optional<nb::callable>& progress) {
  VtkOptions options;
  options.most_instants = instants;
  options.progress = [&](double done) {  // what Python raises leaves the older files as they were
    const nb::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) nb::raise_python_error();
    if (progress) (*progress)(done);
  };
  const nb::gil_scoped_release others_run;
  return write_vtk(results, folder, options);
}

void write_comparison_of(const std::vector<std::pair<std::string, const Results*>>& runs,
                         const std::string& path) {
  const nb::gil_scoped_release others_run;
  std::vector<ComparedRun> compared;
  for (const auto& [label, results] : runs) compared.push_back({*results, {}, label});
  write_comparison(compared, path);
}

}  // namespace

void bind_results(nb::module_& module) {
  nb::class_<Results>(module, "Results", "Everything of a run.")
      .def_prop_ro("title", [](const Results& r) { return r.header.title; })
      .def_prop_ro("model_text", [](const Results& r) { return r.header.model_text; })
      .def_prop_ro("options_json", [](const Results& r) { return r.header.options_json; })
      .def_prop_ro("summary_json", [](const Results& r) { return r.summary_json; })
      .def_prop_ro("step", [](const Results& r) { return r.header.step; })
      .def_prop_ro("time", &time_of, nb::rv_policy::automatic)
      .def_prop_ro(
          "channels",
          [](const Results& r) {
            std::vector<std::tuple<std::string, std::string, std::string>> list;
            for (const ChannelInfo& c : r.header.channels) list.emplace_back(c.name, c.unit, c.meaning);
            return list;
          },
          "Name, unit and meaning of each.")
      .def_prop_ro("bodies",
                   [](const Results& r) {
                     std::vector<std::string> names;
                     for (const BodyDrawing& body : r.header.bodies) names.push_back(body.name);
                     return names;
                   })
      .def("column", &column_of, nb::arg("column"), "A channel, without a copy.")
      .def_prop_ro("modes", &modes_of, nb::rv_policy::automatic)
      .def_prop_ro("poses", &poses_of, nb::rv_policy::automatic)
      .def_prop_ro("stressed_bodies", &stressed_bodies)
      .def("body_stress", &body_stress, nb::arg("body"))
      .def("write", &write, nb::arg("path"))
      .def(
          "report", [](const Results& r) { return report_html(r); }, nb::call_guard<nb::gil_scoped_release>())
      .def(
          "write_report", [](const Results& r, const std::string& path) { write_report(r, path); },
          nb::arg("path"), nb::call_guard<nb::gil_scoped_release>())
      .def("export_vtk", &export_vtk, nb::arg("folder"), nb::arg("instants"), nb::arg("progress").none());
  module.def("write_comparison", &write_comparison_of, nb::arg("runs"), nb::arg("path"));
  module.def("read_results", &read_results, nb::arg("path"), nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace mimbre::python
