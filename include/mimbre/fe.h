#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <string>
#include <vector>

/// Finite-element models of frames of beams.
namespace mimbre::fe {

struct Material {
  double young = 0;    ///< Pa
  double poisson = 0;  ///< –
  double density = 0;  ///< kg/m³
};

struct Section {
  double area = 0;                  ///< m²
  double Iy = 0;                    ///< m⁴, bending in the x–z plane of the element
  double Iz = 0;                    ///< m⁴, bending in the x–y plane
  double J = 0;                     ///< m⁴, torsion
  double shear_y = 0, shear_z = 0;  ///< m², shear areas kA along y and z: Timoshenko's theory needs them
  // For stress; 0: unknown.
  double reach_y = 0, reach_z = 0;  ///< m, from the axis to the outermost fibres
  double torsion_modulus = 0;       ///< m³: torque over the largest shear stress
  bool round = false;               ///< its outermost fibres are a circle; else the corners of a rectangle
};

/// What a section does as a bar bends.
enum class BeamTheory {
  euler_bernoulli,  ///< it stays at right angles to the axis and turns without inertia
  rayleigh,         ///< it stays at right angles and has rotary inertia
  timoshenko        ///< it turns freely, against shear, and has rotary inertia
};

/// 3D element between two nodes; the axis runs between node + offset, the offsets rigid.
struct BeamElement {
  std::array<int, 2> nodes{};
  std::array<Eigen::Vector3d, 2> offsets{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  Eigen::Vector3d y_direction =
      Eigen::Vector3d::Zero();  ///< element y lies in the plane of axis and this; zero: any
  Section section;
  Material material;
  BeamTheory theory = BeamTheory::euler_bernoulli;
  std::string bar;  ///< of which it is a part, for people; the elements of a bar follow one another
};

struct Mesh {
  Eigen::Matrix3Xd nodes;  ///< body axes, 6 dofs each: translations, rotations
  std::vector<BeamElement> elements;
};

/// How the kinetic energy follows from the motion of the nodes.
enum class MassMatrix {
  consistent,  ///< as the elements interpolate displacements
  /// T = Σ ½ mᵢ vᵢ² + ½ ωᵢᵀ Jᵢ ωᵢ over the nodes (Géradin, Cardona 2001). Beams: half the mass and half the
  /// inertia of the sections at each end, m L²/78 against bending (Hinton, Rock, Zienkiewicz 1976). Mass and
  /// centre of mass are exact; the inertia across a bar of n equal elements is 2.31/n² larger.
  lumped
};

/// Free (unconstrained) matrices, 6·nodes square, symmetric, full storage.
struct Matrices {
  Eigen::SparseMatrix<double> mass;
  Eigen::SparseMatrix<double> stiffness;
};
Matrices assemble(const Mesh& mesh, MassMatrix mass_matrix = MassMatrix::consistent);

/// Lowest `count` eigenfrequencies (rad/s, ascending) of the mesh with the given nodes clamped (sparse
/// shift-invert). Rigid-body modes of a free mesh come out as zeros.
Eigen::VectorXd eigenfrequencies(const Mesh& mesh, const std::vector<int>& clamped_nodes, int count);
/// The same with single dofs fixed: indices 6·node + 0..5.
Eigen::VectorXd eigenfrequencies_fixed_dofs(const Mesh& mesh, const std::vector<int>& fixed_dofs, int count);

}  // namespace mimbre::fe
