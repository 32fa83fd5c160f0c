#include "simulation/observe/smallest_reactions.h"

#include <algorithm>
#include <cmath>

#include "dynamics/relative/residual.h"

namespace mimbre {
namespace {

/// Of the diagonal, added to A Aᵀ: motions that strain the joints by less than its root, 1e-5, count as free.
constexpr double regularisation = 1e-10;
constexpr int most_balances = 30;
/// What is not resolved: strains within a step, at most this; of n joints in a row, 1/n is nothing unusual.
constexpr double most_strain = 1e-2, least_strain = 0.1;
constexpr double excess = 10;       ///< of all wrenches over those that need no motion without strain
constexpr double least_excess = 3;  ///< of all wrenches over what they do to the bodies

/// Completes `count` orthonormal directions to three; the new ones are returned behind them.
void complete(Vec3d* directions, int count) {
  for (; count < 3; ++count) {
    Vec3d best = Vec3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d candidate = Vec3d::Unit(axis);
      for (int k = 0; k < count; ++k) candidate -= directions[k].dot(candidate) * directions[k];
      if (candidate.squaredNorm() > best.squaredNorm()) best = candidate;
    }
    directions[count] = best.normalized();
  }
}

}  // namespace

SmallestReactions::SmallestReactions(const Compiled& m) : model_(m), drive_(m.velocities, -1) {
  for (const DriveData& d : m.drives) drive_[d.v] = d.equation;
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    Transmitted t;
    t.tree = static_cast<int>(i);
    t.frame_a = b.reversed ? b.outboard_frame : b.inboard_frame;
    t.frame_b = b.reversed ? b.inboard_frame : b.outboard_frame;
    t.sign = b.reversed ? -1 : 1;
    joints_.push_back(t);
  }
  for (std::size_t l = 0; l < m.loops.size(); ++l) {
    Transmitted t;
    t.loop = static_cast<int>(l);
    t.frame_a = m.loops[l].frame_a;
    t.frame_b = m.loops[l].frame_b;
    joints_.push_back(t);
  }
  linalg::BlockPattern pattern;
  int unknowns = 0, widest = 8;
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    pattern.sizes.push_back(size(static_cast<int>(i)));
    unknowns += pattern.sizes.back();
    if (m.bodies[i].modes > 0) widest = std::max(widest, m.flexible[m.bodies[i].flexible].stride);
  }
  std::ptrdiff_t storage = 0;
  for (Transmitted& t : joints_) {
    t.body_a = m.frames[t.frame_a].body;
    t.body_b = m.frames[t.frame_b].body;
    t.rows_a = storage;
    if (t.body_a >= 0) storage += 6 * size(t.body_a);
    t.rows_b = storage;
    if (t.body_b >= 0) storage += 6 * size(t.body_b);
    if (t.body_a >= 0 && t.body_b >= 0) pattern.couplings.push_back({t.body_a, t.body_b});
  }
  symbolic_ = std::make_unique<linalg::BlockSymbolic>(pattern);
  factor_ = std::make_unique<linalg::BlockFactor<double>>(*symbolic_);
  for (int i = 0; i < static_cast<int>(m.bodies.size()); ++i) diagonal_.push_back(symbolic_->place(i, i));
  for (Transmitted& t : joints_) {
    if (t.body_a >= 0) t.aa = diagonal_[t.body_a];
    if (t.body_b >= 0) t.bb = diagonal_[t.body_b];
    if (t.body_a >= 0 && t.body_b >= 0) t.ab = symbolic_->place(t.body_a, t.body_b);
  }
  centre_.resize(m.bodies.size());
  places_.resize(m.bodies.size());
  rows_.resize(storage);
  y_.assign(widest, 0.0);
  modal_.assign(widest, 0.0);
  const Eigen::Index columns = static_cast<Eigen::Index>(6 * joints_.size());
  for (Eigen::VectorXd* x : {&given_, &x_, &change_}) x->setZero(columns);
  for (Eigen::VectorXd* x : {&left_, &solution_}) x->setZero(unknowns);
}

