#include "mimbre/kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/driven_motion.h"
#include "analysis/observed_rows.h"
#include "joints/joint_kind.h"
#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"
#include "simulation/start/assembly.h"
#include "simulation/start/redundancy.h"
#include "simulation/step/signal_state.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = SpecialPosition::Kind;

constexpr double dependent_rows = 1e-9;  ///< of equations, by their scales
constexpr double singular_share =
    1e-6;                              ///< of the least singular value, as a share of the largest on the way
constexpr double near_singular = 0.3;  ///< likewise: minima above are not looked at
constexpr double at_singular = 1e-4;   ///< likewise, where it is that of round-off
constexpr double arrival = 0.02;       ///< of the way there, from where velocities are known
constexpr double shortest_part = 1e-11;  ///< part of the whole time, of the search for a limit
constexpr double resting = 1e-9;         ///< of rates, as a share of the largest

class Walk {
 public:
  Walk(const std::shared_ptr<const Model>& model, const KinematicsOptions& options)
      : m_(model->compiled()),
        options_(options),
        system_(m_),
        motion_(system_, std::vector<char>(static_cast<std::size_t>(m_.equations), 1)),
        rows_(m_, false) {
    for (const BodyData& b : m_.bodies) {
      const JointInfo& info = joint_info(b.joint);
      const int scalars = info.quaternion < 0 ? info.velocities : info.rotation;
      for (int k = 0; k < scalars; ++k)
        if (b.joint_spec >= 0) coordinates_.push_back({{b.joint_spec, k}, b.q + k, b.v + k});
      joint_columns_.push_back({b.v, b.joint_velocities});
    }
    for (const SignalsData::Computed& made : m_.signals.fixed) {
      if (made.block < 0) continue;
      const SignalsData::Block& block = m_.signals.blocks[made.block];
      if (block.every > 0) continue;
      remembers_.resize(m_.signals.start.size());
      std::fill_n(remembers_.begin() + block.held, block.memory(), 1);
      std::fill_n(remembers_.begin() + m_.signals.clock, 2, 1);
    }
    has_memory_ = !remembers_.empty() || !m_.states.empty();
  }

  Kinematics follow();

 private:
  struct Coordinate {
    JointCoordinate of;
    int q, v;
  };

  /// The state at the first instant. Throws InputError where the drives do not lead there.
  State begin(double end);
  /// What the mechanism can do, and the names of the columns.
  void describe(const State& first, double end, Kinematics& out);
  /// The states at all instants from s on, as far as the loops close: complete, or until s.
  std::vector<State> steps(State& s, double end, bool& complete);
  void record(const std::vector<State>& states, Kinematics& out);
  /// The Jacobian of the joints' coordinates: modes stay.
  MatrixXd of_joints(const MatrixXd& jacobian) const {
    MatrixXd out = jacobian;
    for (const BodyData& b : m_.bodies) out.middleCols(b.v + b.joint_velocities, b.modes).setZero();
    return out;
  }
  int joint_velocities() const {
    int sum = 0;
    for (const auto& [first, count] : joint_columns_) sum += count;
    return sum;
  }
  /// The singular value by which the generic rank ends, and the motion that belongs to it.
  double least_value(const State& s, VectorXd* motion = nullptr);
  void count(const State& s, Kinematics& out);
  bool go(State& s, double to);
  bool go_at_once(State& s, double to);
  void arrive(const State& from, State& to);
  /// Evaluations are of what this state remembers from here on, h after it.
  void enter(const State& s, double h);
  /// Turns are counted from here on, and blocks of the time that drives may follow remember the instant.
  void remember(State& s);
  /// Between two instants, which are followed from a state; blocks go forwards only.
  void look_for_singular(const State& from, double begin, double end, Kinematics& out);
  void look_for_reversals(const std::vector<State>& states, Kinematics& out);
  void look_for_reversal(const State& before, const State& after, const Coordinate& of, double largest,
                         Kinematics& out);
  void add(Kind kind, const State& s, const JointCoordinate& of, double position, Kinematics& out);
  void limit(const State& s, Kinematics& out);

