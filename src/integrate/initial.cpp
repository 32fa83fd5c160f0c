#include "integrate/initial.h"
#include "integrate/sparse_statics.h"
#include "linalg/once/sparse_qr.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace mimbre {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd copy(const double* x, int n) { return Map<const VectorXd>(x, n); }

/// What an equation adds to others, as a share of the largest, when it is redundant.
constexpr double same = 1e-9;

/// Up to this many entries dense decompositions are fast enough, and the sharper judges of what is redundant.
constexpr std::ptrdiff_t dense_entries = 40000;

/// Smallest x, scaled by the weights, with J x = b in the sense of least squares; `damping` > 0 gives up a
/// part of directions that J hardly sees (Levenberg, Marquardt): those with J² < damping, J times the weights
/// without a unit.
VectorXd least_change(const MatrixXd& jacobian, const VectorXd& weight, const VectorXd& b, double damping = 0,
                      double negligible = 1e-13) {
  const MatrixXd scaled = jacobian * weight.asDiagonal();
  // Round-off where nothing can change: the threshold below is relative.
  if (scaled.size() == 0 || scaled.cwiseAbs().maxCoeff() < negligible) return VectorXd::Zero(scaled.cols());
  if (damping > 0) {
    const Eigen::Index m = scaled.rows(), n = scaled.cols();
    MatrixXd extended(m + n, n);
    extended << scaled, std::sqrt(damping) * MatrixXd::Identity(n, n);
    VectorXd right(m + n);
    right << b, VectorXd::Zero(n);
    return weight.asDiagonal() * least_squares(extended, right);
  }
  return weight.asDiagonal() * shortest_solution(scaled, b, same);
}

/// The same without damping for large systems, with J at q and its rows times `rows`: equations that depend
/// on others are left out.
VectorXd sparse_least_change(System& system, double t, const VectorXd& q, const VectorXd& rows,
                             const VectorXd& weight, const VectorXd& b, double negligible) {
  const int n = system.velocities(), m = system.equations();
  const VectorXd zero = VectorXd::Zero(n), none = VectorXd::Zero(m);
  VectorXd r(n);
  system.residual(t, q.data(), zero.data(), zero.data(), none.data(), 0, r.data());
  system.factor(q.data(), {});
  std::vector<Eigen::Triplet<double>> entries;
  for (const JacobianEntry& e : system.jacobian_entries())
    if (const double value = rows[e.equation] * e.value * weight[e.coordinate]; value != 0)
      entries.emplace_back(e.coordinate, e.equation, value);
  linalg::SparseMatrix transposed(n, m);
  transposed.setFromTriplets(entries.begin(), entries.end());
  double longest = 0;
  for (int k = 0; k < m; ++k) longest = std::max(longest, transposed.col(k).norm());
  if (longest < negligible) return zero;
  return weight.cwiseProduct(linalg::SparseQr(transposed, same * longest).shortest(b));
}

Map<const VectorXd> coordinate_scales(const System& system) {
  return {system.scales().coordinates.data(), system.velocities()};
}

VectorXd inverse_equation_scales(const System& system) {
  return Map<const VectorXd>(system.scales().equations.data(), system.equations()).cwiseInverse();
}

/// The same where equations of velocities alone do not count.
VectorXd inverse_position_scales(const System& system) {
  VectorXd rows = inverse_equation_scales(system);
  const std::vector<char>& is_rate = system.scales().is_rate;
  for (std::size_t k = 0; k < is_rate.size(); ++k)
    if (is_rate[k]) rows[static_cast<Eigen::Index>(k)] = 0;
  return rows;
}

/// Least change of the coordinates that makes up for `b`, where equations count by `rows`.
VectorXd change_of(System& system, double t, const VectorXd& q, const VectorXd& rows, const VectorXd& weight,
                   const VectorXd& b, double damping = 0, double negligible = 1e-13) {
  const VectorXd right = rows.cwiseProduct(b);
  const std::ptrdiff_t entries = static_cast<std::ptrdiff_t>(system.velocities()) * system.equations();
  if (damping == 0 && entries > dense_entries)
    return sparse_least_change(system, t, q, rows, weight, right, negligible);
  return least_change(rows.asDiagonal() * dense_jacobian(system, t, q), weight, right, damping, negligible);
}

