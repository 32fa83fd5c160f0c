#include "mimbre/mode_selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "analysis/modes/mode_participation.h"
#include "analysis/rigid_response.h"
#include "reduction/bases/project_modes.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Keep = ModeSelectionOptions::Keep;

const ReducedBody& candidates_of(const spec::Model& model, int body) {
  const spec::Body& b = model.bodies[static_cast<std::size_t>(body)];
  if (!b.flexible || b.flexible->modes == 0)
    throw std::invalid_argument(
        fmt::format("the body '{}' has no modes to select from: it is rigid", b.name));
  if (b.flexible->second_order || b.flexible->ancf)
    throw std::invalid_argument(
        fmt::format("the displacements of the body '{}' are not linear in its amplitudes, so that its modes "
                    "cannot be dropped or combined",
                    b.name));
  return *b.flexible;
}

/// The columns that make a body of `count` of its modes or combinations.
MatrixXd kept_columns(const ReducedBody& body, const ModeRanking& ranking, const MatrixXd& combinations,
                      Keep keep, int count) {
  if (keep == Keep::combinations) return combinations.leftCols(count);
  std::vector<int> kept(ranking.order.begin(), ranking.order.begin() + count);
  std::sort(kept.begin(), kept.end());
  MatrixXd T = MatrixXd::Zero(body.modes, count);
  for (int k = 0; k < count; ++k) T(kept[static_cast<std::size_t>(k)], k) = 1;
  return T;
}

std::string mode_name(int k) { return fmt::format("mode {}", k + 1); }

ReducedBody body_of(const ReducedBody& body, const MatrixXd& T, Keep keep) {
  ReducedBody b = project_modes(body, T);
  if (keep == Keep::modes)
    for (int k = 0; k < b.modes; ++k) {
      Index from = 0;
      T.col(k).maxCoeff(&from);
      b.mode_names[static_cast<std::size_t>(k)] = mode_name(static_cast<int>(from));
    }
  make_orthogonal(b);
  return b;
}

double frequency(double stiffness, double mass) {
  return std::sqrt(std::max(0.0, stiffness / mass)) / (2 * std::numbers::pi);
}

void add_lists(const ReducedBody& body, const ModeRanking& ranking, const ModeCombinations& combinations,
               Keep keep, int count, ModeSelection& s) {
  const auto mode = [&](int k) {
    return ModeSelection::Mode{mode_name(k), frequency(body.stiffness(k, k), body.mass_matrix(k, k)),
                               ranking.participation[k]};
  };
  if (keep == Keep::modes) {
    for (int k = 0; k < body.modes; ++k) (k < count ? s.kept : s.dropped).push_back(mode(ranking.order[k]));
    return;
  }
  for (int k = 0; k < combinations.T.cols(); ++k) {
    const VectorXd t = combinations.T.col(k);
    (k < count ? s.kept : s.dropped)
        .push_back({fmt::format("combination {}", k + 1),
                    frequency(t.dot(body.stiffness * t), t.dot(body.mass_matrix * t)),
                    combinations.participation[k]});
  }
}

}  // namespace

void record_run(const spec::Model& model, const ModeSelectionOptions& options,
                const std::function<void(const ResultsRow&)>& record) {
  Simulation simulation(Model::compile(model), options.run);
  const double end = options.end > 0 ? options.end : model.simulation.end, h = simulation.step_size();
  const auto steps = static_cast<Index>(std::round(end / h));
  const auto stride =
      std::max<Index>(1, static_cast<Index>(std::round(model.simulation.output_interval / h)));
  ResultsRow row;
  for (Index k = 0; k <= steps; ++k) {
    if (k > 0) {
      const StepReport report = simulation.step();
      if (!report.ok()) throw std::runtime_error(simulation.explain(report));
    }
    if (k % stride != 0) continue;
    if (options.attend) options.attend();
    simulation.sample(row);
    record(row);
  }
}

