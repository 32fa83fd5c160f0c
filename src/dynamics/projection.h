#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "compile/rows.h"
#include "linalg/block_sparse.h"
#include "math/rotation.h"
#include "mimbre/reduced_body.h"
#include "mimbre/spec.h"

/// Inertia of flexible bodies by projection of the mesh's mass matrix M* (Lugrís 2008, 2.76–2.90), evaluated
/// node by node at every position: the cost grows with the mesh. All in body axes.
///
/// The motion is affine plus modal. With base vectors b_0 … b_3 (the velocity, acceleration or variation of
/// the origin and of the three body axes, in body axes) a point at r̄ = r̄u + X y moves by b_0 + Σ_i r̄_i b_i +
/// X ẏ. Natural coordinates have b_i = Aᵀ u̇ and so on; a rigid rotation ω is b_i = ω × e_i. The kinetic
/// energy is that of shape integrals (docs/theory.md, section 4) whose sums over the nodes k are taken at the
/// motion:
///   m̄ = m̄u + S y,                                S = Σ_k M_k
///   S'^i = Σ_k (r̄u_ki + ½ X_ki y) M_k + ½ (M_ki y) X_k + ½ Sθ × e_i
///   P̄_ij = P̄u_ij + Σ_k (r̄u_ki + ½ X_ki y) M_kj y + (r̄u_kj + ½ X_kj y) M_ki y
/// where X_k, M_k are the rows of Φ and M*Φ that are translations of node k, Sθ = Σ_k (M*Φ)_k of rotations,
/// and m, m̄u, P̄u are those of M* and its rigid motions. Where all blocks of M* are multiples of the identity
/// this is B*ᵀ M* B*. Nodal rotations and blocks that depend on the direction turn with a body that moves as
/// a whole, as they do at rest; with rotations that do not follow the deformation, forces and energy would
/// differ by the square of the element length.
///
/// Values of modes (y, ẏ, ÿ, elastic forces, rows) are padded to `Constants::stride` with zeros.
namespace mimbre {
struct Compiled;
}
namespace mimbre::projection {

using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;
using mimbre::Rows;
/// Base vectors, or the forces on them: of the origin, then of the three axes.
using Base = std::array<Vec3d, 4>;
using Values = std::vector<double, linalg::CacheAligned<double>>;

/// What does not change with the motion, made once per body and inertia option.
struct Constants {
  int nodes = 0;
  int modes = 0;
  int stride = 0;  ///< modes padded as elsewhere (multiple of 8)

  Rows mass;                            ///< ΦᵀM*Φ, stride × stride
  double total_mass = 0;                ///< of a rigid translation
  Vec3d first_moment = Vec3d::Zero();   ///< m̄u
  Mat3d second_moment = Mat3d::Zero();  ///< P̄u = ½ tr(J) I − J, J the rigid body's inertia
  /// The mass of the whole does not depend on the direction. All usual finite elements do this; matrices that
  /// were condensed may not.
  bool plain = true;

  int panels = 0;                ///< of 8 translations
  Values undeformed;             ///< r̄u, 3 per node
  Values shapes, masses;         ///< X and M, [panel][mode][8]
  Values shape_rows, mass_rows;  ///< the same, [four modes][translations][4]
  Rows S, S_theta;               ///< 3 × stride: Σ_k (M*Φ)_k of translations, of rotations
  Values zeros;                  ///< stride zeros
};

/// Throws std::invalid_argument when the body has no mesh inertia. `rotations` false: only the translational
/// rows and columns of M* (and of the shapes) are used.
Constants constants(const ReducedBody& body, bool rotations);

/// Of every flexible body's data (Compiled::flexible); none for inertia by shape integrals. Throws InputError
/// naming the bodies that have no mesh inertia.
std::vector<Constants> constants(const Compiled& model, spec::Simulation::Inertia inertia);

/// Scratch for bodies up to the largest mesh it was fitted to; the functions below do not allocate. Three
/// values per node but for the last two.
struct Work {
  Values place, moment;       ///< r̄u + ½ X y, ½ M y
  Values velocity, momentum;  ///< X ẏ, M ẏ
  Values modal, force;        ///< X ÿ, M ÿ
  Values by_mass, by_shape;   ///< what Mᵀ and Xᵀ are multiplied with, 4 per node
  void fit(const Constants& c);
};

/// Inertia forces of natural coordinates: on the base vectors (`forces`, body axes), and on the modes (added
/// to `elastic`, padded), for base accelerations b (b[0] = Aᵀ r̈0 minus gravity, b[1..3] = Aᵀü, Aᵀv̈, Aᵀẅ) and
/// spin = AᵀȦ, any 3 × 3 matrix:
///   F_0 = m b_0 + Σ_i m̄_i b_i + S ÿ + 2 spin S ẏ
///   F_i = m̄_i b_0 + Σ_j P̄_ij b_j + S'^i ÿ + 2 spin S'^i ẏ
///   e   = Sᵀ b_0 + Σ_i S'^iᵀ b_i + ΦᵀM*Φ ÿ + Σ_k Mᵀ spin X ẏ + Xᵀ spin M ẏ
/// No K y, no C ẏ. As the virtual power is Σ_i F_i · δb_i + e · δẏ, global forces on r0, u, v, w are A F_i.
/// With spin = 0, ẏ = 0 and velocities for accelerations the result is the momenta.
void inertia_forces(const Constants& c, Work& w, const Base& b, const Mat3d& spin, const double* y,
                    const double* yd, const double* ydd, Base& forces, double* elastic);

/// Mass matrix of natural coordinates at y: that of the base vectors, times the identity of size 3;
/// `coupling` of base vectors and modes, 12 rows of `stride` values. Modes among themselves: Constants::mass.
/// Global: r0, u, v, w turn with A, that is diag(A, A, A, A) coupling.
Eigen::Matrix4d base_mass(const Constants& c, Work& w, const double* y, double* coupling);

/// Kinetic energy for base velocities b = (Aᵀ ṙ0, Aᵀ u̇, Aᵀ v̇, Aᵀ ẇ), J. `momenta`: scratch of stride values.
double kinetic_energy(const Constants& c, Work& w, const Base& b, const double* y, const double* yd,
                      double* momenta);

/// Relative coordinates: force, and moment about the body's origin, for acceleration `acc` of the origin
/// (minus gravity), angular velocity and acceleration; elastic forces are added to `elastic`. No K y, no C ẏ.
struct Wrench {
  Vec3d force, moment;
};
Wrench inertia_wrench(const Constants& c, Work& w, const Vec3d& acc, const Vec3d& omega, const Vec3d& alpha,
                      const double* y, const double* yd, const double* ydd, double* elastic);

/// Mass blocks of relative coordinates at y in the form that the shape integrals have: m̄ (first moment), P̄
/// with J = tr(P̄) I − P̄, and the nine rows S'^i_j (row 3 i + j, stride values each), of which the coupling of
/// angular velocity and modes is C_a = S'^b_c − S'^c_b. Mass, S and Mff: Constants::total_mass, S, mass.
void rigid_mass(const Constants& c, Work& w, const double* y, Vec3d& first, Mat3d& second, double* integrals);

/// Base velocities of a rigid motion: of the origin, and ω × e_i.
Base rigid_base(const Vec3d& velocity, const Vec3d& omega);

}  // namespace mimbre::projection
