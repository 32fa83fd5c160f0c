#include "compile/elastodynamic_modes.h"

#include <fmt/format.h>

#include <stdexcept>

#include "math/once/decompositions.h"
#include "math/rotation.h"
#include "mimbre/diagnostics.h"
#include "mimbre/reduced_body.h"
#include "reduction/moved_modes.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Turns at joints count as displacements at this share of the body's size: they decide where places do not.
constexpr double of_turns = 1e-4;
// What is less than this share of a mode's own displacements is round-off.
constexpr double nothing = 1e-9;

/// Where joints hold the body: frames of its modes, -1 for its own frame.
std::vector<int> held_frames(const spec::Model& model, int body) {
  std::vector<int> held;
  for (const spec::Joint& joint : model.joints) {
    if (joint.type == spec::JointType::floating) continue;
    for (const int k : {joint.frame_a, joint.frame_b}) {
      const spec::Frame& frame = model.frames[static_cast<std::size_t>(k)];
      if (frame.body == body) held.push_back(frame.flexible_frame);
    }
  }
  return held;
}

/// For each mode the small rigid motion that brings the body's joints back, displacement and turn.
MatrixXd rigid_motion(const ReducedBody& body, const std::vector<int>& held) {
  double size = 1e-300;
  for (const BodyFrame& frame : body.frames) size = std::max(size, frame.position.norm());
  const auto rows = static_cast<Index>(6 * held.size());
  MatrixXd A = MatrixXd::Zero(rows, 6), b = MatrixXd::Zero(rows, body.modes);
  for (std::size_t k = 0; k < held.size(); ++k) {
    const auto r = static_cast<Index>(6 * k);
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    if (held[k] >= 0) {
      const BodyFrame& frame = body.frames[static_cast<std::size_t>(held[k])];
      place = frame.position;
      b.middleRows<3>(r) = -frame.X;
      b.middleRows<3>(r + 3) = -of_turns * size * frame.X_theta;
    }
    // Of the displacement, and of the turn times the size.
    A.block<3, 3>(r, 0).setIdentity();
    A.block<3, 3>(r, 3) = -skew<double>(place) / size;
    A.block<3, 3>(r + 3, 3) = of_turns * Eigen::Matrix3d::Identity();
  }
  MatrixXd motion = shortest_solution(A, b);
  motion.bottomRows<3>() /= size;
  return motion;
}

/// Whether it moves any frame by more than round-off of what the modes do.
bool moves(const ReducedBody& body, const MatrixXd& motion) {
  double own = 0, added = 0;
  for (const BodyFrame& frame : body.frames)
    for (Index k = 0; k < body.modes; ++k) {
      const Eigen::Vector3d t = motion.col(k).head<3>(), turn = motion.col(k).tail<3>();
      own = std::max(own, frame.X.col(k).norm());
      added = std::max(added, (t + turn.cross(frame.position)).norm());
    }
  return added > nothing * own;
}

}  // namespace

void set_elastodynamic_modes(spec::Model& model) {
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    spec::Body& body = model.bodies[k];
    if (!body.elastodynamic || !body.flexible || body.flexible->modes == 0) continue;
    const std::vector<int> held = held_frames(model, static_cast<int>(k));
    if (held.empty()) continue;
    const MatrixXd motion = rigid_motion(*body.flexible, held);
    if (!moves(*body.flexible, motion)) continue;
    ReducedBody moved = with_moved_modes(*body.flexible, motion);
    try {
      make_orthogonal(moved);
    } catch (const std::invalid_argument&) {
      throw InputError(body.mark,
                       fmt::format("body '{}': its modes do not deform it independently once its "
                                   "joints are held, as elastodynamics holds them; take other modes",
                                   body.name));
    }
    body.flexible = std::make_shared<const ReducedBody>(std::move(moved));
  }
}

}  // namespace mimbre
