#include <fmt/format.h>
#include <nanobind/eigen/dense.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>

#include "attention.h"
#include "bindings.h"
#include "loaded_model.h"
#include "mimbre/inertia_study.h"
#include "mimbre/mode_selection.h"
#include "mimbre/results.h"
#include "mimbre/statics.h"
#include "mimbre/stress_history.h"
#include "mimbre/unknown_name.h"
#include "mimbre/verify.h"

/// What the program's commands beside run and reduce find out: mimbre/analysis.py gives it names.
namespace mimbre::python {
namespace {

/// What the library says of computations that fail, as the program does.
template <class Work>
auto computed(const Mark& mark, const Work& work) {
  const nb::gil_scoped_release others_run;
  try {
    return work();
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw InputError(mark, error.what());
  } catch (const nb::python_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
}

/// Place of the body of that name. Throws UnknownName, with a name that is like it, where there is none.
int body_number(const std::vector<spec::Body>& bodies, const std::string& name) {
  std::vector<std::string> names;
  for (const spec::Body& body : bodies) {
    if (body.name == name) return static_cast<int>(names.size());
    names.push_back(body.name);
  }
  throw UnknownName(Mark{}, fmt::format("there is no body '{}'{}", name, did_you_mean(name, names)));
}

StaticResult equilibrium(const LoadedModel& loaded, const MethodChoice& method) {
  const RunOptions options = method.options(loaded.model->spec().simulation);
  return computed(Mark{}, [&] { return static_equilibrium(loaded.model, options); });
}

Verification verification(const LoadedModel& loaded, const MethodChoice& method, std::optional<double> until,
                          bool refine, const std::optional<nb::callable>& progress) {
  const spec::Simulation& given = loaded.model->spec().simulation;
  VerifyOptions options;
  options.run = method.options(given);
  RunOptions whole = options.run;
  whole.end = until;
  planned(given, whole);  // else refused
  options.end = until.value_or(-1);
  options.refine = refine;
  double reached = 0;
  Attention attention([&] {
    if (progress) (*progress)(reached);
  });
  options.stop = [&] { return attention.stop(); };
  options.progress = [&](double time, double, double) { reached = time; };
  Verification result = computed(Mark{}, [&] { return verify(loaded.model, options); });
  attention.raise();
  return result;
}

/// Name, unit, largest difference, scale of it and its time, at the shortest step.
auto channels_of(const Verification& verification) {
  std::vector<std::tuple<std::string, std::string, double, double, double, bool>> list;
  for (const Refined& channel : verification.agreement.channels) {
    const Apart& apart = channel.finest();
    list.emplace_back(apart.name, apart.unit, apart.max_difference, apart.scale, apart.time,
                      channel.agrees());
  }
  return list;
}

auto differences_of(const Results& a, const Results& b) {
  std::vector<std::tuple<std::string, double, double, double, double, double>> list;
  for (const ChannelDifference& d : compare(a, b))
    list.emplace_back(d.name, d.max_difference, d.mean_difference, d.at_time, d.amplitude,
                      d.interpolation_error);
  return list;
}

using Spot = std::tuple<int, Eigen::Vector3d, double, double, std::vector<double>>;

/// Hot spots of each body that has stress; `apart` (m) 0: a twentieth of its size.
std::map<std::string, std::vector<Spot>> spots_of(const Results& results, int most, double apart) {
  const nb::gil_scoped_release others_run;
  std::map<std::string, std::vector<Spot>> bodies;
  Eigen::Index first = 0;
  for (const BodyDrawing& body : results.header.bodies) {
    const Eigen::Index mine = first;
    first += body.modes;
    if (body.stress.size() == 0) continue;
    const double size = (body.points.rowwise().maxCoeff() - body.points.rowwise().minCoeff()).norm();
    const StressHistory history =
        stress_history(body, results.time, results.modes.middleCols(mine, body.modes), most,
                       apart > 0 ? apart : 0.05 * size);
    std::vector<Spot>& spots = bodies[body.name];
    for (const HotSpot& s : history.spots)
      spots.emplace_back(body.labels.empty() ? s.node : body.labels[static_cast<std::size_t>(s.node)],
                         body.points.col(s.node), s.von_mises, s.time,
                         std::vector<double>(s.stress.data(), s.stress.data() + 6));
  }
  return bodies;
}

/// Work that calls what `options` have to attend and to report progress: Python's signals and exceptions end
/// it.
template <class Options, class Work>
auto watched(Options& options, const std::optional<nb::callable>& progress, const Mark& mark,
             const Work& work) -> decltype(work()) {
  Attention attention;
  struct Stopped {};
  options.attend = [&] {
    if (attention.stop()) throw Stopped();
  };
  if (progress)
    options.progress = [&](const std::string& stage, double done) {
      attention.call([&] { (*progress)(stage, done); });
      options.attend();
    };
  decltype(work()) result;
  try {
    result = computed(mark, work);
  } catch (const Stopped&) {
    attention.raise();
  }
  return result;
}

ModeSelection selection(const LoadedModel& loaded, const MethodChoice& method, const std::string& body,
                        double error, bool combinations, bool rigid, std::optional<double> end,
                        const std::optional<nb::callable>& progress) {
  const spec::Model& model = loaded.model->spec();
  const int number = body_number(model.bodies, body);
  ModeSelectionOptions options;
  options.error = error;
  options.keep = combinations ? ModeSelectionOptions::Keep::combinations : ModeSelectionOptions::Keep::modes;
  options.pre = rigid ? ModeSelectionOptions::Pre::rigid : ModeSelectionOptions::Pre::candidates;
  options.end = end.value_or(0);
  options.run = method.options(model.simulation);
  const ModeSelection result = watched(options, progress, model.bodies[static_cast<std::size_t>(number)].mark,
                                       [&] { return select_mechanism_modes(model, number, options); });
  if (!result.reached)
    throw Failure(
        fmt::format("no selection of the {} modes reaches {:.3g} %; the last {} are off by "
                    "{:.3g} %; allow a larger error",
                    result.candidates, 100 * error, result.body.modes, 100 * result.achieved_error));
  return result;
}

auto modes_of(const std::vector<ModeSelection::Mode>& modes) {
  std::vector<std::tuple<std::string, double, double>> list;
  for (const ModeSelection::Mode& mode : modes)
    list.emplace_back(mode.name, mode.frequency, mode.participation);
  return list;
}

InertiaStudy terms_of_inertia(const LoadedModel& loaded, const MethodChoice& method, double error,
                              const std::vector<std::string>& outputs, std::optional<double> end,
                              bool measure, const std::optional<nb::callable>& progress) {
  const spec::Model& model = loaded.model->spec();
  InertiaStudyOptions options;
  options.error = error;
  options.outputs = outputs;
  options.end = end.value_or(0);
  options.measure = measure;
  options.run = method.options(model.simulation);
  InertiaStudy study =
      watched(options, progress, Mark{model.file, 0, 0}, [&] { return study_inertia(model, options); });
  if (!measure) {
    study.cost = std::numeric_limits<double>::quiet_NaN();
    for (InertiaStudy::Term& term : study.terms) term.cost = study.cost;
  }
  return study;
}

std::shared_ptr<ReducedBody> without_stress(const ReducedBody& body) {
  auto copy = std::make_shared<ReducedBody>(body);
  copy->stress.resize(0, 0);
  copy->strain.resize(0, 0);
  return copy;
}

}  // namespace

void bind_analysis(nb::module_& module) {
  nb::class_<StaticResult>(module, "StaticResult")
      .def_prop_ro("outputs",
                   [](const StaticResult& r) {
                     std::vector<std::tuple<std::string, double, std::string>> list;
                     for (int k = 0; k < r.output_count; ++k) {
                       const ChannelInfo& channel = r.channels[static_cast<std::size_t>(k)];
                       list.emplace_back(channel.name, r.values[k], channel.unit);
                     }
                     return list;
                   })
      .def_ro("iterations", &StaticResult::iterations)
      .def_ro("residual", &StaticResult::residual)
      .def_ro("stable", &StaticResult::stable)
      .def_ro("sparse", &StaticResult::sparse)
      .def_ro("load_steps", &StaticResult::load_steps)
      .def_ro("warnings", &StaticResult::warnings);
  module.def("static_equilibrium", &equilibrium, nb::arg("model"), nb::arg("method"));

  nb::class_<Verification>(module, "Verification")
      .def_prop_ro("agree", &Verification::agree)
      .def_prop_ro("verdict", [](const Verification& v) { return v.compared() ? verdict(v) : std::string(); })
      .def_prop_ro("ratio", [](const Verification& v) { return v.agreement.ratio; })
      .def_prop_ro("channels", &channels_of)
      .def_prop_ro("failures", &Verification::failures)
      .def_prop_ro("warnings", &Verification::warnings);
  module.def("verify", &verification, nb::arg("model"), nb::arg("method"), nb::arg("until").none(),
             nb::arg("refine"), nb::arg("progress").none());

  module.def("compare", &differences_of, nb::arg("a"), nb::arg("b"));
  module.def("stress", &spots_of, nb::arg("results"), nb::arg("most"), nb::arg("apart"));

  nb::class_<ModeSelection>(module, "ModeSelection")
      .def_prop_ro("body", [](const ModeSelection& s) { return std::make_shared<ReducedBody>(s.body); })
      .def_prop_ro("kept", [](const ModeSelection& s) { return modes_of(s.kept); })
      .def_prop_ro("dropped", [](const ModeSelection& s) { return modes_of(s.dropped); })
      .def_ro("estimated_error", &ModeSelection::estimated_error)
      .def_ro("achieved_error", &ModeSelection::achieved_error)
      .def_ro("candidates", &ModeSelection::candidates)
      .def_ro("runs", &ModeSelection::runs);
  module.def("select", &selection, nb::arg("model"), nb::arg("method"), nb::arg("body"), nb::arg("error"),
             nb::arg("combinations"), nb::arg("rigid"), nb::arg("end").none(), nb::arg("progress").none());

  nb::class_<InertiaStudy>(module, "InertiaStudy")
      .def_prop_ro("neglected",
                   [](const InertiaStudy& s) {
                     std::map<std::string, std::vector<std::string>> names;
                     for (const InertiaStudy::Body& body : s.bodies)
                       if (!body.neglected.empty()) names[body.name] = names_of(body.neglected);
                     return names;
                   })
      .def_prop_ro("terms",
                   [](const InertiaStudy& s) {
                     std::vector<std::tuple<std::string, double, double, double>> list;
                     for (const InertiaStudy::Term& t : s.terms)
                       list.emplace_back(inertia_terms[static_cast<std::size_t>(t.term)].name, t.estimate,
                                         t.error, t.cost);
                     return list;
                   })
      .def_ro("error", &InertiaStudy::error)
      .def_ro("worst", &InertiaStudy::worst)
      .def_ro("cost", &InertiaStudy::cost)
      .def_ro("runs", &InertiaStudy::runs)
      .def_ro("notes", &InertiaStudy::notes);
  module.def("inertia_terms", &terms_of_inertia, nb::arg("model"), nb::arg("method"), nb::arg("error"),
             nb::arg("outputs"), nb::arg("end").none(), nb::arg("measure"), nb::arg("progress").none());
  module.def("without_stress", &without_stress, nb::arg("body"));
}

}  // namespace mimbre::python
