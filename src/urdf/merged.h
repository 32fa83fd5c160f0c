#pragma once
#include <string>
#include <vector>

#include "urdf/robot.h"

namespace mimbre::urdf {

/// A body of the model: a link, with those that hang on it by fixed joints where these are merged. All is
/// global, where all coordinates are 0, but for the inertia.
struct MergedBody {
  int link = -1;  ///< the first of its links, which gives it its name and frame
  Pose pose;
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, in the body's axes
  std::vector<Visual> visuals, collisions;
  std::vector<int> frames;  ///< the other links
};

struct MergedRobot {
  std::vector<MergedBody> bodies;  ///< each behind the one that carries it
  std::vector<int> body_of;        ///< by link
  std::vector<Pose> links;         ///< global
};

/// `keep_fixed`: links on fixed joints stay bodies.
MergedRobot merged(const Robot& robot, bool keep_fixed);

/// Inertia of a mass at `arm` from the point about which it is taken (Steiner).
Eigen::Matrix3d steiner(double mass, const Eigen::Vector3d& arm);

}  // namespace mimbre::urdf
