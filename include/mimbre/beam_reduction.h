#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "mimbre/fe.h"
#include "mimbre/reduced_body.h"

/// Reduction of frames of beams to a ReducedBody.
namespace mimbre::fe {

/// One retained boundary dof: unit displacement along (or rotation about) `direction` (body axes) of `node`.
/// Several on one node must have orthogonal directions. Each gives one static mode. Dofs that are not
/// named here are internal ("freed").
struct BoundaryDof {
  int node = 0;
  bool rotation = false;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  std::string name;
};

/// What a reduced beam knows of large deflections (Lugrís 2008, chapter 4). Beyond `linear` the mesh must be
/// a tree of bars with one clamped node, and no axial mode may be missing where a method needs one.
enum class Stiffening {
  linear,
  foreshortening,  ///< bending shortens the beam: displacements quadratic in the amplitudes (4.19–4.35)
  nonlinear_stiffness_1,  ///< strain energy with the term ½∫EA u'v'² (4.5, 4.11)
  nonlinear_stiffness_2,  ///< and with ⅛∫EA v'⁴
  geometric_stiffness     ///< stiffness by prestress: of inertia, gravity and boundary forces
                          ///< (GeometricStiffness)
};

struct ReductionOptions {
  std::vector<int> clamped_nodes;  ///< the tangent frame: all six dofs of these nodes vanish
  std::vector<int>
      fixed_dofs;  ///< further dofs that vanish: indices 6·node + 0..5, body axes (planar bodies)
  std::vector<BoundaryDof> boundary;
  int dynamic_modes = 0;         ///< lowest fixed-interface modes
  double stiffness_damping = 0;  ///< s: C = stiffness_damping · K
  int axial_dynamic_modes = 0;   ///< lowest fixed-interface modes that only stretch (straight beams)
  Stiffening stiffening = Stiffening::linear;
  /// Nonlinear stiffness: the published force, which lacks what bending does on axial modes, instead of the
  /// gradient of the strain energy; that of nonlinear_stiffness_1 has no lower bound and diverges.
  bool published_force = false;
  BoundaryRotation boundary_rotation = BoundaryRotation::exponential;
  bool sections = false;  ///< with ReducedBody::sections
  MassMatrix mass_matrix = MassMatrix::consistent;
};

/// A node that becomes a frame of the reduced body, with its axes.
struct NodeFrame {
  std::string name;
  int node = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

/// Craig–Bampton reduction (Craig, Bampton 1968; Lugrís 2008, 2.7–2.9) with inertia shape integrals, made
/// orthogonal. Throws std::invalid_argument naming what is wrong (no clamped node, dependent boundary dofs,
/// singular Kii, more modes than dofs).
ReducedBody reduce(const Mesh& mesh, const ReductionOptions& options, const std::vector<NodeFrame>& frames);

struct AncfOptions {
  AncfKind kind = AncfKind::planar;
  int clamped_node = 0;  ///< the body frame moves with it and with the direction of its slope, or its section
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< planar: of the plane, body axes
  double stiffness_damping = 0;                       ///< s
};

/// A straight beam by absolute nodal coordinates (AncfBeam): no modes are chosen, the amplitudes are the
/// nodes'. Throws std::invalid_argument when the mesh is not one line of bars that is clamped at one end,
/// does not lie in the plane, or has sections or a theory that the kind does not know: planar and cable Euler
/// and Bernoulli's without rotary inertia, thick Timoshenko's; a cable bends alike in all directions, and the
/// axes of a thick beam's sections do not turn along it.
ReducedBody ancf_beam(const Mesh& mesh, const AncfOptions& options, const std::vector<NodeFrame>& frames);

}  // namespace mimbre::fe