AmplitudeHistory amplitudes_with(const spec::Model& model, int body, const ReducedBody& replacement,
                                 const ModeSelectionOptions& options) {
  spec::Model changed = model;
  changed.bodies[static_cast<std::size_t>(body)].flexible = std::make_shared<const ReducedBody>(replacement);
  changed.outputs.clear();  // of amplitudes that may be gone
  Index first = 0;
  for (int k = 0; k < body; ++k)
    if (const spec::Body& b = model.bodies[static_cast<std::size_t>(k)]; b.flexible)
      first += b.flexible->modes +
               (b.flexible->second_order ? static_cast<Index>(b.flexible->second_order->products.size()) : 0);
  std::vector<double> time, amplitudes;
  record_run(changed, options, [&](const ResultsRow& row) {
    time.push_back(row.time);
    for (Index k = 0; k < replacement.modes; ++k) amplitudes.push_back(row.modes[first + k]);
  });
  const auto instants = static_cast<Index>(time.size());
  return {Eigen::Map<const VectorXd>(time.data(), instants),
          Eigen::Map<const MatrixXd>(amplitudes.data(), replacement.modes, instants)};
}

double selection_error(const ReducedBody& candidates, const AmplitudeHistory& all,
                       const ReducedBody& selected, const AmplitudeHistory& run) {
  const MatrixXd whole = frame_deflections(candidates, all.amplitudes);
  return deflection_error(frame_deflections(selected, run.amplitudes) - whole, deflection_scales(whole));
}

ModeSelection select_mechanism_modes(const spec::Model& model, int body,
                                     const ModeSelectionOptions& options) {
  const ReducedBody& candidates = candidates_of(model, body);
  const auto notify = [&](const std::string& stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  ModeSelection s;
  s.candidates = candidates.modes;
  notify("run with all modes", 0);
  const AmplitudeHistory all = amplitudes_with(model, body, candidates, options);
  ++s.runs;
  MatrixXd seen = all.amplitudes;
  if (options.pre == ModeSelectionOptions::Pre::rigid) {
    notify("run with the body rigid", 0);
    seen = rigid_response(model, body, options).amplitudes;
    ++s.runs;
  }
  const ModeRanking ranking = rank_modes(candidates, seen);
  const ModeCombinations combinations = combine_modes(candidates, seen);
  const bool combine = options.keep == Keep::combinations;
  const VectorXd& estimates = combine ? combinations.error : ranking.error;
  const int most = static_cast<int>(estimates.size()) - 1;

  struct Trial {
    int count;
    double error;
    ReducedBody body;
  };
  const auto trial = [&](int count) {
    notify(fmt::format("run with {} modes", count), static_cast<double>(count) / most);
    ReducedBody b = body_of(
        candidates, kept_columns(candidates, ranking, combinations.T, options.keep, count), options.keep);
    ++s.runs;
    try {
      const double error = selection_error(candidates, all, b, amplitudes_with(model, body, b, options));
      return Trial{count, error, std::move(b)};
    } catch (const std::runtime_error&) {
      return Trial{count, INFINITY, std::move(b)};  // too few modes may leave nothing that fits the joints
    }
  };
  int count = 1;
  while (count < most && !(estimates[count] <= options.error)) ++count;
  Trial best = trial(count);
  const bool above = best.error <= options.error;
  while (!(best.error <= options.error) && best.count < most) best = trial(best.count + 1);
  while (above && best.count > 1) {
    Trial fewer = trial(best.count - 1);
    if (!(fewer.error <= options.error)) break;
    best = std::move(fewer);
  }

  s.body = std::move(best.body);
  s.achieved_error = best.error;
  s.estimated_error = estimates[best.count];
  s.reached = best.error <= options.error;
  add_lists(candidates, ranking, combinations, options.keep, best.count, s);
  s.body.checks.push_back(
      {"mode selection", s.reached,
       fmt::format("{} {} of {} modes for the mechanism '{}': deflections differ from those with all by "
                   "{:.3g} % (estimated {:.3g} %, asked {:.3g} %)",
                   best.count, combine ? "combinations" : "of them", s.candidates,
                   model.title.empty() ? model.file : model.title, 100 * s.achieved_error,
                   100 * s.estimated_error, 100 * options.error)});
  return s;
}

}  // namespace mimbre
