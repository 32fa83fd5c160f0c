#pragma once
#include <functional>
#include <string>
#include <vector>

#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "mimbre/spec.h"

/// The fewest modes of a flexible body that its mechanism needs, to a stated error of its deflections.
namespace mimbre {

struct ModeSelectionOptions {
  double error = 0.01;  ///< the largest that is allowed, a ratio; see deflection_error
  enum class Pre {
    candidates,  ///< amplitudes from a run with all modes
    rigid        ///< from a run with the body rigid: forces at its frames and its motion, then its response
  } pre = Pre::candidates;
  enum class Keep {
    combinations,  ///< combinations of the modes
    modes          ///< some of the modes as they are
  } keep = Keep::combinations;
  double end = 0;  ///< s; 0: the model's
  RunOptions run;
  /// Called with what is being done and how much of it is, 0 to 1.
  std::function<void(const std::string& stage, double done)> progress;
  /// Called at every instant of output of the runs, if given. What it throws ends the selection; no
  /// std::runtime_error, which is what a run that fails throws.
  std::function<void()> attend;
};

/// Amplitudes of one body in a run, modes × instants.
struct AmplitudeHistory {
  Eigen::VectorXd time;
  Eigen::MatrixXd amplitudes;
};

struct ModeSelection {
  struct Mode {
    std::string name;
    double frequency = 0;      ///< Hz, of the candidate
    double participation = 0;  ///< error when it alone is dropped, in the run with all modes
  };
  ReducedBody body;                 ///< with "mode selection" among its checks
  std::vector<Mode> kept, dropped;  ///< of the combinations, `frequency` is that of each alone
  double estimated_error = 0, achieved_error = 0;
  int candidates = 0;
  int runs = 0;  ///< of the mechanism
  bool reached = false;
};

/// Calls record at every instant of output of a run. Throws std::runtime_error with the place where a step
/// fails.
void record_run(const spec::Model& model, const ModeSelectionOptions& options,
                const std::function<void(const ResultsRow&)>& record);

/// A run of the model in which the flexible body number `body` is `replacement`. Throws as
/// record_run does.
AmplitudeHistory amplitudes_with(const spec::Model& model, int body, const ReducedBody& replacement,
                                 const ModeSelectionOptions& options);

/// Error of the deflections in `run` with the modes of `selected`, against those of the run with all.
double selection_error(const ReducedBody& candidates, const AmplitudeHistory& all,
                       const ReducedBody& selected, const AmplitudeHistory& run);

/// Ranks the body's modes by what they do in a run, keeps as few as the error allows, and runs the mechanism
/// with them: more where that shows a larger error, fewer where it shows a smaller one.
/// Throws std::invalid_argument for a body that is not flexible, not linear in its amplitudes or that does
/// not deflect in the run, std::runtime_error when the run with all modes fails.
ModeSelection select_mechanism_modes(const spec::Model& model, int body, const ModeSelectionOptions& options);

}  // namespace mimbre
