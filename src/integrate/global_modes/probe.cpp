#include "integrate/global_modes/probe.h"

namespace mimbre::global_modes {

using Eigen::VectorXd;

Probe::Probe(System& system, double time)
    : system_(system),
      time_(time),
      none_(VectorXd::Zero(system.velocities())),
      multipliers_(VectorXd::Zero(system.equations())),
      scale_(Eigen::Map<const VectorXd>(system.scales().coordinates.data(), system.velocities())),
      equation_scale_(Eigen::Map<const VectorXd>(system.scales().equations.data(), system.equations())),
      mass_(system.velocities(), system.velocities()),
      jacobian_(system.equations(), system.velocities()) {}

VectorXd Probe::violations(const VectorXd& q) {
  system_.kinematics(time_, q.data(), none_.data(), none_.data());
  return Eigen::Map<const VectorXd>(system_.phi(), equation_scale_.size()).cwiseQuotient(equation_scale_);
}

void Probe::evaluate(const VectorXd& q) {
  VectorXd r(none_.size());
  system_.residual(time_, q.data(), none_.data(), none_.data(), multipliers_.data(), 0, r.data());
  system_.dense_matrix(q.data(), {}, mass_.data());
  jacobian_.setZero();
  for (const JacobianEntry& e : system_.jacobian_entries())
    jacobian_(e.equation, e.coordinate) += e.value / equation_scale_[e.equation];
}

VectorXd Probe::moved(const VectorXd& q, const VectorXd& x) {
  VectorXd out(q.size());
  system_.retract(q.data(), x.data(), out.data());
  return out;
}

}  // namespace mimbre::global_modes
