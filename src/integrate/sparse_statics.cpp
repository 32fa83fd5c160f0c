#include "integrate/sparse_statics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/random_numbers.h"
#include "integrate/sparse_jacobian.h"
#include "linalg/constrained_solver.h"

namespace mimbre {

using Eigen::VectorXd;

namespace {

namespace sparse_search {

using Matrix = linalg::SparseMatrix;

// Shares of the scales of coordinates and equations, and of the work of the forces at play along those.
constexpr double difference = 1e-6, one_sided = 1e-7;  ///< of coordinates, for tangents
constexpr double furthest_turn = 0.4;                  ///< of bodies in one step, rad
constexpr double furthest_newton = 1;                  ///< that Newton's steps are trusted with
constexpr double still = 1e-10;                        ///< of the last step and of violations
constexpr double exactly_closed = 1e-13;               ///< no better is sought
constexpr double nearly_closed = 1e-6;                 ///< of positions between two iterations
constexpr double balanced_share = 1e-8;                ///< of forces that balance but for this
constexpr double round_off_share = 1e-15;    ///< of the forces that a coordinate's scale causes, at once
constexpr double round_off_of_play = 1e-13;  ///< of the forces at play
constexpr double light = 1e-9;               ///< of the largest inertia: what is lighter moves as readily
constexpr double tiny_step = 1e-6;           ///< whose work is round-off

/// τ in the mechanism's own times: at first, at least, at most, and from which on its steps are Newton's.
constexpr double first_time = 0.2, least_time = 1e-5, longest_time = 4000, newton_time = 4;
/// A disturbance that grows by e in no less than 3000 of the mechanism's own times is neutral.
constexpr double neutral = 1e-7;
/// Work at the end of a step, of that at its start: beyond, the step was too long.
constexpr double overshoot = 0.3;

double largest_of(const VectorXd& x) { return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff(); }

/// The system along the scales of its coordinates, with equations of Jacobian rows of length one.
class ScaledSystem {
 public:
  ScaledSystem(System& system, const linalg::ColumnColours& colours, const State& s)
      : system_(system),
        colours_(colours),
        scales_(system.scales()),
        time_(s.time),
        n_(system.velocities()),
        m_(system.equations()),
        zero_(VectorXd::Zero(n_)),
        r_(n_),
        scale_(Eigen::Map<const VectorXd>(scales_.coordinates.data(), n_)),
        rows_(VectorXd::Ones(m_)),
        values_(static_cast<std::size_t>(system.pattern().value_count())) {}

  /// Work that is not balanced by accelerations a (along the scales) and multipliers (of scaled equations).
  VectorXd forces(const VectorXd& q, const VectorXd& a, const VectorXd& multipliers) {
    const VectorXd second = scale_.cwiseProduct(a), mu = rows_.cwiseProduct(multipliers);
    system_.residual(time_, q.data(), zero_.data(), second.data(), mu.data(), 0, r_.data());
    return scale_.cwiseProduct(r_);
  }
  VectorXd forces(const VectorXd& q, const VectorXd& multipliers) { return forces(q, zero_, multipliers); }

  Matrix mass(const VectorXd& q, const VectorXd& multipliers) {
    const VectorXd without = forces(q, multipliers);
    return colours_.assemble(
        [&](const VectorXd& x, VectorXd& y) { y = forces(q, x, multipliers) - without; });
  }

  /// Differences to one side, or central ones.
  Matrix stiffness(const VectorXd& q, const VectorXd& multipliers, bool central) {
    VectorXd moved(q.size());
    const VectorXd here = forces(q, multipliers);
    const double width = central ? difference : one_sided;
    return colours_.assemble([&](const VectorXd& x, VectorXd& y) {
      move(q, width * x, moved);
      y = forces(moved, multipliers);
      if (central) {
        move(q, -width * x, moved);
        y = (y - forces(moved, multipliers)) / (2 * width);
      } else {
        y = (y - here) / width;
      }
    });
  }