void SmallestReactions::set_amplitudes(const State& s, int body) {
  const BodyData& b = model_.bodies[body];
  if (b.modes == 0) return;
  const FlexibleData& f = model_.flexible[b.flexible];
  for (int k = 0; k < f.stride; ++k) y_[k] = k < b.modes ? s.q[b.q + b.joint_positions + k] : 0;
  extend(f, y_.data());
}

/// Unit wrenches of all joints, and how much of each is transmitted now.
void SmallestReactions::set_wrenches(const relative::RelativeSystem& system, const State& s,
                                     const Eigen::VectorXd& multipliers) {
  const relative::Workspace<double>& w = system.workspace();
  const double length = model_.length_scale;
  std::fill(centre_.begin(), centre_.end(), Vec3d::Zero());
  std::fill(places_.begin(), places_.end(), 0);
  int first = 0;
  for (Transmitted& t : joints_) {
    const FrameData& b = model_.frames[t.frame_b];
    if (b.body < 0) {
      t.at = b.position - w.origin;
    } else {
      Vec3d place = b.position;
      if (b.flexible >= 0) {
        set_amplitudes(s, b.body);
        place += times(b.X, y_.data());
      }
      t.at = w.bodies[b.body].position + w.bodies[b.body].rotation * place;
    }
    for (const int body : {t.body_a, t.body_b})
      if (body >= 0) centre_[body] += t.at, ++places_[body];
    t.first = first;
    t.count = 0;
    const auto add = [&](const Vec3d& force, const Vec3d& moment, double share) {
      t.force[t.count] = force;
      t.moment[t.count] = moment;
      given_[first++] = share;
      ++t.count;
    };
    if (t.loop >= 0) {
      const LoopData& loop = model_.loops[t.loop];
      for (int r = 0; r < loop.count; ++r) {
        const int k = loop.first_equation + r;
        if (loop.closure[r].kind == LoopClosure::Kind::distance)
          add(-w.covector_linear[k], Vec3d::Zero(), multipliers[k]);
        else
          add(Vec3d::Zero(), -length * w.covector_angular[k], multipliers[k] / length);
      }
      continue;
    }
    // What is left by the joint's free motions.
    const BodyData& body = model_.bodies[t.tree];
    Vec3d linear[3], angular[3];
    int lines = 0, turns = 0;
    for (int j = body.v; j < body.v + body.joint_velocities; ++j) {
      if (drive_[j] >= 0) continue;
      Vec3d direction = w.joint_angular[j];
      const bool turn = direction.squaredNorm() > 0.25;
      if (!turn) direction = w.joint_linear[j];
      Vec3d* const known = turn ? angular : linear;
      int& count = turn ? turns : lines;
      for (int k = 0; k < count; ++k) direction -= known[k].dot(direction) * known[k];
      if (direction.norm() > 1e-3) known[count++] = direction.normalized();
    }
    complete(linear, lines);
    complete(angular, turns);
    const Vec3d force = t.sign * w.transmitted[t.tree].force;
    const Vec3d moment = t.sign * w.transmitted[t.tree].moment - t.at.cross(force);
    for (int k = lines; k < 3; ++k) add(linear[k], Vec3d::Zero(), linear[k].dot(force));
    for (int k = turns; k < 3; ++k) add(Vec3d::Zero(), length * angular[k], angular[k].dot(moment) / length);
  }
  for (std::size_t i = 0; i < centre_.size(); ++i)
    if (places_[i] > 0) centre_[i] /= places_[i];
}

