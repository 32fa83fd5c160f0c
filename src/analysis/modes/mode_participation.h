#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/reduced_body.h"

/// What of a body's deflection in a run each of its modes makes, and which of them it takes.
namespace mimbre {

/// Displacements of the body's frames by its modes, body axes, m: 3·frames × instants.
/// `amplitudes`: modes × instants.
Eigen::MatrixXd frame_deflections(const ReducedBody& body, const Eigen::MatrixXd& amplitudes);

/// What the errors of each frame's deflection are measured by: its own largest deflection, but at least a
/// hundredth of that of the frame which moves most, so that places at rest do not count for their noise.
Eigen::VectorXd deflection_scales(const Eigen::MatrixXd& deflections);

/// Of the frames the largest mean (over the instants) distance by the scale of the frame; a ratio.
/// `differences`: 3·frames × instants.
double deflection_error(const Eigen::MatrixXd& differences, const Eigen::VectorXd& scales);

/// Modes in the order of how much they are needed, most needed first: from all of them, again and again the
/// one is dropped whose part of the deflection, together with what was dropped before, is the smallest.
struct ModeRanking {
  std::vector<int> order;
  Eigen::VectorXd error;          ///< by number of modes kept, 0 to all: what the rest takes along
  Eigen::VectorXd participation;  ///< of each mode: the error when it alone is dropped
};
ModeRanking rank_modes(const ReducedBody& body, const Eigen::MatrixXd& amplitudes);

/// Proper orthogonal decomposition of a run in the norm of strain energy (Kerschen et al. 2005): combinations
/// of modes in the order of the energy that they carry on average, the first k of which are the best k.
struct ModeCombinations {
  /// Modes × combinations, Tᵀ K T = I; no more than carry something beyond round-off.
  Eigen::MatrixXd T;
  Eigen::VectorXd error;          ///< by number of combinations kept, from 0: what the rest takes along
  Eigen::VectorXd share;          ///< of each: its part of the mean strain energy
  Eigen::VectorXd participation;  ///< of each: the error when it alone is dropped
};
/// Throws std::invalid_argument when the stiffness is not positive definite or nothing deflects.
ModeCombinations combine_modes(const ReducedBody& body, const Eigen::MatrixXd& amplitudes);

}  // namespace mimbre