  const Compiled& m_;
  const KinematicsOptions& options_;
  relative::RelativeSystem system_;
  DrivenMotion motion_;
  ObservedRows rows_;
  std::vector<Coordinate> coordinates_;
  std::vector<std::pair<int, int>> joint_columns_;
  int rank_ = 0;                 ///< of the Jacobian with drives
  double regular_ = 0;           ///< the largest least singular value so far
  bool arriving_ = false;        ///< next to a singular position
  std::vector<char> remembers_;  ///< by number of State::u: it is a block's of the time
  bool has_memory_ = false;      ///< these, or laws and constraints, remember something
  VectorXd u_, z_;               ///< that are entered
};

double Walk::least_value(const State& s, VectorXd* motion) {
  const MatrixXd jacobian = of_joints(motion_.jacobian(s));
  if (rank_ == 0) return 1;
  const EigenPairs pairs = symmetric_eigen(jacobian.transpose() * jacobian);
  const Eigen::Index at = jacobian.cols() - rank_;
  if (motion) *motion = pairs.vectors.col(at);
  return std::sqrt(std::max(0.0, pairs.values[at]));
}

void Walk::count(const State& s, Kinematics& out) {
  const MatrixXd all = of_joints(motion_.jacobian(s));
  MatrixXd loops = all;
  for (const DriveData& d : m_.drives) loops.row(d.equation).setZero();
  const auto rank = [](const MatrixXd& jacobian) {
    if (jacobian.size() == 0 || jacobian.cwiseAbs().maxCoeff() < dependent_rows) return 0;
    return order_columns(jacobian.transpose(), dependent_rows).rank;
  };
  rank_ = rank(all);
  const int columns = joint_velocities();
  out.coordinates = columns;
  out.drives = static_cast<int>(m_.drives.size());
  out.equations = m_.equations - out.drives;
  out.mobility = columns - rank(loops);
  out.free = columns - rank_;
  if (out.free == 0) return;
  MatrixXd held = all;  // modes stay
  MatrixXd N;
  if (rank_ == 0)
    N = MatrixXd::Identity(m_.velocities, m_.velocities);
  else
    N = null_space(held, dependent_rows);
  std::set<std::string> names;
  for (std::size_t b = 0; b < m_.bodies.size(); ++b) {
    const auto& [first, size] = joint_columns_[b];
    if (size > 0 && N.middleRows(first, size).cwiseAbs().maxCoeff() > 1e-6)
      names.insert(m_.spec().joints[static_cast<std::size_t>(m_.bodies[b].joint_spec)].name);
  }
  out.free_joints.assign(names.begin(), names.end());
}

void Walk::enter(const State& s, double h) {
  u_ = s.u;
  z_ = s.z;
  system_.enter(u_.data(), z_.data(), h);
}

void Walk::remember(State& s) {
  if (!m_.states.empty()) {
    const VectorXd none = VectorXd::Zero(m_.equations);
    VectorXd r(m_.velocities);
    system_.residual(s.time, s.q.data(), s.v.data(), s.a.data(), none.data(), 0, r.data());
    system_.keep_turns(s.z.data());
  }
  if (!remembers_.empty()) {
    const VectorXd before = s.u;
    commit_blocks(m_, system_, s);
    for (Eigen::Index k = 0; k < s.u.size(); ++k)
      if (!remembers_[static_cast<std::size_t>(k)]) s.u[k] = before[k];
  }
  if (has_memory_) enter(s, 0);
}

/// From the state to another instant; false, and the state stays, where the loops do not close near it.
/// Blocks are followed by steps of the model.
bool Walk::go(State& s, double to) {
  const double parts =
      remembers_.empty() ? 1 : std::ceil((to - s.time) / m_.spec().simulation.step * (1 - 1e-9));
  if (!(parts > 1)) return go_at_once(s, to);
  State next = s;
  for (int k = 1; k <= static_cast<int>(parts); ++k)
    if (!go_at_once(next, s.time + (to - s.time) * k / parts)) return false;
  s = next;
  return true;
}