  /// Also makes rows of length one what equations count by.
  Matrix jacobian(const VectorXd& q, VectorXd& multipliers) {
    if (m_ == 0) return Matrix(0, n_);
    const VectorXd unscaled = rows_.cwiseProduct(multipliers);
    system_.residual(time_, q.data(), zero_.data(), zero_.data(), unscaled.data(), 0, r_.data());
    system_.matrix_values(q.data(), {}, values_.data());
    SparseJacobian scaled = sparse_jacobian(system_);
    rows_ = scaled.rows;
    for (int k = 0; k < m_; ++k) multipliers[k] = rows_[k] > 0 ? unscaled[k] / rows_[k] : 0;
    return std::move(scaled.J);
  }

  /// Φ at q, scaled, and the largest violation by the scales of the equations.
  VectorXd violation(const VectorXd& q, double& largest) {
    largest = 0;
    if (m_ == 0) return VectorXd::Zero(0);
    system_.kinematics(time_, q.data(), zero_.data(), zero_.data());
    const VectorXd phi = Eigen::Map<const VectorXd>(system_.phi(), m_);
    largest = scales_.of_equations(phi.data());
    return rows_.cwiseProduct(phi);
  }
  void kinds(StaticsStatus& status) const {
    if (m_ > 0) scales_.of_kinds(system_.phi(), status.position_violation, status.angle_violation);
  }

  void move(const VectorXd& q, const VectorXd& x, VectorXd& out) {
    const VectorXd step = scale_.cwiseProduct(x);
    system_.retract(q.data(), step.data(), out.data());
  }

  void keep_turns(double* states) const { system_.keep_turns(states); }
  const VectorXd& scale() const { return scale_; }
  VectorXd unscaled(const VectorXd& multipliers) const { return rows_.cwiseProduct(multipliers); }
  int coordinates() const { return n_; }
  int equations() const { return m_; }
  double acceleration() const { return scales_.acceleration; }
  double round_off() const { return scales_.round_off; }

 private:
  System& system_;
  const linalg::ColumnColours& colours_;
  const Scales& scales_;
  const double time_;
  const int n_, m_;
  const VectorXd zero_;
  VectorXd r_;
  const VectorXd scale_;
  VectorXd rows_;
  std::vector<double> values_;
};

/// τ, the time in which a step is made.
class TrustTime {
 public:
  explicit TrustTime(double pace)
      : pace_(pace), least_(least_time / pace), most_(longest_time / pace), tau_(first_time / pace) {}

  bool is_least() const { return tau_ <= least_; }
  bool is_newton() const { return tau_ * pace_ >= newton_time; }
  double inertia() const { return 1 / (tau_ * tau_); }  ///< the factor of M
  double least_inertia() const { return 1 / (most_ * most_); }
  void divide(double by) { tau_ = std::max(tau_ / by, least_); }
  /// The same after a step that was too long: it then grows slowly.
  void hinder(double by) {
    divide(by);
    hindered_ = true;
  }
  void open() { tau_ = most_; }
  /// After a step whose work was wrong by that share.
  void adapt(double wrong) {
    const double growth = hindered_ ? 1.3 : wrong < 0.05 ? 10 : 3;
    tau_ = std::clamp(tau_ * (wrong < 0.25 ? growth : wrong < 0.6 ? 1 : 0.5), least_, most_);
    hindered_ = false;
  }

 private:
  double pace_, least_, most_, tau_;
  bool hindered_ = false;
};

class SparseSearch {
 public:
  SparseSearch(System& system, const linalg::ColumnColours& colours, State& s)
      : scaled_(system, colours, s), s_(s), multipliers_(VectorXd::Zero(system.equations())) {
    const int n = system.velocities();
    s.v.setZero(n);
    s.a.setZero(n);
    s.algorithmic.setZero(n);
    system.enter_rest(s.u.data(), s.z.data());
    system.begin_step(s.q.data());
    Matrix mass = scaled_.mass(s.q, multipliers_);
    const VectorXd diagonal = mass.diagonal().cwiseAbs();
    const double inertia = largest_of(diagonal);
    const double weight = inertia * scaled_.acceleration(),
                 work = largest_of(scaled_.forces(s.q, multipliers_));
    energy_ = weight > 0 ? weight : work;
    pace_ = inertia > 0 && energy_ > 0 ? std::sqrt(energy_ / inertia) : 1;
    // What has no inertia, or whose inertia goes by other coordinates alone, moves as readily as light parts.
    Matrix some(n, n);
    some.setIdentity();
    const Matrix transposed = mass.transpose();
    mass_ = 0.5 * (mass + transposed) + light * std::max(inertia, 1e-300) * some;
    held_ = VectorXd::Zero(n);
  }

