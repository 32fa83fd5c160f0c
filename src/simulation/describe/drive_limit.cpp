#include "simulation/describe/drive_limit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/relative/system.h"
#include "integrate/initial.h"
#include "math/once/decompositions.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Violations count from this size on, by the scales of the equations.
constexpr double open_loop = 1e-9;
/// At a limit so much is left of the violation with which the drives begin.
constexpr double left_at_limit = 1e-3;
/// The violation is at its least where its gradient is this share of it.
constexpr double at_least = 1e-5;
/// A drive takes part in a limit with this share of the largest violation.
constexpr double takes_part = 1e-3;
constexpr int most_limit_rounds = 300;
/// Larger mechanisms are not looked at: the Jacobian is dense here.
constexpr std::ptrdiff_t most_limit_entries = 250000;

/// Φ with the signals of t, by the scales of the equations; equations of velocities alone do not count.
VectorXd scaled_violation(System& system, double t, const VectorXd& q) {
  const VectorXd zero = VectorXd::Zero(system.velocities());
  system.kinematics(t, q.data(), zero.data(), zero.data());
  const Scales& scales = system.scales();
  VectorXd phi(system.equations());
  for (Eigen::Index k = 0; k < phi.size(); ++k) {
    const std::size_t at = static_cast<std::size_t>(k);
    const bool rate = !scales.is_rate.empty() && scales.is_rate[at];
    phi[k] = rate ? 0 : system.phi()[k] / scales.equations[at];
  }
  return phi;
}

MatrixXd jacobian_by_scales(System& system, double t, const VectorXd& q) {
  const Scales& scales = system.scales();
  MatrixXd jacobian = dense_jacobian(system, t, q);
  for (Eigen::Index r = 0; r < jacobian.rows(); ++r) {
    const std::size_t at = static_cast<std::size_t>(r);
    const bool rate = !scales.is_rate.empty() && scales.is_rate[at];
    jacobian.row(r) *= rate ? 0 : 1 / scales.equations[at];
  }
  for (Eigen::Index c = 0; c < jacobian.cols(); ++c)
    jacobian.col(c) *= scales.coordinates[static_cast<std::size_t>(c)];
  return jacobian;
}

/// The least violation near q, by Levenberg's and Marquardt's method; empty: it does not settle.
VectorXd least_violation(System& system, double t, VectorXd q) {
  const Eigen::Map<const VectorXd> scale(system.scales().coordinates.data(), system.velocities());
  VectorXd phi = scaled_violation(system, t, q);
  double damping = 1e-3;
  for (int round = 0; round < most_limit_rounds; ++round) {
    const MatrixXd jacobian = jacobian_by_scales(system, t, q);
    const Eigen::Index m = jacobian.rows(), n = jacobian.cols();
    if (phi.norm() <= open_loop || (jacobian.transpose() * phi).norm() <= at_least * phi.norm()) return phi;
    MatrixXd extended(m + n, n);
    extended << jacobian, std::sqrt(damping) * MatrixXd::Identity(n, n);
    VectorXd right(m + n);
    right << -phi, VectorXd::Zero(n);
    const VectorXd x = scale.cwiseProduct(VectorXd(least_squares(extended, right)));
    VectorXd moved = q;
    system.retract(q.data(), x.data(), moved.data());
    const VectorXd next = scaled_violation(system, t, moved);
    if (!next.allFinite()) return {};
    const bool better = next.norm() < phi.norm();
    damping *= better ? 0.3 : 4;
    if (!better) continue;
    q = moved;
    phi = next;
  }
  return {};
}

}  // namespace

std::string explain_drive_limit(const Compiled& m, const Method& method, const State& state, double t) {
  if (m.drives.empty() || std::ptrdiff_t{m.velocities} * m.equations > most_limit_entries) return {};
  relative::RelativeSystem system(m, method.inertia);
  system.enter(state.u.data(), state.z.data(), 0);
  system.begin_step(state.q.data());
  const double before = scaled_violation(system, t, state.q).norm();
  if (!(before > open_loop)) return {};
  const VectorXd phi = least_violation(system, t, state.q);
  if (phi.size() == 0 || !(phi.norm() > open_loop) || !(phi.norm() > left_at_limit * before)) return {};
  const double share = takes_part * phi.cwiseAbs().maxCoeff();
  std::vector<std::string> names;
  for (const DriveData& d : m.drives)
    if (std::abs(phi[d.equation]) > share)
      names.push_back(fmt::format("'{}'", m.spec().joints[static_cast<std::size_t>(d.joint_spec)].name));
  if (names.empty()) return {};
  return fmt::format(
      "the drive{} of joint{} {} cannot be followed there, because loops and constraints do not close; "
      "`mimbre kinematics` finds how far the drives go",
      names.size() > 1 ? "s" : "", names.size() > 1 ? "s" : "", fmt::join(names, ", "));
}

}  // namespace mimbre