bool Walk::go_at_once(State& s, double to) {
  const double h = to - s.time, half = s.time + 0.5 * h;
  if (has_memory_) enter(s, h);
  const VectorXd x = h * s.v + 0.5 * h * h * s.a;
  const double moved = system_.scales().of_coordinates(x.data());
  const auto leads = [&](double share) {
    State next = s;
    system_.retract(s.q.data(), VectorXd(share * x).data(), next.q.data());
    next.time = to;
    if (!motion_.close(next) || motion_.change() > 0.05 + 0.5 * share * moved) return false;
    if (rank_ > 0 && h > 0 && !arriving_ && least_value(next) < at_singular * regular_) arrive(s, next);
    remember(next);
    s = next;
    return true;
  };
  if (moved < most_moved && leads(1)) return true;
  // From a dead centre, where accelerations have no bounds, a part of what they predict.
  for (const double part : {0.4, 0.1, 0.03, 0.01, 0.003})
    if (part < moved && leads(part / moved)) return true;
  // Far ones in parts.
  if (moved < most_moved || !std::isfinite(moved) || !((half - s.time) * (to - half) > 0)) return false;
  State next = s;
  if (!go_at_once(next, half) || !go_at_once(next, to)) return false;
  s = next;
  return true;
}

/// In a singular position the equations do not determine velocities: they are those of the way there.
void Walk::arrive(const State& from, State& to) {
  arriving_ = true;
  State before = from, there;
  const double left = arrival * (to.time - from.time);
  if (go_at_once(before, to.time - left)) {
    there = before;
    const VectorXd x = left * before.v + 0.5 * left * left * before.a;
    system_.retract(before.q.data(), x.data(), there.q.data());
    there.v += left * before.a;
    there.time = to.time;
    if (motion_.arrive(there)) to = there;
  }
  if (has_memory_) enter(from, to.time - from.time);
  arriving_ = false;
}

void Walk::add(Kind kind, const State& s, const JointCoordinate& of, double position, Kinematics& out) {
  SpecialPosition found;
  found.kind = kind;
  found.time = s.time;
  found.of = of;
  found.position = position;
  if (!m_.drives.empty()) found.driven = s.q[m_.drives.front().q];
  const std::string name = coordinate_text(m_.spec(), of);
  found.joint = name;
  const char* unit =
      is_angle(m_.spec().joints[static_cast<std::size_t>(of.joint)].type, of.coordinate) ? "rad" : "m";
  switch (kind) {
    case Kind::dead_centre:
      found.text = fmt::format(
          "dead centre at t = {:.9g} s: the drives do not determine the motion; '{}' could "
          "move at {:.9g} {} while they stand still",
          s.time, name, position, unit);
      break;
    case Kind::change_point:
      found.text = fmt::format(
          "change point at t = {:.9g} s: the loops leave a motion more, in which '{}' "
          "takes part at {:.9g} {}; the mechanism can go on in another way",
          s.time, name, position, unit);
      break;
    case Kind::limit:
      found.text = fmt::format(
          "limit at t = {:.9g} s: the drive of '{}' cannot go beyond {:.9g} {}, where the "
          "loops do not close",
          s.time, name, position, unit);
      break;
    case Kind::reversal:
      found.text =
          fmt::format("'{}' turns back at t = {:.9g} s, at {:.9g} {}: a dead centre of a drive there", name,
                      s.time, position, unit);
      break;
  }
  out.special.push_back(std::move(found));
}

/// The least singular value is least somewhere between these instants.
void Walk::look_for_singular(const State& from, double begin, double end, Kinematics& out) {
  const double width = 0.5 * (end - begin);
  const auto at = [&](double time, State& s) {
    s = from;
    return time == from.time || go(s, time) ? least_value(s) : least_value(from);
  };
  constexpr double golden = 0.6180339887498949;
  double low = begin, high = end;
  State s;
  double left = high - golden * (high - low), right = low + golden * (high - low);
  double of_left = at(left, s), of_right = at(right, s);
  while (high - low > 1e-9 * width) {
    if (of_left < of_right) {
      high = right;
      right = left;
      of_right = of_left;
      left = high - golden * (high - low);
      of_left = at(left, s);
    } else {
      low = left;
      left = right;
      of_left = of_right;
      right = low + golden * (high - low);
      of_right = at(right, s);
    }
  }
  VectorXd motion;
  // An instant of the rows may be one.
  const double found = at((low + high) / 2, s);
  if (from.time >= begin && least_value(from) <= found) s = from;
  const double least = least_value(s, &motion);
  if (!(least <= singular_share * out.regularity.maxCoeff())) return;
  // Of the loops alone, too?
  MatrixXd loops = of_joints(motion_.jacobian(s));
  for (const DriveData& d : m_.drives) loops.row(d.equation).setZero();
  const bool change = loops.cwiseAbs().maxCoeff() > dependent_rows &&
                      joint_velocities() - order_columns(loops.transpose(), 1e-5).rank > out.mobility;
  const Coordinate* of = nullptr;
  for (const Coordinate& c : coordinates_)
    if (!of || std::abs(motion[c.v]) > std::abs(motion[of->v]) + 1e-9) of = &c;
  if (of) add(change ? Kind::change_point : Kind::dead_centre, s, of->of, s.q[of->q], out);
}

