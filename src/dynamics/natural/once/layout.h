#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "compile/compiled.h"

/// What the step in natural coordinates needs beside the compiled model, made once from it. The unknowns are
/// points and unit vectors (García de Jalón, Bayo 1994; Lugrís 2008, 2.2.1), then modal amplitudes.
namespace mimbre::natural {

/// A point or a vector that belongs to one body or is shared by several. Unknown ones come first, each three
/// unknowns; those of the ground follow and are constant.
struct Variable {
  bool point = false;
  int body = -1;                ///< one body that carries it, -1: the ground
  Vec3d place = Vec3d::Zero();  ///< in that body's axes; ground: global axes, points relative to the origin
};

/// Columns of the unknowns that a body, a joint or a force touches, and where its dense symmetric matrix
/// goes.
struct Stencil {
  std::vector<int> columns;
  int stride = 0;  ///< padded number of columns
  /// of entries (r, c ≤ r), row by row, in the values of the sparse matrix
  std::vector<std::ptrdiff_t> targets;

  int size() const { return static_cast<int>(columns.size()); }
};

/// One scalar equation of rigidity: (A δi) · (A δj) = δi · δj, A the body's three unit vectors.
struct Rigidity {
  int i = 0, j = 0;  ///< of Body::directions
};

/// A body's frame [r0 u v w] is a constant combination of its variables, so that its mass matrix is constant.
struct Body {
  std::vector<int> variables;                     ///< unknown ones first
  int unknown = 0;                                ///< how many of them are unknown
  Eigen::Matrix<double, 4, Eigen::Dynamic> base;  ///< 4 × variables
  int q = 0;                                      ///< first modal amplitude among the unknowns
  int amplitudes = 0;                             ///< first of its padded amplitudes in the workspace
  Mat3d directions = Mat3d::Identity();           ///< columns δ1, δ2, δ3, in body axes, of length one
  double lengths[3] = {1, 1, 1};  ///< distances of the points that they join; vectors: the length scale
  double inertia = 0;             ///< what it resists turning with, kg m² (compile/find_scales.h)
  std::vector<Rigidity> rigidity;
  int first_equation = 0;
  int jacobian = 0;  ///< offset of the rigidity equations' rows, over the stencil's columns
  Stencil stencil;   ///< unknown variables, then modal amplitudes
  Eigen::Matrix4d mass = Eigen::Matrix4d::Zero();  ///< rigid: ∫ (1, r̄)(1, r̄)ᵀ dm
  /// rigid: the same over the unknown variables, unknown × unknown, times the identity of size 3
  Eigen::MatrixXd variable_mass;
};

/// Two bodies (-1: none, the ground) that share a stencil: which of its columns are whose.
struct Sides {
  int body_a = -1, body_b = -1;
  std::vector<int> columns_a, columns_b;  ///< stencil column of each unknown of the body's own stencil
};

/// Joins the frames of two bodies.
struct Link : Sides {
  Stencil stencil;
  int jacobian = 0;                    ///< offset of its rows
  std::vector<std::vector<int>> legs;  ///< of a sum (no bodies): stencil column of each of a leg's columns
};

/// The same of a constraint, which may join several pairs of bodies.
struct ConstraintLink {
  std::vector<Sides> terms;  ///< as in the compiled model
  Stencil stencil;
  int jacobian = 0;
  int first_equation = 0;
};

/// What is left of a joint where points and vectors are not shared.
struct JointEquation {
  enum class Kind {
    coincidence,  ///< three equations: origin of b − origin of a = 0
    distance,     ///< axis of a · (origin of b − origin of a) = 0
    angle         ///< axis of a · axis of b = 0
  } kind = Kind::coincidence;
  int axis_a = 0, axis_b = 0;

  int count() const { return kind == Kind::coincidence ? 3 : 1; }
};
struct Joint {
  int spec = -1;
  int frame_a = -1, frame_b = -1;
  std::vector<JointEquation> equations;
  int first_equation = 0;
  int count = 0;
  double scale[6] = {1, 1, 1, 1, 1, 1};
  Link link;
};

/// The coordinates of a tree joint, functions of the points and vectors: they follow the unknowns in q, so
/// that angles count turns.
struct JointCoordinate {
  int body = -1;  ///< tree body whose joint it is
  int frame_a = -1, frame_b = -1;
  int q = 0;  ///< first of its values in q
};

struct Layout {
  explicit Layout(const Compiled& model);

  Vec3d origin = Vec3d::Zero();  ///< points are relative to it; near the mechanism's assembled position
  std::vector<Variable> variables;
  int unknown_variables = 0;
  int unknowns = 0;   ///< 3 unknown_variables + modal amplitudes
  int positions = 0;  ///< unknowns + joint coordinates
  int equations = 0;
  std::vector<Body> bodies;                        ///< as in the compiled model
  std::vector<Joint> joints;                       ///< those with equations of their own
  std::vector<JointCoordinate> joint_coordinates;  ///< by tree body
  std::vector<Link> elements, drives;
  std::vector<std::vector<Link>> spheres;  ///< of swarms, by contact: each sphere against the ground
  std::vector<ConstraintLink> constraints;
  int first_drive = 0;           ///< equation
  std::vector<char> frame_use;   ///< by frame: 0 not in the step, 1 position and velocity, 2 everything
  std::vector<int> late_frames;  ///< in use, but not among the dynamic frames of their bodies
  int jacobian_storage = 0;
  int amplitude_storage = 0;
  int widest = 8;  ///< largest stencil stride
  std::shared_ptr<const linalg::BlockSymbolic> symbolic;
};

}  // namespace mimbre::natural
