#include <nanobind/eigen/dense.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "attention.h"
#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/buckling.h"
#include "mimbre/equilibrium_path.h"

/// Equilibria under growing loads: mimbre/equilibria.py gives them names.
namespace mimbre::python {
namespace {

/// What the library says of searches that fail, as the program does.
template <class Work>
auto sought(const Work& work) {
  const nb::gil_scoped_release others_run;
  try {
    return work();
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

Buckling buckling_loads(const LoadedModel& loaded, const std::vector<std::string>& loads, int count,
                        const std::map<std::string, double>& inputs) {
  BucklingOptions options;
  options.loads = loads;
  options.count = count;
  options.inputs = inputs;
  return sought([&] { return buckling(loaded.model, options); });
}

/// Ends a search from outside.
struct Interrupted {};

EquilibriumPath path_of(const LoadedModel& loaded, const std::vector<std::string>& loads, double from,
                        double to, int points, int bifurcations, const std::map<std::string, double>& inputs,
                        const std::optional<nb::callable>& progress) {
  EquilibriumPathOptions options;
  options.loads = loads;
  options.from = from;
  options.to = to;
  options.most_points = points;
  options.bifurcations = bifurcations;
  options.inputs = inputs;
  Attention attention;
  options.progress = [&](double factor, int count) {
    if (progress) attention.call([&] { (*progress)(factor, count); });
    if (attention.stop()) throw Interrupted();
  };
  EquilibriumPath path;
  try {
    path = sought([&] { return equilibrium_path(loaded.model, options); });
  } catch (const Interrupted&) {
    attention.raise();
  }
  return path;
}

/// Of one branch, by point.
Eigen::VectorXd factors_of(const PathBranch& branch) {
  Eigen::VectorXd out(std::ssize(branch.points));
  for (std::size_t k = 0; k < branch.points.size(); ++k)
    out[static_cast<Eigen::Index>(k)] = branch.points[k].factor;
  return out;
}
Eigen::MatrixXd values_of(const PathBranch& branch) {
  const Eigen::Index columns = branch.points.empty() ? 0 : branch.points.front().values.size();
  Eigen::MatrixXd out(std::ssize(branch.points), columns);
  for (std::size_t k = 0; k < branch.points.size(); ++k)
    out.row(static_cast<Eigen::Index>(k)) = branch.points[k].values.transpose();
  return out;
}
std::vector<int> unstable_of(const PathBranch& branch) {
  std::vector<int> out;
  for (const PathPoint& point : branch.points) out.push_back(point.unstable);
  return out;
}
/// Number of the point, whether it is a limit, and what moves there.
std::vector<std::tuple<int, bool, std::string>> special_of(const PathBranch& branch) {
  std::vector<std::tuple<int, bool, std::string>> out;
  for (std::size_t k = 0; k < branch.points.size(); ++k)
    if (const PathPoint& point = branch.points[k]; point.kind != PathPoint::Kind::regular)
      out.emplace_back(static_cast<int>(k), point.kind == PathPoint::Kind::limit, point.moving);
  return out;
}

}  // namespace

void bind_equilibria(nb::module_& module) {
  nb::class_<Buckling>(module, "Buckling")
      .def_ro("loads", &Buckling::loads)
      .def_ro("coordinates", &Buckling::coordinates)
      .def_ro("nonlinear", &Buckling::nonlinear)
      .def_ro("warnings", &Buckling::warnings)
      .def_prop_ro("modes", [](const Buckling& found) {
        std::vector<std::tuple<double, std::string, Eigen::VectorXd>> modes;
        for (const BucklingMode& mode : found.modes) modes.emplace_back(mode.factor, mode.text, mode.shape);
        return modes;
      });
  module.def("buckling", &buckling_loads, nb::arg("model"), nb::arg("loads"), nb::arg("count"),
             nb::arg("inputs"));

  nb::class_<PathBranch>(module, "PathBranch")
      .def_ro("parent", &PathBranch::parent)
      .def_ro("leaves_at", &PathBranch::leaves_at)
      .def_ro("sense", &PathBranch::sense)
      .def_ro("end", &PathBranch::end)
      .def_prop_ro("factors", &factors_of)
      .def_prop_ro("values", &values_of)
      .def_prop_ro("unstable", &unstable_of)
      .def_prop_ro("special", &special_of);
  nb::class_<EquilibriumPath>(module, "EquilibriumPath")
      .def_ro("loads", &EquilibriumPath::loads)
      .def_ro("branches", &EquilibriumPath::branches)
      .def_prop_ro("shown", &shown_channels)
      .def_ro("warnings", &EquilibriumPath::warnings)
      .def_prop_ro("channels", [](const EquilibriumPath& path) {
        std::vector<std::tuple<std::string, std::string>> list;
        for (const ChannelInfo& channel : path.channels) list.emplace_back(channel.name, channel.unit);
        return list;
      });
  module.def("equilibrium_path", &path_of, nb::arg("model"), nb::arg("loads"), nb::arg("start"),
             nb::arg("end"), nb::arg("points"), nb::arg("bifurcations"), nb::arg("inputs"),
             nb::arg("progress").none());
}

}  // namespace mimbre::python
