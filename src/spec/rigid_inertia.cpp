#include "spec/rigid_inertia.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <vector>

#include "joints/joint_kind.h"
#include "math/once/decompositions.h"
#include "spec/check/checked_item.h"

namespace mimbre {
namespace {

using Eigen::Vector3d;

constexpr double file_rounding = 1e-6;  ///< of figures in files

/// How a body can turn: its angular velocity is 0, along an axis, or any.
struct Turning {
  enum Kind { none, axis, any } kind = any;
  Vector3d along = Vector3d::Zero();  ///< global; constant, since nothing turns it
};

/// Of what a joint carries on something that turns as `carrier` does.
Turning carried(const Turning& carrier, const spec::Model& model, const spec::Joint& joint) {
  if (joint.apart || carrier.kind == Turning::any) return {};
  const JointInfo& info = joint_info(joint.type);
  if (info.rotations() == 0) return carrier;
  if (info.rotations() > 1) return {};
  const spec::Frame& frame = model.frames[static_cast<std::size_t>(joint.frame_a)];
  Vector3d z = frame.pose.rotation.col(2);
  if (frame.body >= 0) z = model.bodies[static_cast<std::size_t>(frame.body)].pose.rotation * z;
  if (carrier.kind == Turning::axis && z.cross(carrier.along).norm() > file_rounding) return {};
  return {Turning::axis, z};
}

/// By the path of joints to the ground that leaves the least freedom. Flexible bodies may turn anyhow.
Turning turning_of(const spec::Model& model, std::size_t wanted) {
  std::vector<Turning> bodies(model.bodies.size());
  const auto body_of = [&](int frame) { return model.frames[static_cast<std::size_t>(frame)].body; };
  const auto of = [&](int body) {
    return body < 0 ? Turning{Turning::none, Vector3d::Zero()} : bodies[static_cast<std::size_t>(body)];
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (const spec::Joint& joint : model.joints) {
      if (!checks::sound_frame(model, joint.frame_a) || !checks::sound_frame(model, joint.frame_b)) continue;
      const int a = body_of(joint.frame_a), b = body_of(joint.frame_b);
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
        if (to < 0 || model.bodies[static_cast<std::size_t>(to)].flexible) continue;
        const Turning turning = carried(of(from), model, joint);
        if (turning.kind >= of(to).kind) continue;
        bodies[static_cast<std::size_t>(to)] = turning;
        changed = true;
      }
    }
  }
  return bodies[wanted];
}

std::string moments_text(const Vector3d& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v[0], v[1], v[2]);
}

}  // namespace

std::optional<InertiaFault> inertia_fault(const spec::Model& model, std::size_t number) {
  const spec::Body& body = model.bodies[number];
  const Eigen::Matrix3d& J = body.inertia;
  if (body.mass == 0) {
    if (J.isZero(0)) return {};
    return InertiaFault{"the mass is 0 but the inertia is not; make both 0 or none", ""};
  }
  const double size = J.cwiseAbs().maxCoeff();
  const Vector3d I = eigenvalues3(J);
  InertiaFault fault;
  if (I[0] < -file_rounding * size)
    fault.what =
        fmt::format("is not positive definite: principal moments {}; none can be negative", moments_text(I));
  else if (I[0] + I[1] < I[2] * (1 - file_rounding))
    fault.what = fmt::format(
        "breaks the triangle inequality: principal moments {}, but no body has one larger than "
        "the sum of the others",
        moments_text(I));
  else
    return {};
  const Turning turning = turning_of(model, number);
  if (turning.kind == Turning::none) {
    fault.harmless = "the body cannot turn";
  } else if (turning.kind == Turning::axis) {
    const Vector3d axis = body.pose.rotation.transpose() * turning.along;
    const double moment = axis.dot(J * axis);
    if (moment >= 0)
      fault.harmless =
          fmt::format("the body turns about one direction only, about which it has {:.4g} kg m²", moment);
  }
  return fault;
}

}  // namespace mimbre