/// From the last instant at which a coordinate moved to the next one at which it moves back.
void Walk::look_for_reversals(const std::vector<State>& states, Kinematics& out) {
  double largest = 0;
  for (const State& s : states) largest = std::max(largest, system_.scales().of_coordinates(s.v.data()));
  for (const Coordinate& c : coordinates_) {
    if (std::any_of(m_.drives.begin(), m_.drives.end(), [&](const DriveData& d) { return d.v == c.v; }))
      continue;
    const double floor = resting * largest * motion_.scale()[c.v];
    const State* before = nullptr;
    for (const State& after : states) {
      if (std::abs(after.v[c.v]) <= floor) continue;
      if (before && before->v[c.v] * after.v[c.v] < 0) look_for_reversal(*before, after, c, largest, out);
      before = &after;
    }
  }
}

void Walk::look_for_reversal(const State& before, const State& after, const Coordinate& c, double largest,
                             Kinematics& out) {
  State low = before, high = after;
  for (int k = 0; k < 60 && high.time - low.time > 1e-13 * std::max(1.0, high.time); ++k) {
    State middle = low;
    if (!go(middle, (low.time + high.time) / 2)) break;
    (middle.v[c.v] * before.v[c.v] > 0 ? low : high) = middle;
  }
  // Where drives stand still too, it is they who turn back.
  bool drives_move = false;
  for (const DriveData& d : m_.drives)
    drives_move = drives_move || std::abs(low.v[d.v]) > 1e-6 * largest * motion_.scale()[d.v];
  if (drives_move) add(Kind::reversal, low, c.of, low.q[c.q], out);
}

void Walk::limit(const State& s, Kinematics& out) {
  // The drive that moves fastest.
  const DriveData* drive = nullptr;
  const auto speed = [&](const DriveData& d) { return std::abs(s.v[d.v]) / motion_.scale()[d.v]; };
  for (const DriveData& d : m_.drives)
    if (!drive || speed(d) > speed(*drive)) drive = &d;
  if (drive) add(Kind::limit, s, {drive->joint_spec, drive->local}, s.q[drive->q], out);
}

State Walk::begin(double end) {
  if (!(options_.steps >= 1)) throw InputError(Mark{}, "steps must be at least 1");
  if (!(options_.start >= 0) || !(end >= options_.start) || !std::isfinite(end))
    throw InputError(Mark{}, fmt::format("the motion goes from {} to {} s; it starts at 0 or later and ends "
                                         "after that",
                                         options_.start, end));
  State s = assembled_state(m_, system_, options_.inputs);
  // To the start by steps, as far as that goes.
  bool moving = motion_.close(s);
  remember(s);
  for (int k = 1; moving && options_.start > 0 && k <= 100; ++k) moving = go(s, options_.start * k / 100);
  if (!moving)
    throw InputError({m_.spec().file, 0, 0},
                     fmt::format("the drives cannot be followed to t = {} s, where the motion starts: the "
                                 "loops do not close beyond t = {:.6g} s",
                                 options_.start, s.time));
  return s;
}

