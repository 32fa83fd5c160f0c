#pragma once
#include <array>

#include "outputs/contact.h"
#include "outputs/element.h"
#include "outputs/frame_angles.h"
#include "outputs/frame_displacement.h"
#include "outputs/frame_motion.h"
#include "outputs/joint_coordinates.h"
#include "outputs/joint_force.h"
#include "outputs/joint_turn.h"
#include "outputs/mass_motion.h"
#include "outputs/modal_amplitude.h"
#include "outputs/section_force.h"
#include "outputs/signal.h"
#include "outputs/spring.h"
#include "outputs/stress.h"
#include "outputs/tyre.h"

/// The kinds of outputs. A new one is a struct like Roll in frame_angles.h and its name in this list.
namespace mimbre::outputs {

template <class... Kinds>
struct KindList {};
/// In the order of SensorData::kind, in which messages list them.
using Kinds =
    KindList<Position, Velocity, Acceleration, AngularVelocity, AngularAcceleration, Roll, Pitch, Yaw,
             Deflection, Displacement, JointPosition, JointVelocity, JointAcceleration, JointRotation,
             JointQuaternion, JointForce, ModalAmplitude, Stress, Strain, SectionForce, CentreOfMass,
             LinearMomentum, AngularMomentum, SpringForce, SpringLength, TyreForce, TyreMoment, TyreSlip,
             TyreSlipAngle, TyreCamber, TyreDeflection, ContactForce, ContactDepth, ContactCount,
             ElementForce, ElementMeasure, ElementRate, SignalValue, InputValue>;

template <class... Kind>
constexpr std::array<const OutputInfo*, sizeof...(Kind)> infos_of(KindList<Kind...>) {
  return {&Kind::info...};
}
inline constexpr auto infos = infos_of(Kinds());

template <class T>
using SensorFunction = T (*)(const SensorData&, const SensorView<T>&);

/// Null: signals may not use it within a step.
template <class T, class Kind>
constexpr SensorFunction<T> sensor_function() {
  static_assert(
      requires { &Kind::template seen<T>; } == (Kind::info.place_sensor != nullptr),
      "an output has both, where its sensor is placed and what it sees, or none");
  if constexpr (requires { &Kind::template seen<T>; })
    return Kind::template seen<T>;
  else
    return nullptr;
}
template <class T, class... Kind>
constexpr std::array<SensorFunction<T>, sizeof...(Kind)> sensor_functions_of(KindList<Kind...>) {
  return {sensor_function<T, Kind>()...};
}
template <class T>
constexpr auto sensor_functions = sensor_functions_of<T>(Kinds());

}  // namespace mimbre::outputs
