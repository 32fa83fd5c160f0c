#pragma once
#include <vector>

#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// Effective masses of modes φ (columns, φᵀ M φ = 1): (rᵀ M φ)² / (rᵀ M r) in %, six rows: r the body's rigid
/// translations along and rotations about the axes of `interface`.
Eigen::MatrixXd effective_mass(const FeMatrices& matrices, const Interface& interface,
                               const Eigen::MatrixXd& R, const Eigen::MatrixXd& modes);

struct ModeSelection {
  std::vector<Eigen::Index> kept, dropped;  ///< ascending
  Eigen::Matrix<double, 6, 1> share;        ///< %, of the modes that are kept
  bool reached = true;                      ///< in all six directions
};

/// The modes of most effective mass in each direction until `percent` is reached; where all modes together
/// fall short, all that have a thousandth of it.
ModeSelection select_modes(const Eigen::MatrixXd& effective_mass, double percent);

/// How much the lowest elastic frequencies of a free body (K, M over six rigid motions and then its modes)
/// rise when it keeps only some of them: the largest relative rise of the lowest six.
double frequency_rise(const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& mass,
                      const std::vector<Eigen::Index>& kept);

}  // namespace mimbre::fe
