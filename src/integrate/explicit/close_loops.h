#pragma once
#include <Eigen/Core>
#include <algorithm>

#include "dynamics/system.h"

/// Projection onto the constraints after a step. `take_back(violation, d)` finds the motion d that takes a
/// violation of Φ or Φ̇ back, by a matrix that lies near.
namespace mimbre {

/// Of the equations after the projection, by their scales; rounds of it with one matrix.
constexpr double closed_loops = 1e-14;
constexpr int rounds_of_closing = 4;

/// Moves q onto Φ(t, q) = 0, evaluated at last. False: it is not there after the rounds. `zero`: zeros; `d`:
/// scratch.
template <class TakeBack>
bool close_positions_by(System& system, double t, Eigen::VectorXd& q, const Eigen::VectorXd& v,
                        const Eigen::VectorXd& zero, Eigen::VectorXd& d, const TakeBack& take_back) {
  const Scales& scales = system.scales();
  const double enough = std::max(closed_loops, scales.round_off);
  for (int round = 0;; ++round) {
    system.kinematics(t, q.data(), v.data(), zero.data());
    if (scales.of_equations(system.phi()) <= enough) return true;
    if (round == rounds_of_closing) return false;
    take_back(system.phi(), d);
    system.retract(q.data(), d.data(), q.data());
  }
}

/// Moves v, evaluated before, onto Φ̇ = 0.
template <class TakeBack>
void close_velocities_by(System& system, double t, const Eigen::VectorXd& q, Eigen::VectorXd& v,
                         const Eigen::VectorXd& zero, Eigen::VectorXd& d, const TakeBack& take_back) {
  const Scales& scales = system.scales();
  for (int round = 0; round < rounds_of_closing; ++round) {
    take_back(system.phi_dot(), d);
    v += d;
    if (scales.of_coordinates(d.data()) <= closed_loops * scales.of_coordinates(v.data())) break;
    system.kinematics(t, q.data(), v.data(), zero.data());
  }
}

}  // namespace mimbre
