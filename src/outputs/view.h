#pragma once
#include <array>

#include "compile/compiled.h"
#include "forces/element.h"
#include "forces/motion.h"

/// What outputs see of a mechanism.
namespace mimbre {

/// Coordinates of a joint as joint_motion() takes them (quaternions w, x, y, z; those of a cut joint follow
/// from its frames, angles within ±π), their rates, and the rates of these.
struct JointCoordinates {
  std::array<double, 7> positions{};
  std::array<double, 6> rates{}, accelerations{};
};

/// Force and moment about the joint's point that a joint exerts on its second body, what springs and drives
/// in it do included.
struct JointReaction {
  Vec3d force, moment;              ///< global axes
  Vec3d force_joint, moment_joint;  ///< axes of the joint's frame on its second body
};

/// Of bodies, as one body has it.
struct MassMotion {
  Vec3d centre;   ///< of mass, relative to the origin
  Vec3d linear;   ///< kg m/s
  Vec3d angular;  ///< about the centre of mass, kg m²/s
};

/// What the pairs of a contact that touch do, in sum.
struct ContactSum {
  Vec3d force = Vec3d::Zero();        ///< N, global axes
  double normal = 0, tangential = 0;  ///< N, of the magnitudes
  double depth = 0;                   ///< m, the largest
  int count = 0;
};

/// A state that has been evaluated as far as an output needs. Frames, joints and contacts are those of the
/// spec, elements and bodies those of the compiled model.
class OutputView {
 public:
  OutputView(const Compiled& m, const Eigen::VectorXd& q) : model(m), q(q) {}
  virtual ~OutputView() = default;

  const Compiled& model;
  const Eigen::VectorXd& q;  ///< relative coordinates

  /// The common point, m.
  virtual Vec3d origin() const = 0;
  /// Positions relative to the origin.
  virtual Motion<double> motion(int frame) const = 0;
  /// Of a flexible frame, body axes, m.
  virtual Vec3d deflection(int frame) const = 0;
  virtual JointCoordinates coordinates(int joint) const = 0;
  /// Of the bodies of the output.
  virtual MassMotion mass_motion() const = 0;

  // After forces.
  virtual ElementState<const double> element(int element) const = 0;
  /// Of all pairs of a contact, or of those that press on a body.
  virtual ContactSum contact(int contact, int body) const = 0;
  virtual double slot(int slot) const = 0;

  // After reactions.
  virtual JointReaction reaction(int joint) const = 0;
  /// N, Vy, Vz, T, My, Mz (N, N m) of a section of a body of the spec that is made of bars.
  virtual Eigen::Matrix<double, 6, 1> section_forces(int body, int section) const = 0;

  const spec::Model& spec() const { return model.spec(); }
  /// Of a flexible body of the spec.
  auto amplitudes(int body) const {
    const BodyData& b = model.bodies[model.body_of_spec[body]];
    return q.segment(b.q + b.joint_positions, b.modes);
  }
};

/// What signals see of the motion within an evaluation of a step: sensors are those of the compiled model.
template <class T>
class SensorView {
 public:
  virtual ~SensorView() = default;
  virtual const Vec3<T>& origin() const = 0;
  virtual Motion<T> motion(int frame) const = 0;
  /// What an element measures, and its rate.
  virtual T measure(int element, int component) const = 0;
  virtual T rate(int element, int component) const = 0;
  virtual const T* amplitudes(int body) const = 0;
};

/// Σ shapes[k] y[k].
template <class T>
T seen_amplitudes(const SensorData& d, const SensorView<T>& view) {
  if (d.shapes.empty()) return T(0);
  const T* y = view.amplitudes(d.body);
  T sum(0);
  for (std::size_t k = 0; k < d.shapes.size(); ++k) sum += d.shapes[k] * y[k];
  return sum;
}

}  // namespace mimbre
