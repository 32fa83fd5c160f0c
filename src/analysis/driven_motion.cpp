#include "analysis/driven_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/once/decompositions.h"

namespace mimbre {
namespace {

constexpr double closed_loops = 1e-12,
                 nearly_closed_loops = 1e-9;  ///< of violations by the scales of the equations
constexpr double dependent_equations =
    1e-9;  ///< of what an equation adds to others, as a share of the largest
/// The same where a position is singular but for round-off and errors of extrapolation.
constexpr double nearly_dependent_equations = 1e-3;
constexpr double longest_change = 0.5;
constexpr int most_closing_rounds = 40, arriving_rounds = 3;

}  // namespace

DrivenMotion::DrivenMotion(relative::RelativeSystem& system, std::vector<char> leads)
    : system_(system), leads_(std::move(leads)), dependent_(dependent_equations) {
  const Compiled& m = system.model();
  scale_ = Eigen::Map<const Eigen::VectorXd>(system.scales().coordinates.data(), system.velocities());
  rigid_ = scale_;
  for (const BodyData& b : m.bodies) rigid_.segment(b.v + b.joint_velocities, b.modes).setZero();
}

Eigen::MatrixXd DrivenMotion::whole_jacobian(const State& s) {
  const int n = system_.velocities(), m = system_.equations();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n), none = Eigen::VectorXd::Zero(m);
  Eigen::VectorXd r(n);
  system_.residual(s.time, s.q.data(), rest.data(), rest.data(), none.data(), 0, r.data());
  system_.assemble(s.q.data(), {});
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(m, n);
  const Scales& scales = system_.scales();
  for (const JacobianEntry& e : system_.jacobian_entries())
    jacobian(e.equation, e.coordinate) += e.value *
                                          scales.coordinates[static_cast<std::size_t>(e.coordinate)] /
                                          scales.equations[static_cast<std::size_t>(e.equation)];
  return jacobian;
}

Eigen::MatrixXd DrivenMotion::jacobian(const State& s) {
  Eigen::MatrixXd jacobian = whole_jacobian(s);
  for (int k = 0; k < system_.equations(); ++k)
    if (!leads(k)) jacobian.row(k).setZero();
  return jacobian;
}

double DrivenMotion::leading(const double* phi) const {
  double most = 0;
  for (int k = 0; k < system_.equations(); ++k)
    if (leads(k)) {
      const double share = std::abs(phi[k]) / system_.scales().equations[static_cast<std::size_t>(k)];
      if (!(share <= most)) most = share;  // NaN stays
    }
  return most;
}

Eigen::MatrixXd DrivenMotion::moving(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& weight) const {
  return jacobian * weight.cwiseQuotient(scale_).asDiagonal();
}

/// The least x with Φz x = −violation.
Eigen::VectorXd DrivenMotion::follow(const Eigen::MatrixXd& jacobian, const double* violation) const {
  const int m = system_.equations();
  Eigen::VectorXd right = Eigen::VectorXd::Zero(m);
  for (int k = 0; k < m; ++k)
    if (leads(k)) right[k] = -violation[k] / system_.scales().equations[static_cast<std::size_t>(k)];
  if (jacobian.size() == 0 || !jacobian.allFinite() || jacobian.cwiseAbs().maxCoeff() < 1e-13)
    return Eigen::VectorXd::Zero(system_.velocities());
  const auto solution = [&](const Eigen::VectorXd& weight) {
    return Eigen::VectorXd(
        weight.cwiseProduct(Eigen::VectorXd(shortest_solution(moving(jacobian, weight), right, dependent_))));
  };
  return solution(flexes_ ? scale_ : rigid_);
}

bool DrivenMotion::close(State& s) {
  const int n = system_.velocities();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n), start = s.q;
  system_.begin_step(s.q.data());
  const auto positions = [&] {
    change_ = 0;
    double before = 0;
    for (int round = 0; round < most_closing_rounds; ++round) {
      system_.kinematics(s.time, s.q.data(), zero.data(), zero.data());
      const Eigen::VectorXd phi = Eigen::Map<const Eigen::VectorXd>(system_.phi(), system_.equations());
      violation_ = leading(phi.data());
      if (violation_ == 0 || (violation_ <= closed_loops && round > 0 && violation_ > 0.1 * before)) break;
      if (!std::isfinite(violation_)) return;
      before = violation_;
      Eigen::VectorXd x = follow(jacobian(s), phi.data());
      const double length = system_.scales().of_coordinates(x.data());
      if (!(length > 1e-15)) break;
      if (length > longest_change) x *= longest_change / length;
      change_ += std::min(length, longest_change);
      system_.retract(s.q.data(), x.data(), s.q.data());
    }
  };
  positions();
  if (!(violation_ <= nearly_closed_loops) && !flexes_ && (scale_ - rigid_).cwiseAbs().maxCoeff() > 0) {
    flexes_ = true;
    s.q = start;
    positions();
  }
  if (!(violation_ <= nearly_closed_loops)) return false;
  s.v.setZero(n);
  s.a.setZero(n);
  follow_rates(s);
  return true;
}

bool DrivenMotion::arrive(State& s) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(system_.velocities());
  system_.begin_step(s.q.data());
  dependent_ = nearly_dependent_equations;
  for (int round = 0; round < arriving_rounds; ++round) {
    system_.kinematics(s.time, s.q.data(), zero.data(), zero.data());
    const Eigen::VectorXd phi = Eigen::Map<const Eigen::VectorXd>(system_.phi(), system_.equations());
    violation_ = leading(phi.data());
    if (!std::isfinite(violation_)) break;
    const Eigen::VectorXd x = follow(jacobian(s), phi.data());
    system_.retract(s.q.data(), x.data(), s.q.data());
  }
  follow_rates(s);
  dependent_ = dependent_equations;
  return violation_ <= nearly_closed_loops;
}

/// Velocities and accelerations of the equations, by the least change of those that are there.
void DrivenMotion::follow_rates(State& s) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(system_.velocities());
  const Eigen::MatrixXd jacobian = this->jacobian(s);
  for (int round = 0; round < 2; ++round) {
    system_.kinematics(s.time, s.q.data(), s.v.data(), zero.data());
    s.v += follow(jacobian, system_.phi_dot());
  }
  for (int round = 0; round < 2; ++round) {
    system_.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
    s.a += follow(jacobian, system_.phi_ddot());
  }
  s.algorithmic = s.a;
}

}  // namespace mimbre
