#include "integrate/statics.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "integrate/initial.h"
#include "math/once/decompositions.h"

namespace mimbre {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Shares of the scales of coordinates, equations, and of the work that the forces at play do along those.
constexpr double difference = 1e-6;        ///< of coordinates, for the tangent
constexpr double wide_difference = 1e-4;   ///< of coordinates, along a disturbance that grows
constexpr double furthest_step = 0.3;      ///< that the tangent is trusted with
constexpr double still = 1e-10;            ///< of the last step and of violations
constexpr double nearly_there = 1e-6;      ///< of all the way: the last step
constexpr double balanced_share = 1e-8;    ///< of forces that balance but for this
constexpr double round_off_share = 1e-15;  ///< of the forces that a coordinate's scale causes, at once
constexpr double negligible = 1e-9;        ///< of equations: what moves them by less moves nothing
constexpr double light = 1e-9;             ///< of the largest inertia: what is lighter moves as readily
constexpr int most_newton_steps = 12;      ///< with tangents of their own
/// A tangent serves for steps as long as they shrink by this, and decides on stability so near.
constexpr double converging = 0.1, same_place = 1e-8;

/// τ in the mechanism's own times: at first, at least, at most, and from which on its steps are Newton's.
constexpr double first_time = 0.2, least_time = 4e-3, longest_time = 400, newton_time = 4;
/// τ of steps that are Newton's from the start: longer ones lead further along what nothing holds.
constexpr double near_time = 60;

/// A disturbance that grows by e in no less than 3000 of the mechanism's own times is neutral.
constexpr double neutral = 1e-7;

/// The mechanism in units in which its coordinates and equations are near one: q in its own scales, forces as
/// work along them.
struct Units {
  VectorXd coordinates;
  double energy = 0;  ///< J, of the forces at play
  double pace = 0;    ///< 1/s: how fast they would move it through its scale
};

Units units_of(const System& system, const MatrixXd& mass, const VectorXd& work) {
  const Scales& scales = system.scales();
  Units units;
  units.coordinates = Eigen::Map<const VectorXd>(scales.coordinates.data(), system.velocities());
  const double inertia = mass.rows() > 0 ? mass.diagonal().cwiseAbs().maxCoeff() : 0,
               largest = work.size() > 0 ? work.cwiseAbs().maxCoeff() : 0;
  const double weight = inertia * scales.acceleration;
  units.energy = weight > 0 ? weight : largest;
  units.pace = inertia > 0 && units.energy > 0 ? std::sqrt(units.energy / inertia) : 1;
  return units;
}

/// Growth of disturbances of an equilibrium with the tangent stiffness K along the motions N, all in the
/// mechanism's units. `wide`: xᵀ K x by wider differences.
template <class Wide>
void judge_stability(const MatrixXd& K, const MatrixXd& mass, const MatrixXd& N, const Units& units,
                     const Wide& wide, StaticsStatus& status) {
  if (N.cols() == 0) return;
  const MatrixXd stiffness = N.transpose() * K * N;
  MatrixXd inertia = N.transpose() * mass * N;
  const double largest = inertia.diagonal().cwiseAbs().maxCoeff();
  inertia.diagonal().array() += 1e-12 * largest;
  const MatrixXd symmetric = (stiffness + stiffness.transpose()) / 2;
  const double slow = neutral * units.pace * units.pace;
  // Nearly always, and much faster than the eigenvalues.
  if (is_positive_definite(symmetric + slow * inertia)) return;
  const EigenPairs pairs = symmetric_eigen(symmetric, inertia);
  if (!pairs.ok || pairs.values.size() == 0) return;
  // Differences of forces are not sharper than this, and what grows that slowly is neutral.
  const VectorXd x = N * pairs.vectors.col(0);
  const double sharp =
      1e-7 * x.cwiseAbs().dot(K.cwiseAbs() * x.cwiseAbs()) + 1e-9 * units.energy * x.squaredNorm();
  const double stiffness_along = x.dot(K * x);
  if (-stiffness_along <= sharp || pairs.values[0] >= -slow) return;
  // Round-off is less where differences are wider: that of stiff parts, along motions that nothing resists.
  if (wide(x) > 0.5 * stiffness_along) return;
  double least = pairs.values[0];
  // What acts one way only, a signal's feedforward or sliding friction, makes K unsymmetric: then its own
  // eigenvalues decide, of which a negative one is a disturbance that grows without turning back.
  if ((stiffness - stiffness.transpose()).norm() > 1e-6 * stiffness.norm()) {
    const Eigen::VectorXcd values = eigenvalues(solve(inertia, stiffness));
    const double round_off = 1e-9 * values.cwiseAbs().maxCoeff();
    least = 0;
    for (const std::complex<double>& value : values)
      if (std::abs(value.imag()) <= round_off) least = std::min(least, value.real());
    if (least >= -std::max(slow, round_off)) return;
  }
  status.growth = std::sqrt(-least);
  x.cwiseAbs().maxCoeff(&status.growing);
}

/// Whether a search ends with a step of this length by the mechanism's scales, after one of length `previous`
/// and all the `way`. All of these are small where coordinates are amplitudes of small bodies: so a step is
/// also judged by the way, and what no longer shrinks is round-off.
bool rests_after(double step, double previous, double way) {
  return step < still &&
         (step == 0 || (way > 0 && (step <= nearly_there * way || step > converging * previous)));
}

/// Implicit steps of time τ without velocities. All vectors and matrices are along the scales of the
/// coordinates.
class EquilibriumSearch {
 public:
  EquilibriumSearch(System& system, State& s);
  /// Steps of a long time, which are Newton's but for directions without stiffness, as long as the matrix is
  /// positive definite and all steps together are no longer than the tangent is trusted with: the equilibrium
  /// is then the one nearby.
  StaticsStatus newton(int most_steps);
  /// Steps that are longer as forces decrease.
  /// `careful`: shorter steps after one that was too long; for friction that slides, which leaves directions
  /// without stiffness.
  StaticsStatus run(bool careful, int most_steps);

