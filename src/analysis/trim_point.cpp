#include "analysis/trim_point.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "analysis/linear_point.h"
#include "dynamics/relative/forces.h"
#include "integrate/initial.h"
#include "joints/joint_kind.h"
#include "math/elementary.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"
#include "mimbre/diagnostics.h"
#include "simulation/step/signal_state.h"

namespace mimbre::linear {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

namespace {

// Shares of the scales of coordinates, velocities and accelerations.
constexpr double trim_step = 1e-10;     ///< of the last step
constexpr double trim_balanced = 1e-7;  ///< of accelerations
constexpr double trim_furthest = 0.3;   ///< of positions in one step
constexpr double trim_turning = 1e-6;   ///< of the largest rate: a joint turns
constexpr double trim_degenerate = 1e-9;
constexpr double trim_uneven = 1e-4;  ///< of accelerations, further on
constexpr int trim_rounds = 60;
/// Steps are halved so often, and taken from so many on where forces are finite at all.
constexpr int trim_halvings = 12, trim_patience = 8;
/// In which states of force elements settle, of the mechanism's own time.
constexpr double settling_time = 1e5;

/// A body on a floating joint to the ground.
struct Rover {
  int body = 0;
  int position = 0, rotation = 0;  ///< first velocity coordinates
  int quaternion = 0;              ///< in q
  Vec3d up;                        ///< in the axes of the joint's frame on the ground
  Vec3d to_origin;                 ///< of the body, from the joint's frame on it, in that frame's axes
};

std::vector<Rover> rovers_of(const Compiled& m, const Vec3d& up) {
  std::vector<Rover> out;
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {
    const BodyData& b = m.bodies[k];
    if (b.parent >= 0 || b.reversed || b.joint != spec::JointType::floating) continue;
    const JointInfo& info = joint_info(b.joint);
    const FrameData& on_body = m.frames[b.outboard_frame];
    out.push_back({static_cast<int>(k), b.v + (info.rotation == 0 ? 3 : 0), b.v + info.rotation,
                   b.q + info.quaternion, m.frames[b.inboard_frame].rotation.transpose() * up,
                   -(on_body.rotation.transpose() * on_body.position)});
  }
  return out;
}

const std::string& name_of_body(const Compiled& m, int body) {
  return m.spec().bodies[static_cast<std::size_t>(m.bodies[static_cast<std::size_t>(body)].spec)].name;
}

/// The body that is asked for, or without a name any where there is `no_other`, may be on a floating joint
/// that is written the other way.
void refuse_reversed(const Compiled& m, const std::string& wanted, bool no_other) {
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {
    const BodyData& b = m.bodies[k];
    if (b.parent >= 0 || !b.reversed || b.joint != spec::JointType::floating) continue;
    const std::string& name = name_of_body(m, static_cast<int>(k));
    if (wanted.empty() ? !no_other : name != wanted) continue;
    const spec::Joint& joint = m.spec().joints[static_cast<std::size_t>(b.joint_spec)];
    throw InputError(joint.mark,
                     fmt::format("steady driving: the floating joint '{}' goes from the body to the ground; "
                                 "write it from the ground to the body, `between: [ground, {}]`, with its "
                                 "velocities at the start in that sense",
                                 joint.name, name));
  }
}

class TrimSearch {
 public:
  TrimSearch(const Compiled& m, relative::RelativeSystem& system, const State& start,
             const std::map<std::string, double>& inputs, const TrimConditions& conditions);
  /// From the start.
  Trim run();
  /// From a neighbour.
  Trim run_from(const DrivingState& near);

 private:
  /// Values and derivatives by (y, s, z, u; Ω) of what has to vanish.
  struct Equations {
    MatrixXd by;
    VectorXd values;
    VectorXd accelerations;
  };

  /// Rows of the equations: derivatives by the unknowns and, last, by the yaw rate; and what is left.
  struct Rows {
    std::vector<RowVectorXd> by;
    std::vector<double> values;
    void add(const RowVectorXd& row, double by_rate, double value, double scale) {
      RowVectorXd all(row.size() + 1);
      all << row, by_rate;
      by.push_back(all / scale);
      values.push_back(value / scale);
    }
  };