/// Of violations by the scales of equations: known to round-off, and nearly closed; of changes by the scales
/// of coordinates: none any more, and as far as a linear step is trusted.
constexpr double exactly_closed = 1e-13, nearly_closed = 1e-8, no_change = 1e-15, furthest_change = 0.5;
/// Of the accelerations at play: what a round may still change of them; beyond the second the matrix is not
/// that of the motion.
constexpr double settled_start = 1e-10, unsettled = 1e-6;
/// Pivots that are no more than this of the entry that they come from are round-off.
constexpr double pivot_round_off = 1e3 * std::numeric_limits<double>::epsilon();
/// Times the scales of the penalties.
constexpr double start_penalty = 1e6;

/// The coordinate that the matrix with these weights does not determine beyond round-off; -1: there is none.
int undetermined_coordinate(System& system, const State& s, const MatrixWeights& weights) {
  const int n = system.velocities();
  if (n == 0) return -1;
  MatrixXd matrix(n, n);
  system.dense_matrix(s.q.data(), weights, matrix.data());
  VectorXd work(n);
  for (int k = 0; k < n; ++k) {
    if (!(matrix(k, k) > 0)) return k;
    work[k] = 1 / std::sqrt(matrix(k, k));
  }
  matrix = (work.asDiagonal() * matrix * work.asDiagonal()).eval();
  return PivotedCholesky(matrix).singular_at(matrix, pivot_round_off, work);
}

/// Corrects accelerations by the factorised matrix, over and over where that is the mass matrix; otherwise
/// the first round's forces alone count. Returns the last correction, by the accelerations at play.
double iterate_accelerations(System& system, State& s, bool by_mass) {
  const int n = system.velocities(), m = system.equations();
  const Scales& scales = system.scales();
  VectorXd r(n), g(m), jd(m);
  s.a.setZero(n);
  s.multipliers.setZero(m);
  double change = 0;
  for (int round = 0; round < 60; ++round) {
    system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
    if (round > 0 && !by_mass) r.setZero();
    for (int k = 0; k < m; ++k) g[k] = start_penalty * system.penalty()[k] * system.phi_ddot()[k];
    system.add_jacobian_transposed(g.data(), 1, r.data());
    r = -r;
    system.solve(r.data());
    s.a += r;
    system.jacobian_times(r.data(), jd.data());
    for (int k = 0; k < m; ++k) s.multipliers[k] += g[k] + start_penalty * system.penalty()[k] * jd[k];
    if (!r.allFinite() || !s.a.allFinite()) return std::numeric_limits<double>::infinity();
    // What turns without gravity has accelerations of the order of its squared velocities.
    const double correction = scales.of_coordinates(r.data()), rate = scales.of_coordinates(s.v.data());
    const double play = std::max(scales.accelerations(s.a.data()), rate * rate);
    change = correction == 0 ? 0 : play > 0 ? correction / play : 1;
    if (change <= settled_start) break;
  }
  s.algorithmic = s.a;
  return change;
}

}  // namespace

MatrixXd dense_jacobian(System& system, double t, const VectorXd& q) {
  const int n = system.velocities(), m = system.equations();
  const VectorXd zero = VectorXd::Zero(n), none = VectorXd::Zero(m);
  VectorXd r(n);
  system.residual(t, q.data(), zero.data(), zero.data(), none.data(), 0, r.data());
  system.factor(q.data(), {});
  MatrixXd jacobian(m, n);
  VectorXd unit = zero;
  for (int k = 0; k < n; ++k) {
    unit[k] = 1;
    system.jacobian_times(unit.data(), jacobian.col(k).data());
    unit[k] = 0;
  }
  return jacobian;
}

