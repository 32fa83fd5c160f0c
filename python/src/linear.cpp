#include <nanobind/eigen/dense.h>
#include <nanobind/stl/complex.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "attention.h"
#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/campbell.h"
#include "mimbre/linear_report.h"
#include "mimbre/linearise.h"
#include "mimbre/modes.h"
#include "mimbre/trim.h"

/// Linear models, modes and Campbell diagrams: mimbre/linear.py gives them names.
namespace mimbre::python {
namespace {

/// Runs without the interpreter's lock; failures are those of the program.
template <class Work>
auto computed(const Work& work) {
  const nb::gil_scoped_release others_run;
  try {
    return work();
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw InputError(Mark{}, error.what());
  } catch (const nb::python_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

using Inputs = std::map<std::string, double>;

/// `at`: "automatic", "equilibrium", "steady", "start" or "time". `driving`: of steady driving, which is then
/// the point.
LinearOptions options_of(const LoadedModel& loaded, const MethodChoice& method, const std::string& at,
                         double time, const Inputs& inputs, int delay_order,
                         const std::optional<TrimConditions>& driving) {
  using At = LinearPoint::At;
  LinearOptions options;
  options.run = method.options(loaded.model->spec().simulation);
  options.run.inputs = inputs;
  options.delay_order = delay_order;
  options.point.time = time;
  options.point.at = at == "equilibrium" ? At::equilibrium
                     : at == "steady"    ? At::steady
                     : at == "start"     ? At::start
                     : at == "time"      ? At::time
                                         : At::automatic;
  if (driving) {
    options.point.at = At::trim;
    options.trim = *driving;
  }
  return options;
}

auto names_of(const std::vector<LinearName>& names) {
  std::vector<std::pair<std::string, std::string>> list;
  for (const LinearName& n : names) list.emplace_back(n.name, n.unit);
  return list;
}

auto shares_of(const std::vector<ModeShare>& shares) {
  std::vector<std::pair<std::string, double>> list;
  for (const ModeShare& s : shares) list.emplace_back(s.name, s.share);
  return list;
}

const char* kind_of(const Mode& mode) {
  return mode.kind == Mode::Kind::rigid ? "rigid" : mode.kind == Mode::Kind::real ? "real" : "oscillating";
}

/// The models of a family come from Python, by the value of its parameter; or it varies an input or a held
/// condition of one model.
CampbellDiagram diagram(const nb::callable& model_at, const std::vector<double>& values,
                        const std::string& parameter, double rad_per_second,
                        const std::vector<double>& orders, const MethodChoice& method, const std::string& at,
                        double time, const Inputs& inputs, const std::string& varied_input,
                        const std::string& varied_condition, int most, int delay_order,
                        const std::optional<TrimConditions>& driving) {
  CampbellOptions options;
  options.parameter = parameter;
  options.rad_per_second = rad_per_second;
  options.orders = orders;
  options.most = most;
  Attention attention;
  struct Stopped {};
  NeighbouringModes neighbours;
  const ModesBy modes = [&](double value, ModesSolver solver) {
    std::shared_ptr<LoadedModel> loaded;
    attention.call([&] { loaded = nb::cast<std::shared_ptr<LoadedModel>>(model_at(value)); });
    if (!loaded || attention.stop()) throw Stopped();
    Inputs given = inputs;
    if (!varied_input.empty()) given[varied_input] = value;
    ModesOptions here;
    here.linear = options_of(*loaded, method, at, time, given, delay_order, driving);
    if (!varied_condition.empty()) *held_condition(here.linear.trim, varied_condition) = value;
    here.most = with_neighbours(most);
    here.solver = solver;
    return neighbours.find(value, loaded->model, here);
  };
  CampbellDiagram found;
  try {
    found = computed([&] {
      const ModesSolver solver =
          most > 0 && values.size() > 1 && !driving
              ? one_solver(modes, values.front(), values.back(), ModesSolver::automatic)
              : ModesSolver::dense;
      return campbell([&](double value) { return modes(value, solver); }, values, options);
    });
  } catch (const Stopped&) {
    attention.raise();
  }
  return found;
}

}  // namespace

void bind_linear(nb::module_& module) {
  nb::class_<TrimConditions>(module, "TrimConditions")
      .def(nb::init<>())
      .def("hold",
           [](TrimConditions& c, const std::string& name, double value) { *held_condition(c, name) = value; })
      .def_rw("body", &TrimConditions::body)
      .def_rw("find", &TrimConditions::find);
  nb::class_<LinearModel>(module, "LinearModel")
      .def_ro("title", &LinearModel::title)
      .def_ro("point", &LinearModel::point)
      .def_ro("time", &LinearModel::time)
      .def_prop_ro("a", [](const LinearModel& m) { return m.A; })
      .def_prop_ro("b", [](const LinearModel& m) { return m.B; })
      .def_prop_ro("c", [](const LinearModel& m) { return m.C; })
      .def_prop_ro("d", [](const LinearModel& m) { return m.D; })
      .def_prop_ro("mass", [](const LinearModel& m) { return m.mass; })
      .def_prop_ro("damping", [](const LinearModel& m) { return m.damping; })
      .def_prop_ro("stiffness", [](const LinearModel& m) { return m.stiffness; })
      .def_prop_ro("states", [](const LinearModel& m) { return names_of(m.states); })
      .def_prop_ro("inputs", [](const LinearModel& m) { return names_of(m.inputs); })
      .def_prop_ro("outputs", [](const LinearModel& m) { return names_of(m.outputs); })
      .def_ro("input_values", &LinearModel::input_values)
      .def_ro("output_values", &LinearModel::output_values)
      .def_ro("coordinates", &LinearModel::coordinates)
      .def_ro("speeds", &LinearModel::speeds)
      .def_ro("redundant", &LinearModel::redundant)
      .def_ro("unsteady", &LinearModel::unsteady)
      .def_ro("varies", &LinearModel::varies)
      .def_ro("notes", &LinearModel::notes)
      .def_ro("warnings", &LinearModel::warnings)
      .def("save", [](const LinearModel& m, const std::string& path, const std::vector<double>& frequencies) {
        computed([&] {
          write_linear_file(m, path, frequencies);
          return 0;
        });
      });
  module.def(
      "linearise",
      [](const LoadedModel& loaded, const MethodChoice& method, const std::string& at, double time,
         const Inputs& inputs, int delay_order, const std::optional<TrimConditions>& driving) {
        const LinearOptions options = options_of(loaded, method, at, time, inputs, delay_order, driving);
        return computed([&] { return linearise(loaded.model, options); });
      },
      nb::arg("model"), nb::arg("method"), nb::arg("at"), nb::arg("time"), nb::arg("inputs"),
      nb::arg("delay_order"), nb::arg("driving").none());

  nb::class_<mimbre::Mode>(module, "EigenMode")
      .def_prop_ro("kind", [](const mimbre::Mode& m) { return std::string(kind_of(m)); })
      .def_ro("value", &mimbre::Mode::value)
      .def_ro("from_ground", &mimbre::Mode::fixed)
      .def_ro("frequency", &mimbre::Mode::frequency)
      .def_ro("damping", &mimbre::Mode::damping)
      .def_ro("grows", &mimbre::Mode::grows)
      .def_ro("multiplier", &mimbre::Mode::multiplier)
      .def_ro("whirl", &mimbre::Mode::whirl)
      .def_prop_ro("blades", [](const mimbre::Mode& m) { return shares_of(m.blades); })
      .def_ro("gravity", &mimbre::Mode::gravity)
      .def_ro("text", &mimbre::Mode::text)
      .def_prop_ro("shape", [](const mimbre::Mode& m) { return m.motion; })
      .def_prop_ro("coordinates", [](const mimbre::Mode& m) { return shares_of(m.coordinates); })
      .def_prop_ro("bodies", [](const mimbre::Mode& m) { return shares_of(m.bodies); })
      .def_prop_ro("elastic", [](const mimbre::Mode& m) { return shares_of(m.elastic); });
  nb::class_<LinearisedModes>(module, "LinearisedModes")
      .def_prop_ro("point", [](const LinearisedModes& m) { return m.model.point; })
      .def_prop_ro("notes", [](const LinearisedModes& m) { return m.model.notes; })
      .def_prop_ro("warnings", [](const LinearisedModes& m) { return m.model.warnings; })
      .def_prop_ro("coordinates", [](const LinearisedModes& m) { return names_of(m.coordinates); })
      .def_ro("modes", &LinearisedModes::modes)
      .def_ro("turning", &LinearisedModes::turning)
      .def_ro("period", &LinearisedModes::period)
      .def("save",
           [](const LinearisedModes& m, const std::string& path) {
             computed([&] {
               write_modes(m, path);
               return 0;
             });
           })
      .def("save_vtk", [](const LinearisedModes& m, const std::string& folder) {
        return computed([&] { return write_modes_vtk(m, folder); });
      });
  module.def(
      "modes",
      [](const LoadedModel& loaded, const MethodChoice& method, const std::string& at, double time,
         const Inputs& inputs, int delay_order, int most, const std::string& solver,
         const std::optional<TrimConditions>& driving) {
        ModesOptions options;
        options.linear = options_of(loaded, method, at, time, inputs, delay_order, driving);
        options.most = most;
        options.solver = solver == "dense"    ? ModesSolver::dense
                         : solver == "sparse" ? ModesSolver::sparse
                                              : ModesSolver::automatic;
        options.shapes = true;
        return computed([&] { return find_modes(loaded.model, options); });
      },
      nb::arg("model"), nb::arg("method"), nb::arg("at"), nb::arg("time"), nb::arg("inputs"),
      nb::arg("delay_order"), nb::arg("most"), nb::arg("solver"), nb::arg("driving").none());

  nb::class_<TrimResult>(module, "TrimResult")
      .def_ro("body", &TrimResult::body)
      .def_ro("speed", &TrimResult::speed)
      .def_ro("yaw_rate", &TrimResult::yaw_rate)
      .def_ro("lateral_acceleration", &TrimResult::lateral_acceleration)
      .def_ro("sideslip", &TrimResult::sideslip)
      .def_ro("residual", &TrimResult::residual)
      .def_prop_ro("inputs",
                   [](const TrimResult& r) {
                     std::map<std::string, double> found;
                     for (const TrimResult::Input& input : r.found) found[input.name] = input.value;
                     return found;
                   })
      .def_prop_ro("outputs", [](const TrimResult& r) {
        std::vector<std::tuple<std::string, double, std::string>> list;
        for (int k = 0; k < r.output_count; ++k)
          list.emplace_back(r.channels[k].name, r.values[k], r.channels[k].unit);
        return list;
      });
  module.def(
      "trim",
      [](const LoadedModel& loaded, const TrimConditions& conditions, const Inputs& inputs) {
        RunOptions options;
        options.inputs = inputs;
        return computed([&] { return trim(loaded.model, conditions, options); });
      },
      nb::arg("model"), nb::arg("conditions"), nb::arg("inputs"));

  nb::class_<CampbellDiagram>(module, "CampbellDiagram")
      .def_ro("values", &CampbellDiagram::values)
      .def_prop_ro("branches",
                   [](const CampbellDiagram& d) {
                     std::vector<std::tuple<std::string, std::vector<std::complex<double>>,
                                            std::vector<double>, std::vector<int>>>
                         list;
                     for (const ModeBranch& b : d.branches)
                       list.emplace_back(b.name, b.values, b.whirl, b.half_of);
                     return list;
                   })
      .def_prop_ro("criticals",
                   [](const CampbellDiagram& d) {
                     std::vector<std::tuple<int, double, double, double>> list;
                     for (const auto& c : d.criticals)
                       list.emplace_back(c.branch, c.value, c.order, c.frequency);
                     return list;
                   })
      .def_prop_ro("onsets",
                   [](const CampbellDiagram& d) {
                     std::vector<std::tuple<int, double, double, bool>> list;
                     for (const auto& o : d.onsets)
                       list.emplace_back(o.branch, o.value, o.frequency, o.grows);
                     return list;
                   })
      .def_prop_ro("meetings",
                   [](const CampbellDiagram& d) {
                     std::vector<std::tuple<int, int, double, double, bool>> list;
                     for (const auto& m : d.meetings)
                       list.emplace_back(m.first, m.second, m.value, m.real, m.parts);
                     return list;
                   })
      .def_ro("warnings", &CampbellDiagram::warnings);
  module.def("campbell", &diagram, nb::arg("model_at"), nb::arg("values"), nb::arg("parameter"),
             nb::arg("rad_per_second"), nb::arg("orders"), nb::arg("method"), nb::arg("at"), nb::arg("time"),
             nb::arg("inputs"), nb::arg("varied_input"), nb::arg("varied_condition"), nb::arg("most"),
             nb::arg("delay_order"), nb::arg("driving").none());
}

}  // namespace mimbre::python