  StaticsStatus run();
  StaticsStatus run_by_loads();
  void judge_stability(StaticsStatus& status, VectorXd* growing);
  void finish() { s_.multipliers = scaled_.unscaled(multipliers_); }

 private:
  static constexpr int most_steps = 400, most_trials = 1000, closing_rounds = 25, most_newtons = 40;

  VectorXd forces(const VectorXd& q, const VectorXd& multipliers) {
    return scaled_.forces(q, multipliers) - held_;
  }
  /// Where the search is.
  struct Point {
    VectorXd r, violation;
    double off = 0;  ///< the largest violation, of the scales of the equations
  };
  struct Step {
    VectorXd x, change;        ///< of coordinates and multipliers
    VectorXd unbalanced;       ///< work that is left with the changed multipliers
    double length = 0;         ///< the largest of x
    bool is_definite = false;  ///< the matrix is, along the motions that the constraints leave
  };
  enum class Taken { yes, no, never };

  bool close(const linalg::ConstrainedSolver& equations, VectorXd& q);
  bool evaluate(Point& at, StaticsStatus& status);
  void factor(TrustTime& time, linalg::ConstrainedSolver& equations, Step& step) const;
  bool solve(linalg::ConstrainedSolver& equations, const Point& at, Step& step) const;
  void take_newtons(const Point& at, TrustTime& time, Step& step) const;
  Taken take(const Step& step, const linalg::ConstrainedSolver& equations, TrustTime& time);
  StaticsStatus search();
  StaticsStatus newton();

