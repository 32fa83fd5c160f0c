#include <fmt/format.h>
#include <nanobind/eigen/dense.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/inverse_dynamics.h"
#include "mimbre/kinematics.h"
#include "mimbre/results.h"

/// Kinematics and inverse dynamics; python/mimbre/motion.py documents them.
namespace mimbre::python {
namespace {

/// Runs without the interpreter; what cannot be computed is a Failure, as in the program.
template <class Work>
auto computed(const Work& work) {
  const nb::gil_scoped_release others_run;
  try {
    return work();
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw InputError(Mark{}, error.what());
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

std::shared_ptr<Results> results_of(const ResultsHeader& header, const std::vector<ResultsRow>& rows) {
  auto results = std::make_shared<Results>();
  results->header = header;
  const auto instants = static_cast<Eigen::Index>(rows.size());
  results->time.resize(instants);
  results->channels.resize(instants, static_cast<Eigen::Index>(header.channels.size()));
  results->modes.resize(instants, rows.empty() ? 0 : rows.front().modes.size());
  for (Eigen::Index k = 0; k < instants; ++k) {
    const ResultsRow& row = rows[static_cast<std::size_t>(k)];
    results->time[k] = row.time;
    results->channels.row(k) = row.channels.transpose();
    results->modes.row(k) = row.modes.transpose();
    results->poses.push_back(row.poses);
  }
  return results;
}

constexpr const char* kinds[] = {"dead_centre", "change_point", "limit", "reversal"};

Kinematics followed(const LoadedModel& loaded, double start, std::optional<double> end, int steps,
                    const std::map<std::string, double>& inputs) {
  KinematicsOptions options;
  options.start = start;
  options.end = end;
  options.steps = steps;
  options.inputs = inputs;
  return computed([&] { return kinematics(loaded.model, options); });
}

auto special_of(const Kinematics& found) {
  std::vector<std::tuple<std::string, double, std::string, double, double, std::string>> list;
  for (const SpecialPosition& s : found.special)
    list.emplace_back(kinds[static_cast<std::size_t>(s.kind)], s.time, s.joint, s.position, s.driven, s.text);
  return list;
}

/// Name, positions, and velocities with accelerations or neither.
using Column = std::tuple<std::string, std::vector<double>, std::vector<double>, std::vector<double>>;

InverseDynamics forces(const LoadedModel& loaded, const std::optional<std::string>& file,
                       const std::vector<double>& time, const std::vector<Column>& columns, double smooth,
                       const std::vector<std::string>& along, bool quasistatic, double step, double start,
                       std::optional<double> end, int steps, const std::map<std::string, double>& inputs) {
  const spec::Model& spec = loaded.model->spec();
  InverseDynamicsOptions options;
  options.smooth = smooth;
  options.start = start;
  options.end = end;
  options.steps = steps;
  options.step = step;
  options.inputs = inputs;
  options.flexible =
      quasistatic ? InverseDynamicsOptions::Flexible::quasistatic : InverseDynamicsOptions::Flexible::dynamic;
  for (const std::string& name : along) options.forces.push_back(find_coordinate(spec, name));
  std::optional<PrescribedMotion> motion;
  if (file) motion = read_motion_table(*file, spec);
  if (!columns.empty()) {
    motion.emplace();
    motion->time = time;
    for (const auto& [name, position, velocity, acceleration] : columns)
      motion->columns.push_back({find_coordinate(spec, name), position, velocity, acceleration});
  }
  return computed([&] { return inverse_dynamics(loaded.model, motion ? &*motion : nullptr, options); });
}

}  // namespace

void bind_motion(nb::module_& module) {
  nb::class_<Kinematics>(module, "Kinematics")
      .def_ro("time", &Kinematics::time)
      .def_ro("names", &Kinematics::names)
      .def_ro("position", &Kinematics::position)
      .def_ro("velocity", &Kinematics::velocity)
      .def_ro("acceleration", &Kinematics::acceleration)
      .def_ro("regularity", &Kinematics::regularity)
      .def_ro("coordinates", &Kinematics::coordinates)
      .def_ro("equations", &Kinematics::equations)
      .def_ro("mobility", &Kinematics::mobility)
      .def_ro("drives", &Kinematics::drives)
      .def_ro("free", &Kinematics::free)
      .def_ro("free_joints", &Kinematics::free_joints)
      .def_ro("redundant", &Kinematics::redundant)
      .def_ro("redundant_names", &Kinematics::redundant_names)
      .def_ro("warnings", &Kinematics::warnings)
      .def_ro("complete", &Kinematics::complete)
      .def_prop_ro("special", &special_of)
      .def_prop_ro("results", [](const Kinematics& k) { return results_of(k.header, k.rows); });
  module.def("kinematics", &followed, nb::arg("model"), nb::arg("start"), nb::arg("end").none(),
             nb::arg("steps"), nb::arg("inputs"));

  nb::class_<InverseDynamics>(module, "InverseDynamics")
      .def_ro("time", &InverseDynamics::time)
      .def_ro("names", &InverseDynamics::names)
      .def_ro("units", &InverseDynamics::units)
      .def_ro("position", &InverseDynamics::position)
      .def_ro("velocity", &InverseDynamics::velocity)
      .def_ro("acceleration", &InverseDynamics::acceleration)
      .def_ro("force", &InverseDynamics::force)
      .def_ro("free", &InverseDynamics::free)
      .def_ro("redundant", &InverseDynamics::redundant)
      .def_ro("residual", &InverseDynamics::residual)
      .def_ro("warnings", &InverseDynamics::warnings)
      .def_prop_ro("results", [](const InverseDynamics& d) { return results_of(d.header, d.rows); });
  module.def("inverse_dynamics", &forces, nb::arg("model"), nb::arg("file").none(), nb::arg("time"),
             nb::arg("columns"), nb::arg("smooth"), nb::arg("along"), nb::arg("quasistatic"), nb::arg("step"),
             nb::arg("start"), nb::arg("end").none(), nb::arg("steps"), nb::arg("inputs"));
}

}  // namespace mimbre::python