  /// Where the search is.
  struct Iterate {
    Linearised linear;
    std::map<std::string, double> inputs;
    double yaw_rate = 0;
    Equations equations;
  };
  /// Newton's equations there, along units of the unknowns (none: they stay) and with rows of length one.
  struct Newton {
    VectorXd unit, sizes;
    MatrixXd inverse;            ///< of the equations, which are solved more than once
    std::vector<Index> columns;  ///< of the inputs that are looked for
    VectorXd solve(const VectorXd& values) const;
  };

  Mat3d axes(const Rover& r, const State& s) const;
  Vec3d upright(const Rover& r, const State& s) const;
  Vec3d origin_velocity(const Rover& r, const State& s) const;
  Vec3d along(const Rover& r, const State& s) const;
  double coordinate_scale(int k) const { return scales_.coordinates[static_cast<std::size_t>(k)]; }
  /// `as`: with its independent coordinates.
  Linearised at(const State& s, const std::map<std::string, double>& inputs, const Linearised* as = nullptr);
  void settle(State& s) const;
  void set_inputs(const std::map<std::string, double>& inputs, State& s) const;
  /// A rover goes around the vertical with the yaw rate W.
  void circle(const Rover& c, const Linearised& l, double W, Rows& rows) const;
  /// All else stays.
  void stay(const Linearised& l, const std::vector<char>& done, Rows& rows) const;
  /// What is wanted holds.
  void wanted(const Linearised& l, double W, Rows& rows) const;
  Equations equations(const Linearised& l, double yaw_rate) const;
  Newton newton(Iterate& at);
  Iterate moved(const Iterate& from, const Newton& newton, const VectorXd& x, double share);
  bool improve(Iterate& at);
  double further_on(const Iterate& at);
  /// What drives prescribe, and loops closed.
  void close(State& s);
  Iterate begin(const State& s, std::map<std::string, double> inputs, double yaw_rate);
  Trim search(Iterate at);