 private:
  static constexpr int closing_rounds = 30;
  static constexpr double most_growth = 10, most_shrinking = 0.5;  ///< of τ from step to step

  /// The work that is not balanced by accelerations a, at q.
  VectorXd forces(const VectorXd& q, const VectorXd& a);
  MatrixXd mass_matrix(const VectorXd& without);
  MatrixXd tangent();
  /// xᵀ K x by wide differences.
  double stiffness_along(const VectorXd& x);
  /// N of the motions x = N z that the constraints permit: Φz N = 0.
  MatrixXd permitted_motions();
  /// Mass, units and the like at the start.
  void begin();
  /// Onto the constraints, and the forces that are left there with the multipliers that balance them best:
  /// both are determined, even where equations are redundant.
  struct Balance {
    VectorXd forces;
    double largest = 0, violation = 0;
  };
  Balance look(StaticsStatus& status);
  /// Whether what is left is within what does no work, or within the round-off of the tangent K.
  bool balances(const Balance& left, double round_off) const {
    return left.largest <= std::max(balanced_share * units_.energy, round_off);
  }
  bool closes(const Balance& left) const { return left.violation < std::max(still, 10 * scales_.round_off); }
  double round_off_of(const MatrixXd& K) const {
    return n_ == 0 ? 0 : round_off_share * K.cwiseAbs().maxCoeff();
  }
  /// The equations at some place, and steps by them from there on.
  struct Linear {
    MatrixXd K, N, along, inverse;
    double way = 0;  ///< of all steps since then
    int steps = 0;

    bool solvable() const;
    VectorXd step(const VectorXd& forces);
  };
  Linear linear(double tau);
  void move(const VectorXd& step);
  void judge(const MatrixXd& K, const MatrixXd& N, StaticsStatus& status) {
    judge_stability(
        K, mass_, N, units_, [this](const VectorXd& x) { return stiffness_along(x); }, status);
  }

