#include "integrate/global_modes/global_modes.h"

#include <algorithm>
#include <cmath>

#include "integrate/drift.h"
#include "integrate/global_modes/build_table.h"

namespace mimbre {

using Eigen::Index;
using Eigen::VectorXd;
using global_modes::LoopTable;
using global_modes::NoGlobalModes;

namespace {
/// Corrections that shrink by less than this from one to the next ask for another matrix. An evaluation costs
/// about as much as a matrix.
constexpr double slow_by_matrix = 0.3;
/// Of the scales of coordinates, between a state and the table.
constexpr double furthest_off = 0.1;
}  // namespace

GlobalModesStepper::GlobalModesStepper(System& system, const IntegratorOptions& options)
    : Stepper(options), system_(system), motion_(system, options) {
  set_step(options.step);
}

void GlobalModesStepper::set_step(double step) {
  options_.step = step;
  motion_.set_step(step);
  weights_ = {motion_.rate * motion_.scale, motion_.scale, 0};
}

bool GlobalModesStepper::prepare(const State& state) {
  if (prepared_) return false;
  const CoordinateKinds kinds = system_.coordinate_kinds();
  if (kinds.kind.empty())
    throw NoGlobalModes("its coordinates are not those of joints; use formulation: relative", -1);
  if (!system_.driven_coordinates().empty())
    throw NoGlobalModes("its body bends by linear elastodynamics", system_.driven_coordinates().front());
  for (std::size_t k = 0; k < system_.scales().is_rate.size(); ++k)
    if (system_.scales().is_rate[k])
      throw NoGlobalModes("a constraint on velocities has no place in a table", -1, static_cast<int>(k));
  tables_.clear();
  free_.clear();
  system_.begin_step(state.q.data());
  global_modes::Probe probe(system_, state.time);
  probe.evaluate(state.q);
  const global_modes::LoopsAndDrives found = global_modes::find_loops(system_, kinds);
  global_modes::TableOptions table;
  table.step = options_.step;
  std::vector<char> tabulated(kinds.kind.size(), 0);
  for (const global_modes::Loop& loop : found.loops) {
    tables_.push_back(build_table(probe, loop, kinds, state, table));
    for (const std::vector<int>* list : {&loop.rigid, &loop.amplitudes})
      for (const int k : *list) tabulated[static_cast<std::size_t>(k)] = 1;
  }
  for (int k = 0; k < system_.velocities(); ++k)
    if (!tabulated[static_cast<std::size_t>(k)]) free_.push_back(k);
  size_ = static_cast<int>(free_.size());
  for (const LoopTable& t : tables_) {
    loops_.push_back({global_modes::LoopMotion(t), size_});
    size_ += 1 + t.modes;
  }
  prescribed_.assign(static_cast<std::size_t>(size_), 0);
  for (const global_modes::Prescribed& p : found.prescribed) {
    OfDrive drive{p, -1};
    for (std::size_t k = 0; k < free_.size(); ++k)
      if (free_[k] == p.coordinate) drive.y = static_cast<int>(k);
    for (const OfLoop& loop : loops_)
      if (loop.motion.table().coordinate == p.coordinate) drive.y = loop.first;
    drives_.push_back(drive);
    prescribed_[static_cast<std::size_t>(drive.y)] = 1;
  }
  const int n = system_.velocities();
  for (VectorXd* x : {&start_v_, &start_a_, &start_w_, &start_delta_, &y_, &x_, &v_, &a_, &w_, &reduced_})
    x->setZero(size_);
  for (VectorXd* x : {&r_, &delta_, &full_}) x->setZero(n);
  none_.setZero(system_.equations());
  f_.setZero(n, n);
  work_.setZero(static_cast<Index>(n) * size_);
  column_.setZero(n);
  matrix_.setIdentity(size_, size_);
  factor_.compute(matrix_);
  choose_parts();
  prepared_ = true;
  return true;
}

/// The parts of the matrix, and which of them force elements, mass or stiffness couple.
void GlobalModesStepper::choose_parts() {
  parts_.push_back({free_, nullptr, {}, 0});
  for (OfLoop& loop : loops_) {
    Part part{{loop.motion.table().coordinate}, &loop.motion, {}, loop.first};
    part.coordinates.insert(part.coordinates.end(), loop.motion.rows().begin(), loop.motion.rows().end());
    part.Z.setZero(loop.motion.Z().rows() + 1, loop.motion.Z().cols());
    part.Z(0, 0) = 1;
    parts_.push_back(std::move(part));
  }
  const linalg::BlockSymbolic& pattern = system_.pattern();
  std::vector<int> block_of(static_cast<std::size_t>(system_.velocities()), 0);
  for (int b = 0; b < pattern.blocks(); ++b)
    for (int k = pattern.start(b); k < (b + 1 < pattern.blocks() ? pattern.start(b + 1) : pattern.size());
         ++k)
      block_of[static_cast<std::size_t>(k)] = b;
  const auto coupled = [&](const Part& one, const Part& other) {
    if (pattern.size() == 0 || &one == &other) return true;
    for (const int a : one.coordinates)
      for (const int b : other.coordinates)
        if (pattern.coupled(block_of[static_cast<std::size_t>(a)], block_of[static_cast<std::size_t>(b)]))
          return true;
    return false;
  };
  for (std::size_t i = 0; i < parts_.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j)
      if (coupled(parts_[i], parts_[j])) coupled_.emplace_back(i, j);
}

/// y, ẏ, ÿ and what the rule carries over at the start of the step.
void GlobalModesStepper::read_start(const State& s) {
  const auto read = [&](const VectorXd& from, VectorXd& to) {
    for (std::size_t k = 0; k < free_.size(); ++k) to[static_cast<Index>(k)] = from[free_[k]];
    for (const OfLoop& loop : loops_) {
      to[loop.first] = from[loop.motion.table().coordinate];
      loop.motion.amplitude_rates(from.data(), to.data() + loop.first + 1);
    }
  };
  read(s.v, start_v_);
  read(motion_.start_a, start_a_);
  read(motion_.start_algorithmic, start_w_);
  for (OfLoop& loop : loops_) {
    start_delta_[loop.first] = loop.motion.parameter(s.q.data());
    loop.motion.amplitudes(s.q.data(), start_delta_.data() + loop.first + 1);
    loop.motion.move(start_delta_[loop.first], start_delta_.data() + loop.first + 1, motion_.q.data());
  }
}

/// A coordinate that is not where the table has it: the state is that of another assembly. −1: none.
int GlobalModesStepper::find_off_table(const State& s) const {
  const std::vector<double>& scale = system_.scales().coordinates;
  for (const OfLoop& loop : loops_) {
    const LoopTable& t = loop.motion.table();
    if (!t.holds(start_delta_[loop.first])) return t.coordinate;
    for (std::size_t k = 0; k < t.plain.size(); ++k)
      if (!(std::abs(motion_.q[t.plain_position[k]] - s.q[t.plain_position[k]]) <=
            furthest_off * scale[static_cast<std::size_t>(t.plain[k])]))
        return t.plain[k];
  }
  return -1;
}

/// x for constant accelerations, without what should not be extrapolated of modes.
void GlobalModesStepper::predict() {
  const RuleCoefficients& c = motion_.rule;
  const double h = motion_.h;
  for (Index k = 0; k < size_; ++k) {
    const double next = (start_a_[k] - c.alpha_m * start_w_[k]) / (1 - c.alpha_m);
    x_[k] = h * start_v_[k] + h * h * ((0.5 - c.beta) * start_w_[k] + c.beta * next);
  }
  full_.setZero();
  for (std::size_t k = 0; k < free_.size(); ++k) full_[free_[k]] = x_[static_cast<Index>(k)];
  for (const OfLoop& loop : loops_) {
    const LoopTable& t = loop.motion.table();
    for (std::size_t i = 0; i < t.amplitude.size(); ++i)
      for (int m = 0; m < t.modes; ++m)
        full_[t.amplitude[i]] +=
            loop.motion.Z()(t.joints() + static_cast<Index>(i), 1 + m) * x_[loop.first + 1 + m];
  }
  system_.temper_prediction(h, full_.data());
  for (std::size_t k = 0; k < free_.size(); ++k) x_[static_cast<Index>(k)] = full_[free_[k]];
  for (const OfLoop& loop : loops_) loop.motion.amplitude_rates(full_.data(), x_.data() + loop.first + 1);
}

bool GlobalModesStepper::expand(const State& s, bool driven, StepStatus& status) {
  const RuleCoefficients& c = motion_.rule;
  const double h = motion_.h, i = 1 / (c.beta * h * h), rest = (0.5 - c.beta) / c.beta;
  for (Index k = 0; k < size_; ++k) {
    if (driven && prescribed_[static_cast<std::size_t>(k)]) continue;
    w_[k] = i * (x_[k] - h * start_v_[k]) - rest * start_w_[k];
    v_[k] = start_v_[k] + h * ((1 - c.gamma) * start_w_[k] + c.gamma * w_[k]);
    a_[k] = ((1 - c.alpha_m) * w_[k] + c.alpha_m * start_w_[k] - c.alpha_f * start_a_[k]) / (1 - c.alpha_f);
  }
  full_.setZero();
  for (std::size_t k = 0; k < free_.size(); ++k) {
    full_[free_[k]] = x_[static_cast<Index>(k)];
    motion_.v[free_[k]] = v_[static_cast<Index>(k)];
    motion_.a[free_[k]] = a_[static_cast<Index>(k)];
  }
  system_.retract(s.q.data(), full_.data(), motion_.q.data());
  for (OfLoop& loop : loops_) {
    const LoopTable& t = loop.motion.table();
    for (int k = 0; k <= t.modes; ++k) y_[loop.first + k] = start_delta_[loop.first + k] + x_[loop.first + k];
    if (!t.holds(y_[loop.first])) {
      status.coordinate = t.coordinate;
      return false;
    }
    loop.motion.move(y_[loop.first], y_.data() + loop.first + 1, motion_.q.data());
    loop.motion.velocities(v_.data() + loop.first, motion_.v.data());
    loop.motion.accelerations(v_.data() + loop.first, a_.data() + loop.first, motion_.a.data());
  }
  return true;
}

/// Prescribed coordinates at the end of the step, by their own equations.
void GlobalModesStepper::follow_drives(const State& s) {
  system_.kinematics(s.time + motion_.h, motion_.q.data(), motion_.v.data(), motion_.a.data());
  const RuleCoefficients& c = motion_.rule;
  for (const OfDrive& drive : drives_) {
    const double by = 1 / drive.at.factor;
    x_[drive.y] -= by * system_.phi()[drive.at.equation];
    v_[drive.y] -= by * system_.phi_dot()[drive.at.equation];
    a_[drive.y] -= by * system_.phi_ddot()[drive.at.equation];
    w_[drive.y] =
        ((1 - c.alpha_f) * a_[drive.y] + c.alpha_f * start_a_[drive.y] - c.alpha_m * start_w_[drive.y]) /
        (1 - c.alpha_m);
  }
}

/// The block Zᵀ f Z of two parts; Z of coordinates in no loop is the identity.
void GlobalModesStepper::multiply(const Part& left, const Part& right) {
  const Index n = static_cast<Index>(left.coordinates.size()),
              m = static_cast<Index>(right.coordinates.size());
  const Index columns = left.motion ? left.Z.cols() : n, others = right.motion ? right.Z.cols() : m;
  // T = f Z of the right part, at the coordinates of the left one.
  double* T = work_.data();
  for (Index c = 0; c < others; ++c) {
    double* out = T + c * n;
    if (!right.motion) {
      const double* from = f_.col(right.coordinates[static_cast<std::size_t>(c)]).data();
      for (Index i = 0; i < n; ++i) out[i] = from[left.coordinates[static_cast<std::size_t>(i)]];
      continue;
    }
    for (Index i = 0; i < n; ++i) out[i] = 0;
  }
  if (right.motion)
    for (Index k = 0; k < m; ++k) {
      const double* from = f_.col(right.coordinates[static_cast<std::size_t>(k)]).data();
      double* column = column_.data();
      for (Index i = 0; i < n; ++i) column[i] = from[left.coordinates[static_cast<std::size_t>(i)]];
      for (Index c = 0; c < others; ++c) {
        const double by = right.Z(k, c);
        if (by == 0) continue;
        double* out = T + c * n;
        for (Index i = 0; i < n; ++i) out[i] += by * column[i];
      }
    }
  for (Index c = 0; c < others; ++c)
    for (Index r = 0; r < columns; ++r) {
      double sum = 0;
      if (left.motion) {
        const double *a = left.Z.col(r).data(), *b = T + c * n;
        for (Index i = 0; i < n; ++i) sum += a[i] * b[i];
      } else {
        sum = T[c * n + r];
      }
      matrix_(left.first + r, right.first + c) = sum;
      matrix_(right.first + c, left.first + r) = sum;
    }
}

void GlobalModesStepper::refactor(StepStatus& status) {
  ++status.factorisations;
  system_.dense_matrix(motion_.q.data(), weights_, f_.data());
  for (Part& part : parts_)
    if (part.motion) part.Z.bottomRows(part.Z.rows() - 1) = part.motion->Z();
  for (const auto& [left, right] : coupled_) multiply(parts_[left], parts_[right]);
  for (Index k = 0; k < size_; ++k)
    if (prescribed_[static_cast<std::size_t>(k)]) {
      matrix_.row(k).setZero();
      matrix_.col(k).setZero();
      matrix_(k, k) = 1;
    }
  factor_.compute(matrix_);
  matrix_step_ = options_.step;
}

/// The correction of y by r, and in `delta_` what that is of all coordinates.
bool GlobalModesStepper::correct(StepStatus& status) {
  reduce();
  reduced_ *= -motion_.scale;
  for (Index k = 0; k < size_; ++k)
    if (prescribed_[static_cast<std::size_t>(k)]) reduced_[k] = 0;
  factor_.solve_in_place(reduced_);
  delta_.setZero();
  for (std::size_t k = 0; k < free_.size(); ++k) delta_[free_[k]] = reduced_[static_cast<Index>(k)];
  system_.compose(full_.data(), delta_.data());
  for (std::size_t k = 0; k < free_.size(); ++k) x_[static_cast<Index>(k)] = full_[free_[k]];
  for (OfLoop& loop : loops_) {
    loop.motion.velocities(reduced_.data() + loop.first, delta_.data());
    for (int k = 0; k <= loop.motion.table().modes; ++k) x_[loop.first + k] += reduced_[loop.first + k];
  }
  status.correction = system_.scales().of_coordinates(delta_.data(), &status.coordinate);
  if (const int bad = find_not_finite(delta_.data(), system_.velocities()); bad >= 0) {
    status.coordinate = bad;
    return false;
  }
  return true;
}

StepStatus GlobalModesStepper::step(State& s) {
  if (!prepared_) prepare(s);
  StepStatus status;
  const auto fail = [&](StepCode code) {
    kept_ = false;
    status.code = code;
    return status;
  };
  system_.begin_step(s.q.data());
  // The start assembles another matrix.
  if (!s.started || matrix_step_ != options_.step) kept_ = false;
  if (const StepCode code = motion_.begin(s, status); code != StepCode::ok) return fail(code);
  read_start(s);
  if (const int off = find_off_table(s); off >= 0) {
    status.coordinate = off;
    return fail(StepCode::beyond_table);
  }
  predict();
  if (!expand(s, false, status)) return fail(StepCode::beyond_table);
  if (!drives_.empty()) {
    follow_drives(s);
    if (!expand(s, true, status)) return fail(StepCode::beyond_table);
  }
  NewtonProgress newton;
  bool converged = false;
  for (int iteration = 0; iteration < options_.max_iterations && !converged; ++iteration) {
    ++status.iterations;
    if (iteration > 0 && !expand(s, true, status)) return fail(StepCode::beyond_table);
    const bool held = iteration == 0 && system_.hold_sticking(true);
    system_.residual(s.time + motion_.h, motion_.q.data(), motion_.v.data(), motion_.a.data(), none_.data(),
                     0, r_.data());
    if (held) system_.hold_sticking(false);
    if (const int bad = find_not_finite(r_.data(), system_.velocities()); bad >= 0) {
      status.coordinate = bad;
      return fail(StepCode::not_finite);
    }
    const bool slow = newton.corrections > 1 && newton.rate > slow_by_matrix;
    const bool fresh = !kept_ || slow || system_.tangent_changed(motion_.q.data(), weights_);
    if (fresh) refactor(status);
    kept_ = true;
    if (!correct(status)) return fail(StepCode::not_finite);
    const double left = newton.add(status.correction, fresh);
    converged = !held &&
                left <= options_.tolerance * motion_.scale * system_.scales().accelerations(motion_.a.data());
  }
  if (!converged) return fail(StepCode::not_converged);
  if (!expand(s, true, status)) return fail(StepCode::beyond_table);
  const double end = s.time + motion_.h;
  if (drives_.empty())
    system_.kinematics(end, motion_.q.data(), motion_.v.data(), motion_.a.data());
  else
    system_.residual(end, motion_.q.data(), motion_.v.data(), motion_.a.data(), none_.data(), 0, r_.data());
  status.code = find_drift(system_, options_.drift_limit, status);
  if (status.code != StepCode::ok) return fail(status.code);
  accept(s);
  return status;
}

/// r along y, what forces and inertia leave.
void GlobalModesStepper::reduce() {
  for (std::size_t k = 0; k < free_.size(); ++k) reduced_[static_cast<Index>(k)] = r_[free_[k]];
  for (OfLoop& loop : loops_) loop.motion.project(r_.data(), reduced_.data() + loop.first);
}

/// The end of the step becomes the state. Of the multipliers those of drives are known: r is balanced by
/// them.
void GlobalModesStepper::accept(State& s) {
  motion_.accept(s, none_);
  if (!drives_.empty()) reduce();
  for (const OfDrive& drive : drives_)
    s.multipliers[drive.at.equation] = -reduced_[drive.y] / drive.at.factor;
  for (std::size_t k = 0; k < free_.size(); ++k) s.algorithmic[free_[k]] = w_[static_cast<Index>(k)];
  for (OfLoop& loop : loops_) {
    // Those of amplitudes are read again by what measures δ.
    loop.motion.velocities(w_.data() + loop.first, s.algorithmic.data());
    s.algorithmic[loop.motion.table().coordinate] = w_[loop.first];
  }
}

/// The matrix itself: it is small.
void GlobalModesStepper::transfer_matrix(StateTransfer& transfer) {
  transfer(kept_, matrix_step_, matrix_);
  if (transfer.restoring() && kept_) factor_.compute(matrix_);
}

}  // namespace mimbre