/// A's rows of one body: what each unit wrench, times `sign`, does to it.
void SmallestReactions::set_rows(const relative::RelativeSystem& system, int body, int frame, double sign,
                                 const Transmitted& t, double* rows) {
  const FrameData& f = model_.frames[frame];
  const Motion<double>& motion = system.workspace().bodies[body];
  const int n = size(body);
  for (int c = 0; c < t.count; ++c) {
    double* out = rows + static_cast<std::ptrdiff_t>(c) * n;
    const Vec3d force = sign * t.force[c], moment = sign * t.moment[c];
    Eigen::Map<Vec3d> forces(out), moments(out + 3);
    forces = force;
    moments = ((t.at - centre_[body]).cross(force) + moment) / model_.length_scale;
    std::fill(out + 6, out + n, 0.0);
    if (f.flexible < 0) continue;
    const FlexibleData& flexible = model_.flexible[f.flexible];
    std::fill(modal_.begin(), modal_.begin() + flexible.stride, 0.0);
    const Vec3d place = motion.position + motion.rotation * (f.position + times(f.X, y_.data()));
    relative::frame_modal_force<double>(f, motion, y_.data(), force, moment + (t.at - place).cross(force),
                                        modal_.data());
    fold(flexible, y_.data(), modal_.data());
    std::copy(modal_.begin(), modal_.begin() + (n - 6), out + 6);
  }
}

bool SmallestReactions::factor(double regularisation) {
  factor_->set_zero();
  double* const values = factor_->values();
  const auto add = [&](const Transmitted& t, const linalg::BlockPlace& place, const double* left, int rows,
                       const double* right, int columns) {
    for (int k = 0; k < t.count; ++k, left += rows, right += columns)
      for (int c = 0; c < columns; ++c)
        for (int r = 0; r < rows; ++r)
          values[place.offset + r * place.row_stride + c * place.col_stride] += left[r] * right[c];
  };
  for (const Transmitted& t : joints_) {
    const double *a = rows_.data() + t.rows_a, *b = rows_.data() + t.rows_b;
    if (t.body_a >= 0) add(t, t.aa, a, size(t.body_a), a, size(t.body_a));
    if (t.body_b >= 0) add(t, t.bb, b, size(t.body_b), b, size(t.body_b));
    if (t.body_a >= 0 && t.body_b >= 0) add(t, t.ab, a, size(t.body_a), b, size(t.body_b));
  }
  // Not of rows that are nothing but round-off: forces and moments have one unit here, amplitudes that of
  // their body's.
  for (std::size_t i = 0; i < diagonal_.size(); ++i) {
    const auto diagonal = [&](int k) -> double& {
      return values[diagonal_[i].offset + k * (diagonal_[i].row_stride + diagonal_[i].col_stride)];
    };
    double modal = 0;
    for (int k = 6; k < size(static_cast<int>(i)); ++k) modal = std::max(modal, diagonal(k));
    const double least = modal > 0 ? 1e-6 * modal : 1;
    for (int k = 0; k < size(static_cast<int>(i)); ++k)
      diagonal(k) += regularisation * std::max(diagonal(k), k < 6 ? 1 : least);
  }
  return factor_->factor().ok();
}

void SmallestReactions::add_times(const Eigen::VectorXd& x, double weight, Eigen::VectorXd& out) const {
  const auto add = [&](const Transmitted& t, int body, std::ptrdiff_t rows) {
    if (body < 0) return;
    const int n = size(body), start = symbolic_->start(body);
    for (int c = 0; c < t.count; ++c)
      for (int r = 0; r < n; ++r) out[start + r] += weight * x[t.first + c] * rows_[rows + c * n + r];
  };
  for (const Transmitted& t : joints_) {
    add(t, t.body_a, t.rows_a);
    add(t, t.body_b, t.rows_b);
  }
}

void SmallestReactions::add_transposed_times(const Eigen::VectorXd& y, Eigen::VectorXd& out) const {
  const auto add = [&](const Transmitted& t, int body, std::ptrdiff_t rows) {
    if (body < 0) return;
    const int n = size(body), start = symbolic_->start(body);
    for (int c = 0; c < t.count; ++c)
      for (int r = 0; r < n; ++r) out[t.first + c] += y[start + r] * rows_[rows + c * n + r];
  };
  for (const Transmitted& t : joints_) {
    add(t, t.body_a, t.rows_a);
    add(t, t.body_b, t.rows_b);
  }
}