  System& system_;
  State& s_;
  const Scales& scales_;
  const int n_, m_;
  const VectorXd zero_, scale_;
  MatrixXd mass_;
  Units units_;
  VectorXd readiness_;  ///< of coordinates to move back onto the constraints: heavy ones move least
};

EquilibriumSearch::EquilibriumSearch(System& system, State& s)
    : system_(system),
      s_(s),
      scales_(system.scales()),
      n_(system.velocities()),
      m_(system.equations()),
      zero_(VectorXd::Zero(n_)),
      scale_(Eigen::Map<const VectorXd>(scales_.coordinates.data(), n_)) {
  s.v.setZero(n_);
  s.a.setZero(n_);
  s.algorithmic.setZero(n_);
  if (s.multipliers.size() != m_) s.multipliers.setZero(m_);
  begin();
}

VectorXd EquilibriumSearch::forces(const VectorXd& q, const VectorXd& a) {
  VectorXd r(n_);
  system_.residual(s_.time, q.data(), zero_.data(), a.data(), s_.multipliers.data(), 0, r.data());
  return scale_.cwiseProduct(r);
}

/// `without`: the forces without accelerations, which were the last ones.
MatrixXd EquilibriumSearch::mass_matrix(const VectorXd& without) {
  MatrixXd mass(n_, n_);
  // The assembled matrix has neither loads by accelerations nor what bends by elastodynamics.
  if (!system_.has_loads_of_inertia() && system_.driven_coordinates().empty()) {
    system_.dense_matrix(s_.q.data(), {}, mass.data());
    return scale_.asDiagonal() * mass * scale_.asDiagonal();
  }
  VectorXd unit = zero_;
  for (int k = 0; k < n_; ++k) {
    unit[k] = scale_[k];
    mass.col(k) = forces(s_.q, unit) - without;
    unit[k] = 0;
  }
  return mass;
}

MatrixXd EquilibriumSearch::tangent() {
  MatrixXd result(n_, n_);
  VectorXd q(system_.positions()), unit = zero_;
  for (int k = 0; k < n_; ++k) {
    unit[k] = difference * scale_[k];
    system_.retract(s_.q.data(), unit.data(), q.data());
    const VectorXd plus = forces(q, zero_);
    unit[k] *= -1;
    system_.retract(s_.q.data(), unit.data(), q.data());
    result.col(k) = (plus - forces(q, zero_)) / (2 * difference);
    unit[k] = 0;
  }
  return result;
}

double EquilibriumSearch::stiffness_along(const VectorXd& x) {
  const double largest = x.cwiseAbs().maxCoeff();
  if (!(largest > 0)) return 0;
  const double share = wide_difference / largest;
  VectorXd q(system_.positions()), step = share * x.cwiseProduct(scale_);
  system_.retract(s_.q.data(), step.data(), q.data());
  const VectorXd plus = forces(q, zero_);
  step *= -1;
  system_.retract(s_.q.data(), step.data(), q.data());
  return x.dot(plus - forces(q, zero_)) / (2 * share);
}

MatrixXd EquilibriumSearch::permitted_motions() {
  if (m_ > 0) {
    const VectorXd rows = Eigen::Map<const VectorXd>(scales_.equations.data(), m_).cwiseInverse();
    const MatrixXd jacobian =
        rows.asDiagonal() * dense_jacobian(system_, s_.time, s_.q) * scale_.asDiagonal();
    if (n_ > 0 && jacobian.cwiseAbs().maxCoeff() > negligible) return null_space(jacobian, 1e-9);
  }
  return MatrixXd::Identity(n_, n_);
}

void EquilibriumSearch::begin() {
  system_.enter_rest(s_.u.data(), s_.z.data());
  system_.begin_step(s_.q.data());
  const VectorXd r = forces(s_.q, zero_);
  mass_ = mass_matrix(r);
  units_ = units_of(system_, mass_, r);
  const double heaviest = n_ > 0 ? mass_.diagonal().maxCoeff() : 0;
  VectorXd lightness = VectorXd::Ones(n_);
  if (heaviest > 0) lightness = (mass_.diagonal() / heaviest).cwiseMax(light).cwiseSqrt().cwiseInverse();
  readiness_ = lightness.cwiseProduct(scale_);
}

EquilibriumSearch::Balance EquilibriumSearch::look(StaticsStatus& status) {
  if (m_ > 0) {
    close_positions(system_, s_.time, readiness_, s_.q, closing_rounds, negligible);
    find_multipliers(system_, s_, negligible);
  }
  Balance out;
  out.forces = forces(s_.q, zero_);
  system_.keep_turns(s_.z.data());
  if (m_ > 0) {
    out.violation = scales_.of_equations(system_.phi());
    scales_.of_kinds(system_.phi(), status.position_violation, status.angle_violation);
  }
  if (n_ > 0) {
    out.largest = out.forces.cwiseAbs().maxCoeff(&status.coordinate);
    status.residual = out.largest / scale_[status.coordinate];
  }
  return out;
}

void EquilibriumSearch::move(const VectorXd& step) {
  const VectorXd x = step.cwiseProduct(scale_);
  system_.retract(s_.q.data(), x.data(), s_.q.data());
}

bool EquilibriumSearch::Linear::solvable() const {
  return N.cols() == 0 || is_positive_definite((along + along.transpose()) / 2);
}

VectorXd EquilibriumSearch::Linear::step(const VectorXd& forces) {
  if (N.cols() == 0) return VectorXd::Zero(forces.size());
  const VectorXd right = N.transpose() * forces;
  if (steps++ == 0) return -N * solve(along, right);
  if (inverse.size() == 0) inverse = mimbre::inverse(along);
  return -N * (inverse * right);
}

EquilibriumSearch::Linear EquilibriumSearch::linear(double tau) {
  Linear out;
  out.K = tangent();
  out.N = permitted_motions();
  out.along = out.N.transpose() * (out.K + mass_ / (tau * tau)) * out.N;
  return out;
}

StaticsStatus EquilibriumSearch::newton(int most_steps) {
  StaticsStatus status;
  const double tau = near_time / units_.pace;
  double way = 0, previous = 0;
  Linear tangent;
  int tangents = 0;
  const auto anew = [&] {
    tangent = linear(tau);
    return ++tangents <= most_newton_steps && tangent.solvable();
  };
  for (; status.iterations < most_steps; ++status.iterations) {
    const Balance left = look(status);
    if (!left.forces.allFinite()) return status;
    if (tangents == 0 && !anew()) return status;
    VectorXd step = tangent.step(left.forces);
    const auto longest = [&] { return n_ == 0 ? 0 : step.cwiseAbs().maxCoeff(); };
    const auto ends = [&] {
      return balances(left, round_off_of(tangent.K)) && rests_after(longest(), previous, way) && closes(left);
    };
    // Another tangent where this one leads no nearer, or is not the one of the place that was found: there a
    // step of its own is as exact as Newton's.
    bool renewed = false;
    if (tangent.way > 0 && (ends() ? tangent.way > same_place : longest() > converging * previous)) {
      if (!anew()) return status;
      step = tangent.step(left.forces);
      renewed = true;
    }
    if (!renewed && ends()) {
      status.converged = true;
      judge(tangent.K, tangent.N, status);
      return status;
    }
    way += longest();
    if (!(way <= furthest_step)) return status;
    previous = longest();
    tangent.way += previous;
    move(step);
  }
  return status;
}

StaticsStatus EquilibriumSearch::run(bool careful, int most_steps) {
  StaticsStatus status;
  double round_off = 0;  // of elastic forces
  double tau = first_time / units_.pace, previous = forces(s_.q, zero_).norm();
  const double least = least_time / units_.pace, most = longest_time / units_.pace;
  bool too_far = false;
  double way = 0, last = 0;
  for (status.iterations = 0; status.iterations < most_steps; ++status.iterations) {
    const Balance left = look(status);
    const double norm = left.forces.norm();
    if (!std::isfinite(norm)) return status;
    const bool balanced = balances(left, round_off);
    if (careful && too_far)
      tau = std::max(furthest_step * tau, least);
    else if (status.iterations > 0)
      tau =
          std::clamp(tau * (balanced || norm == 0 ? most_growth
                                                  : std::clamp(previous / norm, most_shrinking, most_growth)),
                     least, most);
    previous = norm;

    const MatrixXd K = tangent(), N = permitted_motions();
    round_off = round_off_of(K);
    VectorXd step = zero_;
    if (N.cols() > 0)
      step = -N * solve(N.transpose() * (K + mass_ / (tau * tau)) * N, N.transpose() * left.forces);
    if (!step.allFinite()) return status;
    const double largest = n_ == 0 ? 0 : step.cwiseAbs().maxCoeff();
    if (tau * units_.pace >= newton_time && balanced && rests_after(largest, last, way) && closes(left)) {
      status.converged = true;
      judge(K, N, status);
      break;
    }
    too_far = largest > furthest_step;
    if (too_far) step *= furthest_step / largest;
    last = std::min(largest, furthest_step);
    way += last;
    move(step);
  }
  return status;
}

}  // namespace

StaticsStatus find_equilibrium(System& system, State& s, int most_steps) {
  EquilibriumSearch search(system, s);
  const State start = s;
  const StaticsStatus near = search.newton(most_steps);
  if (near.converged) return near;
  s = start;
  StaticsStatus status = search.run(false, most_steps);
  status.iterations += near.iterations;
  if (status.converged) return status;
  const State there = s;
  s = start;
  StaticsStatus next = EquilibriumSearch(system, s).run(true, most_steps);
  if (!next.converged) {
    s = there;
    return status;
  }
  next.iterations += status.iterations;
  return next;
}

}  // namespace mimbre
