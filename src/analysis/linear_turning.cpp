#include "analysis/linear_turning.h"

#include <cmath>

#include "joints/joint_kind.h"
#include "math/elementary.h"

namespace mimbre::linear {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Of the speed, and of the speed times the mechanism's size.
constexpr double same = 1e-9;

}  // namespace

Turning find_turning(const Compiled& m, const relative::RelativeSystem& system) {
  Turning out;
  const auto& bodies = system.workspace().bodies;
  if (bodies.empty() || bodies.size() != m.bodies.size()) return out;
  const Vec3d omega = bodies.front().omega;
  const double speed = omega.norm();
  if (!(speed > 0)) return out;
  const auto velocity_at_centre = [&](std::size_t k) {
    return Vec3d(bodies[k].velocity - bodies[k].omega.cross(bodies[k].position));
  };
  const Vec3d velocity = velocity_at_centre(0);
  const double small = same * speed * m.length_scale;
  if (std::abs(velocity.dot(omega)) > small * speed) return out;
  for (std::size_t k = 0; k < bodies.size(); ++k)
    if ((bodies[k].omega - omega).norm() > same * speed || (velocity_at_centre(k) - velocity).norm() > small)
      return out;
  out.speed = speed;
  out.axis = omega / speed;
  out.place = omega.cross(velocity) / (speed * speed);
  return out;
}

TurnedAxes axes_that_turn(const Compiled& m, const Turning& turning) {
  TurnedAxes out;
  if (!(turning.speed > 0)) return out;
  for (const BodyData& b : m.bodies) {
    if (b.parent >= 0 || b.reversed || b.joint != spec::JointType::floating) continue;
    const Mat3d& axes = m.frames[b.inboard_frame].rotation;
    out.push_back({b.v + (joint_info(b.joint).rotation == 0 ? 3 : 0),
                   -turning.speed * (axes.transpose() * turning.axis)});
  }
  return out;
}

TurnedAxes axes_before_joints(const Compiled& m, const VectorXd& v) {
  TurnedAxes out;
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    if (info.quaternion < 0) continue;
    const int first = b.v + info.rotation;
    if (const Vec3d rate = v.segment<3>(first); rate.norm() > 0) out.push_back({first, rate});
  }
  return out;
}

namespace {

/// Of increments N y and velocities V s + G y that a matrix turns, the independent rows: those of x by x.
MatrixXd of_states(const MatrixXd& turn, bool identity, const Linearised& at) {
  const Reduced& r = at.reduced;
  const Eigen::Index y = r.coordinates, s = r.speeds;
  MatrixXd out = MatrixXd::Zero(r.A.rows(), r.A.rows());
  if (identity) out.setIdentity();
  out.topLeftCorner(y, y) = (turn * r.position.leftCols(y))(at.independent, Eigen::all);
  out.block(y, 0, s, y + s) = (turn * r.velocity.leftCols(y + s))(at.moving, Eigen::all);
  return out;
}

}  // namespace

namespace {

/// T after the time, of all coordinates; `rate`: Ṫ.
MatrixXd turn(const TurnedAxes& axes, double time, Eigen::Index n, bool rate) {
  MatrixXd T = MatrixXd::Zero(n, n);
  if (!rate) T.setIdentity();
  for (const TurnedVector& x : axes) {
    const double angle = time * x.rate.norm();
    const Mat3d K = skew<double>(x.rate.normalized());
    const Mat3d R = Mat3d::Identity() + sin(angle) * K + (1 - cos(angle)) * K * K;
    T.block<3, 3>(x.first, x.first) = rate ? Mat3d(skew<double>(x.rate) * R) : R;
  }
  return T;
}

}  // namespace

/// Along the motion x = X x', X = rows of T⁻¹ (N, V, G) with those of the point, which are constant in these
/// axes: X A' = A X − Ẋ.
double change_in_axes(const TurnedAxes& axes, const Linearised& at, double time, const Linearised& next) {
  const Eigen::Index n = at.reduced.position.rows();
  const MatrixXd X = of_states(turn(axes, -time, n, false), true, at),
                 rate = of_states(turn(axes, -time, n, true), false, at),
                 here = at.reduced.A + turn_rate_of_states(axes, at);
  return (next.reduced.A * X + rate - X * here).cwiseAbs().maxCoeff();
}

MatrixXd turn_rate_of_states(const TurnedAxes& axes, const Linearised& at) {
  return of_states(turn(axes, 0, at.reduced.position.rows(), true), false, at);
}

/// With s = ẏ + W y and M ṡ + D s + L y = 0: what S adds to A is taken from W (of y), D and L (of s, by M).
void put_in_axes(const TurnedAxes& axes, Linearised& at) {
  Reduced& r = at.reduced;
  const MatrixXd S = turn_rate_of_states(axes, at);
  r.A += S;
  const Eigen::Index f = r.speeds;
  if (r.coordinates == r.speeds) {
    const MatrixXd N = r.position.leftCols(f), W = (at.derivatives.turn * N)(at.independent, Eigen::all);
    const MatrixXd D = r.damping - r.mass * W, L = r.stiffness - D * W;
    const MatrixXd W1 = W - S.topLeftCorner(f, f), D1 = D - r.mass * S.block(f, f, f, f),
                   L1 = L - r.mass * S.block(f, 0, f, f);
    r.damping = D1 + r.mass * W1;
    r.stiffness = L1 + D1 * W1;
  }
  for (const TurnedVector& x : axes)
    at.derivatives.turn.block<3, 3>(x.first, x.first) -= skew<double>(x.rate);
}

}  // namespace mimbre::linear