/// The wrenches that are transmitted now, and what they do to each body.
void SmallestReactions::set_given(const relative::RelativeSystem& system, const State& s,
                                  const Eigen::VectorXd& multipliers) {
  given_.setZero();
  set_wrenches(system, s, multipliers);
  for (const Transmitted& t : joints_) {
    if (t.body_a >= 0) {
      set_amplitudes(s, t.body_a);
      set_rows(system, t.body_a, t.frame_a, -1, t, rows_.data() + t.rows_a);
    }
    if (t.body_b >= 0) {
      set_amplitudes(s, t.body_b);
      set_rows(system, t.body_b, t.frame_b, 1, t, rows_.data() + t.rows_b);
    }
  }
  left_.setZero();
  add_times(given_, 1, left_);
}

/// The smallest wrenches, x_, that do what is left; returns what they leave.
double SmallestReactions::balance(int rounds) {
  const double load = left_.norm();
  x_.setZero();
  double left = load;
  for (int round = 0; round < rounds && left > 1e-12 * load; ++round) {
    solution_ = left_;
    factor_->solve(solution_.data());
    change_.setZero();
    add_transposed_times(solution_, change_);
    x_ += change_;
    add_times(change_, -1, left_);
    const double before = left;
    left = left_.norm();
    if (!(left < 0.5 * before)) break;
  }
  return left;
}

bool SmallestReactions::find(const relative::RelativeSystem& system, const State& s,
                             Eigen::VectorXd& multipliers) {
  set_given(system, s, multipliers);
  if (!factor(regularisation)) return false;
  const double load = left_.norm();
  if (!(balance(most_balances) <= 1e-3 * load) || !x_.allFinite()) return false;
  set_multipliers(system, multipliers);
  return true;
}

std::optional<UnresolvedReaction> SmallestReactions::limit(const relative::RelativeSystem& system,
                                                           const State& s, double strain,
                                                           Eigen::VectorXd& multipliers) {
  set_given(system, s, multipliers);
  // Joints that are not near a singular position carry about what they do to the bodies.
  if (!(given_.norm() > least_excess * left_.norm())) return {};
  const double least = std::min({strain, most_strain, least_strain / static_cast<double>(joints_.size())});
  if (!(least * least > regularisation) || !factor(least * least)) return {};
  balance(1);
  if (!x_.allFinite() || !(given_.norm() > excess * x_.norm())) return {};
  UnresolvedReaction found;
  double largest = 0;
  for (const Transmitted& t : joints_) {
    Vec3d force = Vec3d::Zero(), moment = Vec3d::Zero();
    for (int c = 0; c < t.count; ++c) {
      force += given_[t.first + c] * t.force[c];
      moment += given_[t.first + c] * t.moment[c];
    }
    const double size = force.norm() + moment.norm() / model_.length_scale;
    if (!(size > largest)) continue;
    largest = size;
    found = {s.time, t.loop >= 0 ? model_.loops[t.loop].joint_spec : model_.bodies[t.tree].joint_spec,
             force.norm(), moment.norm()};
  }
  set_multipliers(system, multipliers);
  return found;
}

/// Makes the multipliers those of the wrenches x_.
void SmallestReactions::set_multipliers(const relative::RelativeSystem& system,
                                        Eigen::VectorXd& multipliers) const {
  const double length = model_.length_scale;
  for (const Transmitted& t : joints_) {
    if (t.loop >= 0) {
      const LoopData& loop = model_.loops[t.loop];
      for (int r = 0; r < loop.count; ++r) {
        const bool distance = loop.closure[r].kind == LoopClosure::Kind::distance;
        multipliers[loop.first_equation + r] = x_[t.first + r] * (distance ? 1 : length);
      }
      continue;
    }
    // A drive carries what the joint's wrench does along its coordinate.
    const BodyData& body = model_.bodies[t.tree];
    for (int j = body.v; j < body.v + body.joint_velocities; ++j) {
      if (drive_[j] < 0) continue;
      const Vec3d turn = system.workspace().joint_angular[j];
      const Vec3d line = system.workspace().joint_linear[j] + turn.cross(t.at);
      for (int c = 0; c < t.count; ++c)
        multipliers[drive_[j]] -=
            t.sign * (x_[t.first + c] - given_[t.first + c]) * (line.dot(t.force[c]) + turn.dot(t.moment[c]));
    }
  }
}

}  // namespace mimbre
