#include "urdf/joint_inertia.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/random_numbers.h"
#include "math/cross_matrix.h"
#include "math/once/decompositions.h"
#include "math/turn.h"

namespace mimbre::urdf {
namespace {

constexpr int positions = 8;
constexpr double no_inertia = 1e-12;  ///< of what moves

Spatial turn(const Eigen::Vector3d& axis, const Eigen::Vector3d& point) {
  Spatial motion;
  motion << axis, point.cross(axis);
  return motion;
}
Spatial slide(const Eigen::Vector3d& direction) {
  Spatial motion;
  motion << Eigen::Vector3d::Zero(), direction;
  return motion;
}

}  // namespace

double start_of(const Joint& joint) {
  const bool outside = joint.lower && !(*joint.lower <= 0 && *joint.upper >= 0);
  return outside ? 0.5 * (*joint.lower + *joint.upper) : 0;
}

BodyTree::BodyTree(const Robot& robot, const MergedRobot& merged, bool floating)
    : robot_(robot), merged_(merged), floating_(floating) {
  for (const MergedBody& body : merged.bodies) {
    const int holder = robot.held_by[static_cast<std::size_t>(body.link)];
    joint_.push_back(holder);
    carrier_.push_back(holder < 0 ? -1
                                  : merged.body_of[static_cast<std::size_t>(
                                        robot.joints[static_cast<std::size_t>(holder)].parent)]);
    first_.push_back(motions_);
    motions_ += static_cast<int>(motions(first_.size() - 1, body.pose).size());
    size_ = std::max(
        size_, (body.com - merged.links[static_cast<std::size_t>(robot.order.front())].position).norm());
  }
  for (const Pose& link : merged.links)
    size_ = std::max(
        size_, (link.position - merged.links[static_cast<std::size_t>(robot.order.front())].position).norm());
  for (const Joint& joint : robot.joints) {
    int leader = -1;
    for (std::size_t k = 0; joint.mimic && k < robot.joints.size(); ++k)
      if (robot.joints[k].name == joint.mimic->joint) leader = static_cast<int>(k);
    leader_.push_back(leader);
    start_.push_back(start_of(joint));
  }
  follow(start_);
}

void BodyTree::follow(std::vector<double>& coordinates) const {
  // A chain of followers takes a round for each of its joints; a ring of them ends, too.
  for (std::size_t round = 0; round < coordinates.size(); ++round)
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      if (leader_[k] >= 0)
        coordinates[k] =
            robot_.joints[k].mimic->multiplier * coordinates[static_cast<std::size_t>(leader_[k])] +
            robot_.joints[k].mimic->offset;
}

std::vector<Spatial> BodyTree::motions(std::size_t body, const Pose& pose) const {
  const Eigen::Vector3d& p = pose.position;
  std::vector<Spatial> all;
  const auto turns = [&] {
    for (int k = 0; k < 3; ++k) all.push_back(turn(Eigen::Vector3d::Unit(k), p));
  };
  const auto slides = [&] {
    for (int k = 0; k < 3; ++k) all.push_back(slide(Eigen::Vector3d::Unit(k)));
  };
  if (joint_[body] < 0) {
    if (floating_) turns(), slides();
    return all;
  }
  const Joint& joint = robot_.joints[static_cast<std::size_t>(joint_[body])];
  const Eigen::Vector3d axis = pose.rotation * joint.axis;
  switch (joint.type) {
    case Joint::Type::fixed:
      break;
    case Joint::Type::revolute:
    case Joint::Type::continuous:
      return {turn(axis, p)};
    case Joint::Type::prismatic:
      return {slide(axis)};
    case Joint::Type::spherical:
      turns();
      break;
    case Joint::Type::floating:
      turns(), slides();
      break;
    case Joint::Type::planar: {
      const Eigen::Vector3d along = axis.unitOrthogonal();
      return {turn(axis, p), slide(along), slide(axis.cross(along))};
    }
  }
  return all;
}

SpatialInertia BodyTree::inertia(const MergedBody& body, const Pose& pose) const {
  const Eigen::Vector3d c =
      pose.position + pose.rotation * (body.pose.rotation.transpose() * (body.com - body.pose.position));
  const Eigen::Matrix3d J = pose.rotation * body.inertia * pose.rotation.transpose(),
                        mc = body.mass * cross_matrix(c);
  SpatialInertia I;
  I << J - mc * cross_matrix(c), mc, -mc, body.mass * Eigen::Matrix3d::Identity();
  return I;
}

BodyTree::Position BodyTree::at(const std::vector<double>& coordinates) const {
  Position position;
  for (std::size_t k = 0; k < merged_.bodies.size(); ++k) {
    const MergedBody& body = merged_.bodies[k];
    Pose pose = body.pose;
    if (carrier_[k] >= 0) {
      const Pose& drawn = merged_.bodies[static_cast<std::size_t>(carrier_[k])].pose;
      const Pose inner{drawn.rotation.transpose() * (pose.position - drawn.position),
                       drawn.rotation.transpose() * pose.rotation};
      const Joint& joint = robot_.joints[static_cast<std::size_t>(joint_[k])];
      const double q = joint.scalar() ? coordinates[static_cast<std::size_t>(joint_[k])] : 0;
      Pose moved;
      if (joint.turns())
        moved.rotation = turn_about(joint.axis, q);
      else if (joint.scalar())
        moved.position = q * joint.axis;
      pose = position.poses[static_cast<std::size_t>(carrier_[k])].of(inner).of(moved);
    }
    position.poses.push_back(pose);
    position.inertias.push_back(inertia(body, pose));
  }
  return position;
}

Eigen::MatrixXd BodyTree::mass_matrix(const Position& position) const {
  std::vector<SpatialInertia> composite = position.inertias;
  std::vector<std::vector<Spatial>> moves;
  for (std::size_t k = 0; k < composite.size(); ++k) moves.push_back(motions(k, position.poses[k]));
  for (std::size_t k = composite.size(); k-- > 1;)
    composite[static_cast<std::size_t>(carrier_[k])] += composite[k];
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(motions_, motions_);
  for (std::size_t k = 0; k < composite.size(); ++k)
    for (std::size_t column = 0; column < moves[k].size(); ++column) {
      const Spatial momentum = composite[k] * moves[k][column];
      const auto c = static_cast<Eigen::Index>(first_[k]) + static_cast<Eigen::Index>(column);
      for (int body = static_cast<int>(k); body >= 0; body = carrier_[static_cast<std::size_t>(body)])
        for (std::size_t row = 0; row < moves[static_cast<std::size_t>(body)].size(); ++row) {
          const auto r = static_cast<Eigen::Index>(first_[static_cast<std::size_t>(body)]) +
                         static_cast<Eigen::Index>(row);
          M(r, c) = M(c, r) = moves[static_cast<std::size_t>(body)][row].dot(momentum);
        }
    }
  return M;
}

Eigen::MatrixXd BodyTree::independent() const {
  std::vector<int> body_of(robot_.joints.size(), -1);
  for (std::size_t k = 0; k < joint_.size(); ++k)
    if (joint_[k] >= 0) body_of[static_cast<std::size_t>(joint_[k])] = static_cast<int>(k);
  Eigen::MatrixXd all = Eigen::MatrixXd::Identity(motions_, motions_);
  std::vector<bool> follows(static_cast<std::size_t>(motions_), false);
  for (std::size_t k = 0; k < leader_.size(); ++k) {
    if (leader_[k] < 0 || body_of[k] < 0) continue;
    // Along the chain to what follows none.
    double factor = 1;
    std::size_t joint = k, rounds = 0;
    for (; leader_[joint] >= 0 && rounds <= leader_.size(); ++rounds) {
      factor *= robot_.joints[joint].mimic->multiplier;
      joint = static_cast<std::size_t>(leader_[joint]);
    }
    if (rounds > leader_.size() || body_of[joint] < 0) continue;
    const int own = first_[static_cast<std::size_t>(body_of[k])];
    all.row(own).setZero();
    all(own, first_[static_cast<std::size_t>(body_of[joint])]) = factor;
    follows[static_cast<std::size_t>(own)] = true;
  }
  Eigen::MatrixXd columns(motions_, std::count(follows.begin(), follows.end(), false));
  for (Eigen::Index k = 0, to = 0; k < motions_; ++k)
    if (!follows[static_cast<std::size_t>(k)]) columns.col(to++) = all.col(k);
  return columns;
}

std::vector<double> BodyTree::effective(const std::vector<double>& coordinates) const {
  std::vector<double> result(robot_.joints.size(), 0);
  const Eigen::MatrixXd T = independent();
  const Eigen::MatrixXd M = T.transpose() * mass_matrix(at(coordinates)) * T;
  const Cholesky factor(M);
  if (!factor.ok()) return result;
  for (std::size_t k = 0; k < joint_.size(); ++k) {
    if (joint_[k] < 0 || !robot_.joints[static_cast<std::size_t>(joint_[k])].scalar()) continue;
    const Eigen::VectorXd row = T.row(first_[k]).transpose();
    const Eigen::VectorXd half = factor.solve_lower(row);
    const double mobility = half.squaredNorm();
    if (mobility > 0 && std::isfinite(1 / mobility))
      result[static_cast<std::size_t>(joint_[k])] = 1 / mobility;
  }
  return result;
}

std::vector<double> BodyTree::least_inertias() const {
  std::vector<double> least = effective(start_);
  for (int position = 1; position < positions; ++position) {
    std::vector<double> coordinates = start_;
    for (std::size_t k = 0; k < coordinates.size(); ++k) {
      const Joint& joint = robot_.joints[k];
      const double place = uniform_at(static_cast<std::uint64_t>(position), k);
      if (joint.lower)
        coordinates[k] = *joint.lower + place * (*joint.upper - *joint.lower);
      else if (joint.turns())
        coordinates[k] = EIGEN_PI * (2 * place - 1);
    }
    follow(coordinates);
    const std::vector<double> here = effective(coordinates);
    for (std::size_t k = 0; k < least.size(); ++k)
      if (here[k] > 0 && (least[k] == 0 || here[k] < least[k])) least[k] = here[k];
  }
  return least;
}

void BodyTree::find_massless_motions(const Massless& massless) const {
  const Position position = at(start_);
  const std::size_t count = merged_.bodies.size();
  // Of what hangs on each body and moves freely; and of that held rigidly, whose size round-off is of.
  std::vector<SpatialInertia> hanging(count, SpatialInertia::Zero()), composite = hanging;
  for (std::size_t k = count; k-- > 0;) {
    const std::vector<Spatial> moves = motions(k, position.poses[k]);
    SpatialInertia left, whole;
    for (int attempt = 0; attempt < 2; ++attempt) {
      const SpatialInertia own = inertia(merged_.bodies[k], position.poses[k]);
      left = own + hanging[k], whole = own + composite[k];
      bool good = true;
      for (const Spatial& move : moves) {
        const Spatial momentum = left * move;
        const double pivot = move.dot(momentum), mass = whole(5, 5);
        const double scale = move.head<3>().isZero(0) ? mass : mass * size_ * size_;
        if (pivot > no_inertia * std::max(scale, move.dot(whole * move)))
          left -= momentum * momentum.transpose() / pivot;
        else
          good = false;
      }
      if (good || attempt > 0 || !massless(k)) break;
    }
    if (carrier_[k] < 0) continue;
    hanging[static_cast<std::size_t>(carrier_[k])] += left;
    composite[static_cast<std::size_t>(carrier_[k])] += whole;
  }
}

}  // namespace mimbre::urdf
