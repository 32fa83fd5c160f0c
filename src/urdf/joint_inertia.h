#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "urdf/merged.h"

/// The inertia that a robot's joints move. Spatial vectors are about the global origin, angular parts first
/// (Featherstone, Rigid Body Dynamics Algorithms, 2008).
namespace mimbre::urdf {

using Spatial = Eigen::Matrix<double, 6, 1>;
using SpatialInertia = Eigen::Matrix<double, 6, 6>;

/// The bodies of a robot as a tree whose joints move.
class BodyTree {
 public:
  /// `floating`: the root moves freely; else the ground holds it.
  BodyTree(const Robot& robot, const MergedRobot& merged, bool floating);

  /// Coordinates by joint of the robot at which the model starts.
  const std::vector<double>& start() const { return start_; }
  /// The largest distance of a link's origin or a centre of mass from the root's origin, m.
  double size() const { return size_; }

  /// The inertia that a force of joint `joint` (a hinge or a slide) accelerates while all others move freely,
  /// 1/(M⁻¹)ⱼⱼ, followers with what they follow: the least at the start and in 7 other positions within the
  /// limits. By joint; 0 where some motion has no inertia.
  std::vector<double> least_inertias() const;

  /// Called for a body of which a motion relative to its carrier has no inertia while what it carries moves
  /// freely (the pivot of the articulated-body algorithm is 0). Returns true where it gave the body some.
  using Massless = std::function<bool(std::size_t body)>;
  /// From the ends of the tree to its root, at the start.
  void find_massless_motions(const Massless& massless) const;

 private:
  struct Position {
    std::vector<Pose> poses;  ///< of bodies
    std::vector<SpatialInertia> inertias;
  };
  Position at(const std::vector<double>& coordinates) const;
  SpatialInertia inertia(const MergedBody& body, const Pose& pose) const;
  /// The unit motions of a body relative to its carrier.
  std::vector<Spatial> motions(std::size_t body, const Pose& pose) const;
  Eigen::MatrixXd mass_matrix(const Position& position) const;
  /// d coordinate / d independent coordinates, by joint: rows; and coordinates with followers where these put
  /// them.
  Eigen::MatrixXd independent() const;
  void follow(std::vector<double>& coordinates) const;
  std::vector<double> effective(const std::vector<double>& coordinates) const;

  const Robot& robot_;
  const MergedRobot& merged_;
  bool floating_;
  std::vector<int> carrier_, joint_;  ///< by body: the body that carries it and the joint; -1 for the root
  std::vector<int> leader_;           ///< by joint: the one that it mimics, -1: none
  std::vector<int> first_;            ///< by body: of its motions
  int motions_ = 0;                   ///< of all
  std::vector<double> start_;
  double size_ = 0;
};

/// Where a joint is put at the start: 0, or the middle between limits that exclude 0.
double start_of(const Joint& joint);

}  // namespace mimbre::urdf