  const Compiled& m_;
  relative::RelativeSystem& system_;
  const Scales& scales_;
  const TrimConditions& wanted_;
  State start_;
  std::map<std::string, double> inputs_;
  Vec3d up_;
  std::vector<Rover> rovers_;
  std::size_t main_ = 0;     ///< of rovers_
  std::vector<char> turns_;  ///< by velocity coordinate
  std::vector<int> found_;   ///< inputs
  double pace_ = 1, speed_ = 0;
};

TrimSearch::TrimSearch(const Compiled& m, relative::RelativeSystem& system, const State& start,
                       const std::map<std::string, double>& inputs, const TrimConditions& conditions)
    : m_(m),
      system_(system),
      scales_(system.scales()),
      wanted_(conditions),
      start_(start),
      inputs_(inputs),
      up_(m.gravity.norm() > 0 ? Vec3d(-m.gravity.normalized()) : Vec3d(Vec3d::UnitZ())),
      rovers_(rovers_of(m, up_)),
      turns_(static_cast<std::size_t>(m.velocities), 0) {
  const auto refuse = [&](const std::string& text) { return InputError(Mark{m.spec().file, 0, 0}, text); };
  refuse_reversed(m, wanted_.body, rovers_.empty());
  if (rovers_.empty())
    throw refuse(
        "steady driving: no body is on a floating joint to the ground; for what turns about fixed axes use "
        "the point 'steady'");
  if (!wanted_.body.empty()) {
    const auto found = std::find_if(rovers_.begin(), rovers_.end(),
                                    [&](const Rover& r) { return name_of_body(m, r.body) == wanted_.body; });
    if (found == rovers_.end()) {
      std::vector<std::string> names;
      for (const Rover& r : rovers_) names.push_back(name_of_body(m, r.body));
      throw refuse(
          fmt::format("steady driving: body '{}' is not on a floating joint to the ground; these are: {}",
                      wanted_.body, fmt::join(names, ", ")));
    }
    main_ = static_cast<std::size_t>(found - rovers_.begin());
  }
  const int turns =
      (wanted_.lateral_acceleration ? 1 : 0) + (wanted_.radius ? 1 : 0) + (wanted_.yaw_rate ? 1 : 0);
  if (turns > 1) throw refuse("steady driving: give one of lateral acceleration, radius and yaw rate");
  if (wanted_.radius && *wanted_.radius == 0) throw refuse("steady driving: a radius of 0");
  const int conditions_given = turns + (wanted_.speed ? 1 : 0);
  if (conditions_given != static_cast<int>(wanted_.find.size()))
    throw refuse(
        fmt::format("steady driving: {} condition{} of speed and turn, and {} input{} to find: as many are "
                    "needed, such as the steering for a turn and the throttle for a speed",
                    conditions_given, conditions_given == 1 ? "" : "s", wanted_.find.size(),
                    wanted_.find.size() == 1 ? "" : "s"));
  for (const std::string& name : wanted_.find) {
    const int input = find_input(m, name);
    if (std::find(found_.begin(), found_.end(), input) != found_.end())
      throw refuse(fmt::format("steady driving: the input '{}' is to be found twice", name));
    found_.push_back(input);
  }
  for (const int input : found_) {
    const spec::Input& of = m.spec().inputs[static_cast<std::size_t>(input)];
    if (!inputs_.contains(of.name)) inputs_[of.name] = held_input_value(m, input, start_);
  }
  const Rover& r = rovers_[main_];
  const double drawn = along(r, start_).norm();
  if (!(drawn > 0))
    throw refuse(
        fmt::format("steady driving: body '{}' stands at the start; give it a velocity, and its wheels the "
                    "rates that belong to it",
                    name_of_body(m, r.body)));
  speed_ = wanted_.speed.value_or(drawn);
  if (!(speed_ > 0) || !std::isfinite(speed_))
    throw refuse(fmt::format("steady driving: a speed of {} m/s", speed_));
  double fastest = 0;
  for (int k = 0; k < m.velocities; ++k)
    fastest = std::max(fastest, std::abs(start_.v[k]) / scales_.coordinates[static_cast<std::size_t>(k)]);
  for (const BodyData& b : m.bodies) {
    if (b.joint == spec::JointType::floating && b.parent < 0) continue;
    for (int k = 0; k < b.joint_velocities; ++k)
      if (is_angle(b.joint, k) && std::abs(start_.v[b.v + k]) > trim_turning * fastest)
        turns_[static_cast<std::size_t>(b.v + k)] = 1;
  }
  start_.v *= speed_ / drawn;
  pace_ = std::max(speed_ / m.length_scale, scales_.acceleration > 0 ? std::sqrt(scales_.acceleration) : 0.0);
}

/// From the axes of the joint's frame on the body to those of its frame on the ground, as all below.
Mat3d TrimSearch::axes(const Rover& r, const State& s) const {
  return rotation_matrix<double>(Quat<double>(s.q.segment<4>(r.quaternion)));
}

/// The vertical in the axes of the joint's frame on the body.
Vec3d TrimSearch::upright(const Rover& r, const State& s) const { return axes(r, s).transpose() * r.up; }

/// Velocity of the body's origin.
Vec3d TrimSearch::origin_velocity(const Rover& r, const State& s) const {
  const Vec3d spin = s.v.segment<3>(r.rotation);
  return s.v.segment<3>(r.position) + axes(r, s) * spin.cross(r.to_origin);
}

/// The part of it across the vertical.
Vec3d TrimSearch::along(const Rover& r, const State& s) const {
  const Vec3d v = origin_velocity(r, s);
  return v - r.up * r.up.dot(v);
}

/// States of force elements where they stay at this motion, by two steps that are very long.
void TrimSearch::settle(State& s) const {
  VectorXd generalised(m_.velocities);
  for (int twice = 0; twice < 2; ++twice) {
    system_.enter(s.u.data(), s.z.data(), settling_time / pace_);
    system_.begin_step(s.q.data());
    system_.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
    relative::forces(m_, system_.workspace(), s.time, s.q.data(), s.v.data(), s.a.data(), generalised.data());
    for (const ElementData& e : m_.elements) {
      if (e.state_count == 0 || e.user) continue;
      const ElementState<double> is = element_state(e, system_.workspace().elements.data());
      bool finite = true;
      for (int k = 0; k < e.state_count; ++k) finite = finite && std::isfinite(is.states[k]);
      if (finite) std::copy_n(is.states, e.state_count, s.z.data() + e.states);
    }
  }
  system_.enter(s.u.data(), s.z.data(), 0);
}

void TrimSearch::set_inputs(const std::map<std::string, double>& inputs, State& s) const {
  State fresh;
  start_signals(m_, inputs, fresh);
  // On the way a value may be out of its range.
  for (const SignalsData::HeldInput& h : m_.signals.held)
    if (std::find(found_.begin(), found_.end(), h.input) != found_.end()) {
      const double value = inputs.at(m_.spec().inputs[static_cast<std::size_t>(h.input)].name);
      fresh.u[h.held] = value;
      if (h.linear) fresh.u[h.held + 2] = value;
    }
  s.u = fresh.u;
}

Linearised TrimSearch::at(const State& s, const std::map<std::string, double>& inputs, const Linearised* as) {
  Linearised l;
  if (as) {
    l.independent = as->independent;
    l.moving = as->moving;
  }
  l.state = s;
  set_inputs(inputs, l.state);
  commit(m_, system_, l.state);
  settle(l.state);
  commit(m_, system_, l.state);
  linearise_state(m_, system_, l);
  return l;
}

void TrimSearch::circle(const Rover& c, const Linearised& l, double W, Rows& rows) const {
  const Reduced& r = l.reduced;
  const State& s = l.state;
  const double L = m_.length_scale;
  const Vec3d v = s.v.segment<3>(c.position), omega = s.v.segment<3>(c.rotation), n = upright(c, s),
              a = s.a.segment<3>(c.position), alpha = s.a.segment<3>(c.rotation);
  const MatrixXd V = r.velocity.middleRows(c.position, 3), turned = r.position.middleRows(c.rotation, 3),
                 spin = r.velocity.middleRows(c.rotation, 3), A = r.acceleration.middleRows(c.position, 3),
                 spin_rate = r.acceleration.middleRows(c.rotation, 3);
  rows.add(c.up.transpose() * V, 0, c.up.dot(v), L * pace_);
  // ω = Ω n, and n turns with the body: δn = −δθ × n.
  const MatrixXd rotation = spin - W * (skew<double>(n) * turned);
  const Vec3d off = omega - W * n;
  const MatrixXd turning = A - W * (skew<double>(c.up) * V);
  const Vec3d round = c.up.cross(v), wrong = a - W * round;
  for (int k = 0; k < 3; ++k) {
    rows.add(rotation.row(k), -n[k], off[k], pace_);
    rows.add(turning.row(k), -round[k], wrong[k], L * pace_ * pace_);
    rows.add(spin_rate.row(k), 0, alpha[k], pace_ * pace_);
  }
}

void TrimSearch::stay(const Linearised& l, const std::vector<char>& done, Rows& rows) const {
  const Reduced& r = l.reduced;
  const State& s = l.state;
  for (const int k : l.independent) {
    const auto i = static_cast<std::size_t>(k);
    if (done[i]) continue;
    const double scale = scales_.coordinates[i];
    if (!turns_[i]) rows.add(r.velocity.row(k), 0, s.v[k], scale * pace_);
    rows.add(r.acceleration.row(k), 0, s.a[k], scale * pace_ * pace_);
  }
  const int first = r.first_state();
  for (int k = 0; k < r.states; ++k) {
    if (l.parameters[static_cast<std::size_t>(k)].kind == Parameter::Kind::integral) continue;
    RowVectorXd by(r.position.cols());
    by << r.A.row(first + k), r.B.row(first + k);
    const double size = by.cwiseAbs().maxCoeff();
    // By what moves it in the mechanism's own time; where nothing does, as at a limit of its rate, there is
    // the row all the same: rows are those of every point.
    rows.add(by, 0, l.state_rates[k], size > 0 ? size : pace_);
  }
}

void TrimSearch::wanted(const Linearised& l, double W, Rows& rows) const {
  const Reduced& r = l.reduced;
  const State& s = l.state;
  const double L = m_.length_scale;
  const Rover& c = rovers_[main_];
  const Vec3d ahead = along(c, s), spin = s.v.segment<3>(c.rotation);
  const double speed = ahead.norm();
  const Mat3d A = axes(c, s);
  const MatrixXd origin = r.velocity.middleRows(c.position, 3) -
                          A * skew<double>(c.to_origin) * r.velocity.middleRows(c.rotation, 3) -
                          A * skew<double>(spin.cross(c.to_origin)) * r.position.middleRows(c.rotation, 3);
  const RowVectorXd by_speed = (ahead / speed).transpose() * origin;
  const RowVectorXd none = RowVectorXd::Zero(r.position.cols());
  if (wanted_.speed) rows.add(by_speed, 0, speed - speed_, L * pace_);
  if (wanted_.lateral_acceleration)
    rows.add(W * by_speed, speed, W * speed - *wanted_.lateral_acceleration, L * pace_ * pace_);
  if (wanted_.yaw_rate) rows.add(none, 1, W - *wanted_.yaw_rate, pace_);
  if (wanted_.radius)
    rows.add(by_speed, -*wanted_.radius, speed - W * *wanted_.radius,
             std::max(L, std::abs(*wanted_.radius)) * pace_);
}

TrimSearch::Equations TrimSearch::equations(const Linearised& l, double yaw_rate) const {
  if (l.reduced.coordinates != l.reduced.speeds)
    throw std::runtime_error("steady driving of models with constraints on velocities alone is not possible");
  const State& s = l.state;
  Rows rows;
  std::vector<char> done(static_cast<std::size_t>(m_.velocities), 0);
  Equations out;
  out.accelerations = VectorXd::Zero(m_.velocities);
  for (const Rover& c : rovers_) {
    for (int k = 0; k < 3; ++k)
      done[static_cast<std::size_t>(c.position + k)] = done[static_cast<std::size_t>(c.rotation + k)] = 1;
    circle(c, l, yaw_rate, rows);
    out.accelerations.segment<3>(c.position) = yaw_rate * c.up.cross(Vec3d(s.v.segment<3>(c.position)));
  }
  stay(l, done, rows);
  wanted(l, yaw_rate, rows);
  out.by.resize(std::ssize(rows.by), l.reduced.position.cols() + 1);
  out.values.resize(std::ssize(rows.by));
  for (std::size_t k = 0; k < rows.by.size(); ++k) {
    out.by.row(static_cast<Index>(k)) = rows.by[k];
    out.values[static_cast<Index>(k)] = rows.values[k];
  }
  return out;
}

VectorXd TrimSearch::Newton::solve(const VectorXd& values) const {
  return inverse * -sizes.cwiseProduct(values);
}

TrimSearch::Newton TrimSearch::newton(Iterate& at) {
  const Linearised& l = at.linear;
  const Reduced& r = l.reduced;
  MatrixXd& by = at.equations.by;
  const Index all = r.position.cols(), first = r.first_state();
  Newton out;
  // Units of the unknowns; inputs that are not looked for stay.
  VectorXd& unit = out.unit = VectorXd::Zero(all + 1);
  for (int k = 0; k < r.coordinates; ++k)
    unit[k] = coordinate_scale(l.independent[static_cast<std::size_t>(k)]);
  for (int k = 0; k < r.speeds; ++k)
    unit[r.coordinates + k] = pace_ * coordinate_scale(l.moving[static_cast<std::size_t>(k)]);
  for (Index k = first; k < first + r.states; ++k) {
    const double acts = by.col(k).cwiseAbs().maxCoeff();
    unit[k] = acts > 0 ? 1 / acts : 1;
  }
  for (const int input : found_)
    for (std::size_t p = 0; p < l.parameters.size(); ++p) {
      if (l.parameters[p].kind != Parameter::Kind::input || l.parameters[p].item != input) continue;
      const Index column = first + static_cast<Index>(p);
      out.columns.push_back(column);
      const double acts = by.col(column).cwiseAbs().maxCoeff();
      if (!(acts > 0))
        throw std::runtime_error(fmt::format("steady driving: the input '{}' moves nothing",
                                             m_.spec().inputs[static_cast<std::size_t>(input)].name));
      unit[column] = 1 / acts;
    }
  unit[all] = pace_;
  MatrixXd scaled = MatrixXd::Zero(by.rows(), all + 1);
  for (Index k = 0; k <= all; ++k)
    if (unit[k] > 0) scaled.col(k) = unit[k] * by.col(k);
  // Rows of stiff parts are no larger than others, so that none of them seems to depend on others.
  out.sizes = scaled.rowwise().norm();
  for (double& size : out.sizes) size = size > 0 ? 1 / size : 0;
  out.inverse = pseudo_inverse(out.sizes.asDiagonal() * scaled, trim_degenerate);
  return out;
}

void TrimSearch::close(State& s) {
  system_.enter(s.u.data(), s.z.data(), 0);
  system_.begin_step(s.q.data());
  if (m_.equations == 0) return;
  const VectorXd ready = Eigen::Map<const VectorXd>(scales_.coordinates.data(), m_.velocities);
  close_positions(system_, s.time, ready, s.q);
  close_velocities(system_, s.time, s.q, ready, s.v);
}

/// The point by the share of a step of the unknowns x.
TrimSearch::Iterate TrimSearch::moved(const Iterate& from, const Newton& newton, const VectorXd& x,
                                      double share) {
  const Linearised& l = from.linear;
  const Reduced& r = l.reduced;
  const Index all = r.position.cols(), first = r.first_state();
  State next = l.state;
  const VectorXd step = share * (r.position * x.head(all));
  system_.retract(l.state.q.data(), step.data(), next.q.data());
  next.v += share * (r.velocity * x.head(all));
  for (int k = 0; k < r.states; ++k) {
    const Parameter& p = l.parameters[static_cast<std::size_t>(k)];
    if (p.kind != Parameter::Kind::element_state) continue;
    const LinearElement& of = l.elements[static_cast<std::size_t>(p.item)];
    next.z[m_.elements[static_cast<std::size_t>(of.element)].states +
           of.states[static_cast<std::size_t>(p.index)]] += share * x[first + k];
  }
  Iterate out;
  out.inputs = from.inputs;
  for (std::size_t k = 0; k < found_.size(); ++k)
    out.inputs[m_.spec().inputs[static_cast<std::size_t>(found_[k])].name] += share * x[newton.columns[k]];
  set_inputs(out.inputs, next);
  close(next);
  out.linear = at(next, out.inputs, &l);
  out.yaw_rate = from.yaw_rate + share * x[all];
  out.equations = equations(out.linear, out.yaw_rate);
  return out;
}

/// One step; whether it was the last. Stiff parts have large accelerations where little is wrong: steps are
/// compared, not those (Deuflhard 2004).
bool TrimSearch::improve(Iterate& at) {
  const Newton equations = newton(at);
  const Reduced& r = at.linear.reduced;
  const Index first = r.first_state(), coordinates = r.coordinates, speeds = r.speeds, states = r.states;
  const auto without_states = [&](VectorXd scaled) {
    scaled.segment(first, states).setZero();
    return scaled;
  };
  const VectorXd solution = equations.solve(at.equations.values), x = equations.unit.cwiseProduct(solution),
                 scaled = without_states(solution);
  if (!x.allFinite()) throw std::runtime_error("no steady driving was found: forces are not finite");
  const VectorXd dq = r.position * x.head(r.position.cols());
  const double length = scales_.of_coordinates(dq.data()), before = scaled.norm(),
               moves = scaled.head(coordinates + speeds).cwiseAbs().maxCoeff();
  double share = length > trim_furthest ? trim_furthest / length : 1;
  bool changes = false;
  for (int halving = 0; halving <= trim_halvings; ++halving, share /= 2) {
    Iterate next = moved(at, equations, x, share);
    if (next.equations.values.size() != equations.sizes.size()) {
      changes = true;  // such as a tyre that lifts
      continue;
    }
    const double now = without_states(equations.solve(next.equations.values)).norm();
    const bool small = share * length < 1e-6;
    if (!std::isfinite(now) || !(now < (1 - share / 4) * before || small || halving >= trim_patience))
      continue;
    at = std::move(next);
    return share == 1 && (moves < trim_step || (moves < 1e-7 && now >= 0.5 * before));
  }
  throw std::runtime_error(changes
                               ? "no steady driving was found: force elements gain and lose states on the way"
                               : "no steady driving was found: forces are not finite");
}

/// Of the accelerations at play, what is left where the mechanism stands a little further along its path.
double TrimSearch::further_on(const Iterate& at) {
  State s = at.linear.state;
  for (const Rover& c : rovers_) {
    const Vec3d ahead = along(c, s);
    if (!(ahead.norm() > 0)) continue;
    VectorXd step = VectorXd::Zero(m_.velocities);
    step.segment<3>(c.position) = 1.7 * m_.length_scale * ahead.normalized();
    system_.retract(s.q.data(), step.data(), s.q.data());
  }
  return equations(this->at(s, at.inputs, &at.linear), at.yaw_rate).values.cwiseAbs().maxCoeff();
}

TrimSearch::Iterate TrimSearch::begin(const State& s, std::map<std::string, double> inputs, double yaw_rate) {
  Iterate out;
  out.inputs = std::move(inputs);
  out.yaw_rate = yaw_rate;
  out.linear = at(s, out.inputs);
  out.equations = equations(out.linear, out.yaw_rate);
  return out;
}

Trim TrimSearch::run() {
  const double yaw_rate = wanted_.yaw_rate               ? *wanted_.yaw_rate
                          : wanted_.lateral_acceleration ? *wanted_.lateral_acceleration / speed_
                          : wanted_.radius               ? speed_ / *wanted_.radius
                                                         : 0;
  return search(begin(start_, inputs_, yaw_rate));
}

Trim TrimSearch::run_from(const DrivingState& near) {
  State s = start_;
  if (near.positions.size() != s.q.size() || near.velocities.size() != s.v.size() ||
      near.element_states.size() != s.z.size())
    throw std::runtime_error(
        "no steady driving was found: the model has other coordinates than its neighbour");
  const double faster = wanted_.speed && near.speed > 0 ? speed_ / near.speed : 1;
  s.q = near.positions;
  s.v = faster * near.velocities;
  s.z = near.element_states;
  std::map<std::string, double> inputs = inputs_;
  for (const int input : found_) {
    const std::string& name = m_.spec().inputs[static_cast<std::size_t>(input)].name;
    if (const auto known = near.inputs.find(name); known != near.inputs.end()) inputs[name] = known->second;
  }
  set_inputs(inputs, s);
  close(s);
  return search(begin(s, std::move(inputs), faster * near.yaw_rate));
}

Trim TrimSearch::search(Iterate at) {
  Trim out;
  bool done = false;
  while (!done && out.iterations < trim_rounds) {
    done = improve(at);
    ++out.iterations;
  }
  out.residual = at.equations.values.cwiseAbs().maxCoeff();
  if (!done || !(out.residual <= trim_balanced))
    throw std::runtime_error(
        fmt::format("no steady driving was found: after {} iterations {:.2g} of the accelerations at play "
                    "are left; start near it, with "
                    "velocities that belong together, or ask for less",
                    out.iterations, out.residual));
  for (const int input : found_) {
    const spec::Input& of = m_.spec().inputs[static_cast<std::size_t>(input)];
    const double value = at.inputs[of.name];
    if (value < of.min || value > of.max)
      throw std::runtime_error(
          fmt::format("steady driving needs '{}' = {:.6g}, which is out of its range of {:g} to {:g}",
                      of.name, value, of.min, of.max));
  }
  if (const double left = further_on(at); !(left <= trim_uneven))
    throw std::runtime_error(
        fmt::format("no steady driving: the road is not level and even; a little further on {:.2g} of the "
                    "accelerations at play are left",
                    left));
  out.state = at.linear.state;
  out.body = rovers_[main_].body;
  out.yaw_rate = at.yaw_rate;
  out.up = up_;
  out.inputs = at.inputs;
  out.accelerations = at.equations.accelerations;
  const Rover& c = rovers_[main_];
  const Vec3d velocity = along(c, out.state);
  out.speed = velocity.norm();
  const Mat3d body_axes =
      axes(c, out.state) *
      m_.frames[m_.bodies[static_cast<std::size_t>(c.body)].outboard_frame].rotation.transpose();
  const Vec3d ahead = body_axes.col(0), level = ahead - c.up * c.up.dot(ahead);
  out.sideslip = mimbre::atan2(c.up.dot(level.cross(velocity)), level.dot(velocity));
  return out;
}

}  // namespace

Trim find_trim(const Compiled& m, relative::RelativeSystem& system, const State& start,
               const std::map<std::string, double>& inputs, const TrimConditions& conditions,
               const DrivingState* near) {
  TrimSearch search(m, system, start, inputs, conditions);
  if (!near) return search.run();
  try {
    return search.run_from(*near);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error&) {
    return search.run();
  }
}

}  // namespace mimbre::linear