void Walk::describe(const State& s, double end, Kinematics& out) {
  count(s, out);
  // A position in between: at the start several may be singular.
  State other = s;
  if (go(other, options_.start + 0.317 * (end - options_.start) / options_.steps)) {
    Kinematics there;
    const int rank = rank_;
    count(other, there);
    if (rank_ < rank) {
      rank_ = rank;
    } else {
      out.mobility = there.mobility;
      out.free = there.free;
      out.free_joints = there.free_joints;
    }
  }
  const Redundancy redundancy = find_redundancy(system_, s);
  out.redundant = redundancy.equations;
  out.redundant_names = redundancy.joints;
  out.redundant_names.insert(out.redundant_names.end(), redundancy.constraints.begin(),
                             redundancy.constraints.end());
  for (const Coordinate& c : coordinates_) out.names.push_back(coordinate_text(m_.spec(), c.of));
  out.header = rows_.header("");
  if (out.free > 0)
    out.warnings.push_back(
        fmt::format("{} independent motion{} no drive prescribes; {} moves as little as "
                    "possible",
                    out.free, out.free > 1 ? "s" : "", out.free_joints.empty() ? "it" : "what is concerned"));
}

std::vector<State> Walk::steps(State& s, double end, bool& complete) {
  std::vector<State> states{s};
  const double h = (end - options_.start) / options_.steps;
  for (int k = 1; k <= options_.steps && h > 0; ++k) {
    regular_ = std::max(regular_, least_value(s));
    const double to = options_.start + h * k;
    double part = h;
    while (s.time < to && complete) {
      if (go(s, std::min(to, s.time + part))) {
        part *= 2;
        continue;
      }
      part /= 2;
      complete = part > shortest_part * (end - options_.start);
    }
    if (!complete) break;
    s.time = to;
    states.push_back(s);
  }
  return states;
}

void Walk::record(const std::vector<State>& states, Kinematics& out) {
  const auto count = static_cast<Eigen::Index>(states.size());
  out.time.resize(count);
  out.regularity.resize(count);
  for (MatrixXd* x : {&out.position, &out.velocity, &out.acceleration})
    x->resize(count, static_cast<Eigen::Index>(coordinates_.size()));
  for (Eigen::Index k = 0; k < count; ++k) {
    const State& now = states[static_cast<std::size_t>(k)];
    out.time[k] = now.time;
    out.regularity[k] = least_value(now);
    for (std::size_t c = 0; c < coordinates_.size(); ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      out.position(k, column) = now.q[coordinates_[c].q];
      out.velocity(k, column) = now.v[coordinates_[c].v];
      out.acceleration(k, column) = now.a[coordinates_[c].v];
    }
    if (has_memory_) enter(now, 0);
    system_.begin_step(now.q.data());
    system_.kinematics(now.time, now.q.data(), now.v.data(), now.a.data());
    out.rows.push_back(rows_.row(system_, now));
  }
}

Kinematics Walk::follow() {
  Kinematics out;
  const double end = options_.end.value_or(m_.spec().simulation.end);
  State s = begin(end);
  describe(s, end, out);
  const std::vector<State> states = steps(s, end, out.complete);
  record(states, out);
  const auto count = std::ssize(states);
  const double h = (end - options_.start) / options_.steps;
  const double largest = out.regularity.maxCoeff();
  for (Eigen::Index k = 0; k < count; ++k) {
    const double here = out.regularity[k];
    const bool falls = k == 0 || here <= out.regularity[k - 1],
               rises = k + 1 == count || here < out.regularity[k + 1];
    if (falls && rises && here < near_singular * largest)
      look_for_singular(
          states[static_cast<std::size_t>(remembers_.empty() || k == 0 ? k : k - 1)],
          k == 0 && !remembers_.empty() ? options_.start : states[static_cast<std::size_t>(k)].time - h,
          remembers_.empty() ? states[static_cast<std::size_t>(k)].time + h
                             : std::min(end, states[static_cast<std::size_t>(k)].time + h),
          out);
  }
  look_for_reversals(states, out);
  if (!out.complete) limit(s, out);
  std::stable_sort(out.special.begin(), out.special.end(),
                   [](const SpecialPosition& a, const SpecialPosition& b) { return a.time < b.time; });
  return out;
}

}  // namespace

Kinematics kinematics(const std::shared_ptr<const Model>& model, const KinematicsOptions& options) {
  return Walk(model, options).follow();
}

}  // namespace mimbre
