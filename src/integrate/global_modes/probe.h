#pragma once
#include <Eigen/Core>

#include "dynamics/state.h"
#include "dynamics/system.h"

namespace mimbre::global_modes {

/// A system at other positions, all dense; before steps, since it allocates.
class Probe {
 public:
  Probe(System& system, double time);

  System& system() { return system_; }
  /// Φ by the scales of the equations.
  Eigen::VectorXd violations(const Eigen::VectorXd& q);
  /// M, and the Jacobian with rows by the scales of the equations.
  void evaluate(const Eigen::VectorXd& q);
  const Eigen::MatrixXd& mass() const { return mass_; }
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }
  /// r of inertia and weight; generalised forces of unit forces at elements (System::element_loads).
  Eigen::VectorXd unloaded_residual(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                    const Eigen::VectorXd& a) {
    return system_.unloaded_residual(time_, q, v, a);
  }
  Eigen::MatrixXd element_loads(const Eigen::VectorXd& q) { return system_.element_loads(time_, q); }
  /// q moved by x (velocities × 1).
  Eigen::VectorXd moved(const Eigen::VectorXd& q, const Eigen::VectorXd& x);
  const Eigen::VectorXd& scale() const { return scale_; }  ///< of the coordinates

 private:
  System& system_;
  const double time_;
  Eigen::VectorXd none_, multipliers_, scale_, equation_scale_;
  Eigen::MatrixXd mass_, jacobian_;
};

}  // namespace mimbre::global_modes