double close_positions(System& system, double t, const VectorXd& weight, VectorXd& q, double caution,
                       double negligible, const std::function<void()>& arrived) {
  const int n = system.velocities(), m = system.equations();
  if (m == 0) return 0;
  const VectorXd zero = VectorXd::Zero(n);
  double violation = 0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    system.kinematics(t, q.data(), zero.data(), zero.data());
    if (arrived) arrived();
    const VectorXd phi = copy(system.phi(), m);
    violation = system.scales().of_equations(phi.data());
    if (!(violation > exactly_closed)) break;
    const double damping = violation > nearly_closed ? caution * violation : 0;
    VectorXd x = change_of(system, t, q, inverse_position_scales(system), weight, -phi, damping, negligible);
    const double length = x.cwiseQuotient(coordinate_scales(system)).norm();
    if (!(length > no_change)) break;
    if (length > furthest_change) x *= furthest_change / length;
    system.retract(q.data(), x.data(), q.data());
  }
  return violation;
}

double close_velocities(System& system, double t, const VectorXd& q, const VectorXd& weight, VectorXd& v) {
  const int n = system.velocities(), m = system.equations();
  if (m == 0) return 0;
  const VectorXd zero = VectorXd::Zero(n);
  double violation = 0;
  for (int round = 0; round < 3; ++round) {
    system.kinematics(t, q.data(), v.data(), zero.data());
    const VectorXd phi_dot = copy(system.phi_dot(), m);
    violation = system.scales().of_equations(phi_dot.data());
    if (violation == 0) break;
    if (round < 2) v += change_of(system, t, q, inverse_equation_scales(system), weight, -phi_dot);
  }
  return violation;
}

void find_multipliers(System& system, State& s, double negligible) {
  const int n = system.velocities(), m = system.equations();
  s.multipliers.setZero(m);
  if (m == 0) return;
  if (static_cast<std::ptrdiff_t>(n) * m > 100 * dense_entries) return find_sparse_multipliers(system, s);
  const MatrixXd jacobian = dense_jacobian(system, s.time, s.q);
  VectorXd r(n);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  // By the work of what is not balanced along the scales of the coordinates.
  const auto scale = coordinate_scales(system);
  s.multipliers = least_change(scale.asDiagonal() * jacobian.transpose(), inverse_equation_scales(system),
                               -scale.cwiseProduct(r), 0, negligible);
}

bool solve_accelerations(System& system, State& s, double step, int* undetermined) {
  const int n = system.velocities();
  s.a.setZero(n);
  s.algorithmic.setZero(n);
  s.multipliers.setZero(system.equations());
  const VectorXd zero = s.a, none = s.multipliers;
  VectorXd r(n);
  if (undetermined) *undetermined = -1;
  const auto evaluate = [&] {
    system.residual(s.time, s.q.data(), s.v.data(), zero.data(), none.data(), 0, r.data());
    return r.allFinite();
  };
  if (!evaluate()) return false;
  const MatrixWeights by_mass{0, 0, start_penalty};
  const double change = system.factor(s.q.data(), by_mass).ok() ? iterate_accelerations(system, s, true)
                                                                : std::numeric_limits<double>::infinity();
  if (change <= unsettled) return true;
  evaluate();
  int weakest = undetermined_coordinate(system, s, by_mass);
  // Slow where constraints are nearly dependent, in singular positions.
  if (weakest < 0) return std::isfinite(change);
  if (step > 0) {
    const MatrixWeights by_step{0.5 * step, 0.25 * step * step, start_penalty};
    evaluate();
    weakest = undetermined_coordinate(system, s, by_step);
    evaluate();
    if (weakest < 0 && system.factor(s.q.data(), by_step).ok() &&
        std::isfinite(iterate_accelerations(system, s, false)))
      return true;
  }
  if (undetermined) *undetermined = weakest;
  return false;
}

}  // namespace mimbre
