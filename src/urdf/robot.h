#pragma once
#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"

/// A robot as in its file. Links and joints are named by URDF's words and each in its own axes.
namespace mimbre::urdf {

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< these axes to the outer ones
  Pose of(const Pose& inner) const {
    return {position + rotation * inner.position, rotation * inner.rotation};
  }
};

/// Something that is seen of a link, or touched.
struct Visual {
  enum class Kind { box, cylinder, sphere, capsule, mesh } kind = Kind::box;
  Mark mark;
  Pose pose;             ///< in the link; the axis of a cylinder and a capsule is z
  Eigen::Vector3d size;  ///< box: edges; cylinder: radius, length; sphere: radius; capsule: radius, length
                         ///< between the half spheres; mesh: factors on its coordinates
  std::string file;      ///< of a mesh, as it is written
};

struct Link {
  std::string name;
  Mark mark;
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< in the link
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, in the link's axes
  std::vector<Visual> visuals, collisions;
};

/// Its coordinate follows another's: multiplier · other + offset.
struct Mimic {
  std::string joint;
  double multiplier = 1, offset = 0;
};

struct Joint {
  std::string name;
  Mark mark;
  enum class Type { fixed, revolute, continuous, prismatic, floating, planar, spherical };
  Type type = Type::fixed;
  int parent = -1, child = -1;  ///< links
  Pose pose;                    ///< of the child in the parent where all coordinates are 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< in the child
  std::optional<double> lower, upper;               ///< rad or m
  double effort = 0, damping = 0, friction = 0;     ///< N m or N; per speed; 0: none is given
  std::optional<Mimic> mimic;

  bool turns() const { return type == Type::revolute || type == Type::continuous; }
  bool scalar() const { return turns() || type == Type::prismatic; }
};

struct Robot {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<int> order;               ///< of the links: each behind the one that carries it; the root first
  std::vector<int> held_by;             ///< the joint whose child a link is; -1 for the root
  std::map<std::string, int> left_out;  ///< elements that were not read, and how many
  std::vector<Diagnostic> notes;
  std::vector<Diagnostic> repairs;  ///< what was, what is
};

/// Throws InputError with all that is wrong. `repair`: numbers, masses and limits that can be understood in
/// one way only are taken that way, and listed.
Robot read_robot(const std::string& path, bool repair);

/// Makes fixed joints of those that cannot move: with equal limits, or because they follow one that does not
/// move. Notes each.
void fix_immobile_joints(Robot& robot);

}  // namespace mimbre::urdf
