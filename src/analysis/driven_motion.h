#pragma once
#include <Eigen/Core>
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// How far it is from one position to the next at most, by the scales of the coordinates.
inline constexpr double most_moved = 0.5;

/// The motion that drives and loops prescribe at an instant, without forces: positions by Newton's method,
/// velocities and accelerations by linear equations, all by the least change along the scales of the
/// coordinates where something is free. Modal amplitudes stay as they are unless loops cannot close without
/// them. Dense: for mechanisms of up to some hundred coordinates.
class DrivenMotion {
 public:
  /// `leads`, by equation: it decides on the motion. Others, drives that only exert forces, do not.
  DrivenMotion(relative::RelativeSystem& system, std::vector<char> leads);

  /// Makes positions near s.q, velocities and accelerations those of s.time; false where the positions do not
  /// close. Multipliers stay.
  bool close(State& s);
  /// The same at or next to a singular position, which s has been extrapolated to with its velocities and
  /// accelerations: what the equations hardly determine there stays as it arrives.
  bool arrive(State& s);
  /// The largest violation that the last close() or arrive() left, by the scales of the equations.
  double violation() const { return violation_; }
  /// How much the last close() changed the positions, by the scales of the coordinates.
  double change() const { return change_; }
  /// Of the equations that lead, by the scales of equations and coordinates, at s.q.
  Eigen::MatrixXd jacobian(const State& s);
  /// Of all equations, likewise.
  Eigen::MatrixXd whole_jacobian(const State& s);
  const Eigen::VectorXd& scale() const { return scale_; }
  bool leads(int equation) const { return leads_[static_cast<std::size_t>(equation)] != 0; }

 private:
  Eigen::VectorXd follow(const Eigen::MatrixXd& jacobian, const double* violation) const;
  Eigen::MatrixXd moving(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& weight) const;
  double leading(const double* phi) const;
  void follow_rates(State& s);

  relative::RelativeSystem& system_;
  std::vector<char> leads_;
  Eigen::VectorXd scale_, rigid_;  ///< of coordinates; the same but 0 for modal amplitudes
  double violation_ = 0, change_ = 0;
  double dependent_;     ///< what an equation adds to others, as a share of the largest, is none below
  bool flexes_ = false;  ///< the loops do not close without modes
};

}  // namespace mimbre
