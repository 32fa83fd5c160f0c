#pragma once
#include <Eigen/Core>
#include <vector>

#include "analysis/linear_point.h"

/// Axes in which the linear equations along a steady motion have constant coefficients: a rotor in round
/// bearings in axes that turn with it, a wheel that rolls in axes that do not.
namespace mimbre::linear {

/// ω about an axis that rests.
struct Turning {
  double speed = 0;             ///< rad/s; 0: the mechanism does not turn as one
  Vec3d axis = Vec3d::UnitX();  ///< global
  Vec3d place = Vec3d::Zero();  ///< of the axis, relative to the common point
};

/// All bodies have the angular velocity ω, and points of one axis along it rest. After system.kinematics().
Turning find_turning(const Compiled& model, const relative::RelativeSystem& system);

/// Increments and velocities in other axes.
using TurnedAxes = std::vector<TurnedVector>;

/// Places of floating joints, which are components in the ground's axes, in axes that turn with the
/// mechanism.
TurnedAxes axes_that_turn(const Compiled& model, const Turning& turning);
/// Rotations of joints with quaternions, which are components in the body's axes, in those of the body
/// before.
TurnedAxes axes_before_joints(const Compiled& model, const Eigen::VectorXd& v);

/// Ṫ of x = (y, s, z) at the point.
Eigen::MatrixXd turn_rate_of_states(const TurnedAxes& axes, const Linearised& at);
/// The largest change of A in these axes from the point to another one of its motion, a time later, with the
/// same independent coordinates.
double change_in_axes(const TurnedAxes& axes, const Linearised& at, double time, const Linearised& next);

/// The linear equations in these axes; shapes remain those of the instant.
void put_in_axes(const TurnedAxes& axes, Linearised& at);

}  // namespace mimbre::linear