  ScaledSystem scaled_;
  State& s_;
  VectorXd multipliers_;  ///< of scaled equations
  VectorXd held_;         ///< forces that are not applied yet
  Matrix mass_, K_, J_;
  double energy_ = 0;  ///< J, of the forces at play
  double pace_ = 1;    ///< 1/s: how fast they would move the mechanism through its scale
};

/// Onto the constraints, by the matrix of the last step.
bool SparseSearch::close(const linalg::ConstrainedSolver& equations, VectorXd& q) {
  double before = 0;
  for (int round = 0; round < closing_rounds; ++round) {
    double off = 0;
    const VectorXd violation = scaled_.violation(q, off);
    if (!std::isfinite(off)) return false;
    if (off <= std::max(exactly_closed, scaled_.round_off())) return true;
    if (round > 2 && off > 0.7 * before) return off <= nearly_closed;
    before = off;
    const VectorXd x = equations.close(-violation);
    if (!x.allFinite() || largest_of(x) > 1) return false;
    scaled_.move(q, x, q);
  }
  return before <= nearly_closed;
}

/// Forces, tangent and constraints at the present position. False: forces are not finite.
bool SparseSearch::evaluate(Point& at, StaticsStatus& status) {
  J_ = scaled_.jacobian(s_.q, multipliers_);
  at.violation = scaled_.violation(s_.q, at.off);
  scaled_.kinds(status);
  at.r = forces(s_.q, multipliers_);
  scaled_.keep_turns(s_.z.data());
  if (!at.r.allFinite()) return false;
  K_ = scaled_.stiffness(s_.q, multipliers_, false);
  return true;
}

/// With a τ for which the matrix is definite, or the least.
void SparseSearch::factor(TrustTime& time, linalg::ConstrainedSolver& equations, Step& step) const {
  for (;;) {
    equations.set(K_ + time.inertia() * mass_, J_);
    step.is_definite = equations.definite();
    if (step.is_definite || time.is_least()) return;
    time.hinder(2);
  }
}

bool SparseSearch::solve(linalg::ConstrainedSolver& equations, const Point& at, Step& step) const {
  if (!equations.solve(-at.r, -at.violation, step.x, step.change) || !step.x.allFinite()) return false;
  step.unbalanced = at.r;
  if (step.change.size() > 0) step.unbalanced += J_.transpose() * step.change;
  step.length = largest_of(step.x);
  return true;
}

/// Where forces balance: Newton's step if it is tiny, whether or not the equilibrium is stable.
void SparseSearch::take_newtons(const Point& at, TrustTime& time, Step& step) const {
  linalg::ConstrainedSolver indefinite;
  indefinite.set(K_ + time.least_inertia() * mass_, J_);
  VectorXd x, change;
  if (!indefinite.ok() || !indefinite.solve(-at.r, -at.violation, x, change) || largest_of(x) >= tiny_step)
    return;
  step.x = x;
  step.change = change;
  step.length = largest_of(x);
  time.open();
}

/// Moves by the step or a share of it, or shortens τ where it leads too far; never: where τ is the least.
SparseSearch::Taken SparseSearch::take(const Step& step, const linalg::ConstrainedSolver& equations,
                                       TrustTime& time) {
  // Straight steps leave the constraints by the square of the angles that bodies turn by.
  VectorXd q(s_.q.size());
  scaled_.move(s_.q, step.x, q);
  double leaves = 0;
  scaled_.violation(q, leaves);
  const double share = leaves > furthest_turn * furthest_turn ? furthest_turn / std::sqrt(leaves) : 1;
  if (share < 0.3 && !time.is_least()) {
    time.hinder(1 / std::max(0.3, std::sqrt(share)));
    return Taken::no;
  }
  if (share < 1) scaled_.move(s_.q, share * step.x, q);
  const VectorXd multipliers = multipliers_ + share * step.change;
  if (!close(equations, q) && !time.is_least()) {
    time.divide(4);
    return Taken::no;
  }
  const double before = step.x.dot(step.unbalanced), after = step.x.dot(forces(q, multipliers)),
               expected = before + share * step.x.dot(K_ * step.x), size = std::abs(before);
  if (!std::isfinite(after)) {
    if (time.is_least()) return Taken::never;
    time.divide(4);
    return Taken::no;
  }
  const bool tiny = step.length < tiny_step;
  if (!tiny && step.is_definite && after > overshoot * size && !time.is_least()) {
    time.hinder(3);
    return Taken::no;
  }
  time.adapt(size > 0 && !tiny ? std::abs(after - expected) / size : 0);
  s_.q = q;
  multipliers_ = multipliers;
  return Taken::yes;
}

StaticsStatus SparseSearch::search() {
  StaticsStatus status;
  const double closed = std::max(still, 10 * scaled_.round_off());
  TrustTime time(pace_);
  linalg::ConstrainedSolver equations;
  Point at;
  Step step;
  double last = 0;
  int stalled = 0;
  bool moved = true;
  for (int trials = 0; status.iterations < most_steps && trials < most_trials; ++trials) {
    if (moved) {
      ++status.iterations;
      if (!evaluate(at, status)) return status;
      moved = false;
    }
    factor(time, equations, step);
    if (!equations.ok()) return status;
    if (!solve(equations, at, step)) {
      if (time.is_least()) return status;
      time.divide(4);
      continue;
    }
    double work = 0;
    if (scaled_.coordinates() > 0) {
      work = step.unbalanced.cwiseAbs().maxCoeff(&status.coordinate);
      status.residual = work / scaled_.scale()[status.coordinate];
    }
    const bool balanced =
        work <= std::max(balanced_share * energy_, round_off_share * linalg::largest_entry(K_));
    if (balanced && !time.is_newton() && at.off < closed) take_newtons(at, time, step);
    stalled = step.length < tiny_step && step.length > 0.5 * last ? stalled + 1 : 0;
    last = step.length;
    if (balanced && time.is_newton() && at.off < closed && (step.length < still || stalled > 3)) {
      status.converged = true;
      multipliers_ += step.change;
      return status;
    }
    const Taken taken = take(step, equations, time);
    if (taken == Taken::never) return status;
    moved = taken == Taken::yes;
  }
  return status;
}

/// Newton's steps, as long as the matrix is definite and no step goes further than the mechanism is large:
/// slender parts turn far at the cost of forces along them, which grow in every step and vanish in the next,
/// so that a search that looks at forces makes tiny steps. What nothing holds, or touches nothing yet, would
/// go far, and is left to that search.
StaticsStatus SparseSearch::newton() {
  StaticsStatus status;
  const double closed = std::max(still, 10 * scaled_.round_off());
  TrustTime time(pace_);
  time.open();
  linalg::ConstrainedSolver equations;
  Point at;
  Step step;
  double last = 0;
  int stalled = 0;
  VectorXd q(s_.q.size());
  while (status.iterations < most_newtons) {
    ++status.iterations;
    if (!evaluate(at, status)) return status;
    const double round_off = round_off_share * linalg::largest_entry(K_);
    // The weight of small bodies may be within the round-off of their stiffness.
    const bool weightless = scaled_.acceleration() == 0 || largest_of(at.r) <= round_off_of_play * energy_;
    if (status.iterations == 1 && at.off < closed && largest_of(at.r) <= round_off && weightless) {
      status.converged = true;  // as it is drawn, even if nothing holds it
      return status;
    }
    equations.set(K_ + time.inertia() * mass_, J_);
    if (!equations.ok() || !equations.definite() || !solve(equations, at, step)) return status;
    double work = 0;
    if (scaled_.coordinates() > 0) {
      work = step.unbalanced.cwiseAbs().maxCoeff(&status.coordinate);
      status.residual = work / scaled_.scale()[status.coordinate];
    }
    if (step.length > furthest_newton) return status;
    const bool balanced = work <= std::max(balanced_share * energy_, round_off);
    stalled = step.length < tiny_step && step.length > 0.5 * last ? stalled + 1 : 0;
    last = step.length;
    if (balanced && at.off < closed && (step.length < still || stalled > 3)) {
      status.converged = true;
      multipliers_ += step.change;
      return status;
    }
    scaled_.move(s_.q, step.x, q);
    double leaves = 0;
    scaled_.violation(q, leaves);
    const double share = leaves > furthest_turn * furthest_turn ? furthest_turn / std::sqrt(leaves) : 1;
    if (share < 1) scaled_.move(s_.q, share * step.x, q);
    if (!q.allFinite() || !close(equations, q)) return status;
    s_.q = q;
    multipliers_ += share * step.change;
  }
  return status;
}

StaticsStatus SparseSearch::run() {
  const VectorXd q = s_.q, z = s_.z, multipliers = multipliers_;
  const StaticsStatus first = newton();
  if (first.converged) return first;
  s_.q = q;
  s_.z = z;
  multipliers_ = multipliers;
  StaticsStatus status = search();
  status.iterations += first.iterations;
  return status;
}

/// Forces that are not balanced at the start are applied bit by bit, each equilibrium the start of the next.
StaticsStatus SparseSearch::run_by_loads() {
  J_ = scaled_.jacobian(s_.q, multipliers_);
  double off = 0;
  const VectorXd violation = scaled_.violation(s_.q, off);
  const VectorXd r = scaled_.forces(s_.q, multipliers_);
  Matrix unit(r.size(), r.size());
  unit.setIdentity();
  linalg::ConstrainedSolver equations;
  VectorXd x, change;
  StaticsStatus all;
  equations.set(unit, J_);
  if (!equations.ok() || !equations.solve(-r, -violation, x, change)) return all;
  multipliers_ += change;
  const VectorXd all_held = scaled_.forces(s_.q, multipliers_);
  double applied = 0, next = 0.1;
  while (applied < 1 && all.load_steps < 200) {
    const VectorXd q = s_.q, z = s_.z, multipliers = multipliers_;
    const double to = std::min(1.0, applied + next);
    held_ = (1 - to) * all_held;
    const StaticsStatus status = search();
    ++all.load_steps;
    const int iterations = all.iterations + status.iterations, steps = all.load_steps;
    if (status.converged) {
      applied = to;
      next *= 2;
    } else {
      s_.q = q;
      s_.z = z;
      multipliers_ = multipliers;
      next /= 4;
    }
    all = status;
    all.iterations = iterations;
    all.load_steps = steps;
    if (next < 1e-3) break;
  }
  all.converged = all.converged && applied >= 1;
  held_.setZero();
  return all;
}

/// The least σ ≥ 0 with which the symmetric part of K + σ M is positive definite along the motions that
/// constraints leave, counted by pivots, is the square of the growth where K is symmetric along these.
/// Inverse iteration with K itself confirms it, and finds the motion.
void SparseSearch::judge_stability(StaticsStatus& status, VectorXd* growing) {
  K_ = scaled_.stiffness(s_.q, multipliers_, true);
  J_ = scaled_.jacobian(s_.q, multipliers_);
  linalg::ConstrainedSolver equations;
  const auto stable = [&](double sigma) {
    equations.set(K_ + sigma * mass_, J_);
    return equations.definite();
  };
  const double slow = neutral * pace_ * pace_;
  double low = slow;
  if (stable(low)) return;
  double high = 10 * low;
  while (!stable(high)) {
    low = high;
    high *= 10;
    if (!(high < 1e30 * pace_ * pace_)) return;
  }
  for (int k = 0; k < 60 && high > 1.01 * low; ++k) {
    const double middle = std::sqrt(low * high);
    (stable(middle) ? high : low) = middle;
  }
  const double shift = 1.1 * high;
  if (!stable(shift)) return;
  VectorXd x(K_.cols()), by;
  for (Eigen::Index k = 0; k < x.size(); ++k) x[k] = 0.5 + uniform_at(1, static_cast<std::uint64_t>(k));
  const VectorXd closed = VectorXd::Zero(J_.rows());
  double value = 0;
  bool settled = false;
  for (int k = 0; k < 60 && !settled; ++k) {
    VectorXd y;
    const VectorXd right = mass_ * x;
    if (!equations.solve(right, closed, y, by) || !(y.norm() > 0)) return;
    const double next = y.dot(right) / y.dot(mass_ * y) - shift;
    settled = k > 2 && std::abs(next - value) <= 1e-7 * std::abs(next);
    value = next;
    x = y / y.norm();
  }
  // Differences of forces are not sharper than this.
  const double sharp =
      1e-10 * x.cwiseAbs().dot(K_.cwiseAbs() * x.cwiseAbs()) + 1e-9 * energy_ * x.squaredNorm();
  if (!settled || value >= -slow || -value * x.dot(mass_ * x) <= sharp) return;
  status.growth = std::sqrt(-value);
  x.cwiseAbs().maxCoeff(&status.growing);
  if (growing) *growing = scaled_.scale().cwiseProduct(x);
}

}  // namespace sparse_search

}  // namespace

StaticsStatus find_sparse_equilibrium(System& system, const linalg::ColumnColours& colours, State& s,
                                      VectorXd* growing) {
  const State start = s;
  sparse_search::SparseSearch search(system, colours, s);
  StaticsStatus status = search.run();
  status.sparse = true;
  if (status.converged) {
    search.judge_stability(status, growing);
    search.finish();
    return status;
  }
  search.finish();
  const State there = s;
  s = start;
  sparse_search::SparseSearch by_loads(system, colours, s);
  StaticsStatus next = by_loads.run_by_loads();
  if (!next.converged) {
    s = there;
    return status;
  }
  by_loads.judge_stability(next, growing);
  by_loads.finish();
  next.sparse = true;
  next.iterations += status.iterations;
  return next;
}

void find_sparse_multipliers(System& system, State& s) {
  using namespace sparse_search;
  const linalg::ColumnColours none(system.velocities(), {});
  ScaledSystem scaled(system, none, s);
  VectorXd multipliers = VectorXd::Zero(system.equations()), x;
  const Matrix J = scaled.jacobian(s.q, multipliers);
  VectorXd r(system.velocities());
  s.multipliers.setZero(system.equations());
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  Matrix unit(r.size(), r.size());
  unit.setIdentity();
  linalg::ConstrainedSolver equations;
  equations.set(unit, J);
  if (!equations.ok()) return;
  const VectorXd right = -scaled.scale().cwiseProduct(r);
  if (equations.solve(right, VectorXd::Zero(J.rows()), x, multipliers))
    s.multipliers = scaled.unscaled(multipliers);
}

}  // namespace mimbre
