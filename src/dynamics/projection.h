#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "compile/rows.h"
#include "linalg/block_sparse.h"
#include "math/rotation.h"
#include "mimbre/reduced_body.h"
#include "mimbre/spec.h"

/// Inertia of flexible bodies by projection of the mesh's mass matrix, M̄ = B*ᵀ M* B* (Lugrís
/// 2008, 2.76–2.90), evaluated node by node at every position: the cost grows with the mesh. All in body
/// axes.
///
/// The motion of the nodes is affine plus modal. With base vectors b_0 … b_3 (the velocity, acceleration or
/// variation of the origin and of the three body axes, in body axes), node k moves by
///   translation  b_0 + Σ_i r̄_ki b_i + X_k ẏ,                  r̄_k = r̄u_k + X_k y
///   rotation     ½ Σ_i e_i × b_i + Xθ_k ẏ                      (meshes with nodal rotations)
/// Natural coordinates have b_i = Aᵀ u̇ and so on; a rigid rotation ω is b_i = ω × e_i.
///
/// Values of modes (y, ẏ, ÿ, elastic forces, rows) are padded to `Constants::stride` with zeros.
namespace mimbre {
struct Compiled;
}
namespace mimbre::projection {

using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;
using Mat12d = Eigen::Matrix<double, 12, 12>;
using mimbre::Rows;
/// Base vectors, or the forces on them: of the origin, then of the three axes.
using Base = std::array<Vec3d, 4>;
using Values = std::vector<double, linalg::CacheAligned<double>>;

/// What does not change with the motion, made once per body and inertia option.
struct Constants {
  int nodes = 0;
  int modes = 0;
  int stride = 0;          ///< modes padded as elsewhere (multiple of 8)
  bool rotations = false;  ///< nodal rotations take part

  Rows mass;                           ///< ΦᵀM*Φ, stride × stride
  double total_mass = 0;               ///< of a rigid translation
  Vec3d first_moment = Vec3d::Zero();  ///< m̄ of the undeformed body
  /// A rigid translation loads every node along itself and the nodes' moments only turn it: then the rigid
  /// block has the form m, m̄, J that composite inertias need. All usual finite elements do this; matrices
  /// that were condensed may not.
  bool plain = true;

  Values undeformed;                    ///< 3 per node
  int panels = 0, rotation_panels = 0;  ///< of 8 translations, of 8 rotations
  Values shapes;                        ///< [panel][mode][8]
  Values mass_shapes;                   ///< M*Φ: [four modes][translations, then rotations][4]

  /// Blocks of M* by rows of nodes; within a row by column. Of each block only what acts on translations.
  enum class Kind {
    scalar,        ///< m_kl I: one value
    translations,  ///< 3 × 3, columns of four values
    full           ///< 3 × 6 (translations, rotations), columns of four values
  } kind = Kind::full;
  std::vector<int> row_start, column, diagonal;  ///< diagonal: the row's own block
  Values blocks;

  /// Per node, transposed, columns of four values: Σ_l M*_kl of translations, Σ_l M*_kl^tθ, Σ_l M*_kl^θθ.
  Values sums;
  /// Sums over all nodes: Σ_kl M*_kl.
  Mat3d translation = Mat3d::Zero(), mixed = Mat3d::Zero(), rotation = Mat3d::Zero();
  Rows S, S_theta;  ///< 3 × stride: Σ_k (M*Φ)_k of translations, of rotations
  Values zeros;     ///< stride zeros
};

/// Throws std::invalid_argument when the body has no mesh inertia. `rotations` false: only the translational
/// rows and columns of M* (and of the shapes) are used.
Constants constants(const ReducedBody& body, bool rotations);

/// Of every flexible body's data (Compiled::flexible); none for inertia by shape integrals. Throws InputError
/// naming the bodies that have no mesh inertia.
std::vector<Constants> constants(const Compiled& model, spec::Simulation::Inertia inertia);

/// Scratch for bodies up to the largest mesh it was fitted to; the functions below do not allocate.
struct Work {
  Values position;  ///< r̄, 3 per node
  Values velocity;  ///< X ẏ, then Xθ ẏ
  Values modal;     ///< X ÿ, then Xθ ÿ
  Values node;      ///< accelerations, per node 3 translations, 0, 3 rotations, 0
  void fit(const Constants& c);
};

/// Inertia forces of natural coordinates: on the base vectors (`forces`, body axes), and on the modes (added
/// to `elastic`, padded), for base accelerations b (b[0] = Aᵀ r̈0 minus gravity, b[1..3] = Aᵀü, Aᵀv̈, Aᵀẅ) and
/// spin = AᵀȦ, any 3 × 3 matrix:
///   translation of node k  b_0 + Σ_i r̄_i b_i + 2 spin X ẏ + X ÿ
///   rotation of node k     ½ Σ_i e_i × b_i + Xθ ÿ
/// Sections turn with the body and M* is that of body axes: the moments change also by ω × Σ_kl M*_kl^θθ
/// (ω + Xθ_l ẏ), ω from the skew part of spin. That keeps the gyroscopic moment of sections' polar inertia,
/// which accelerations alone lose where the inertia depends on the direction. No K y, no C ẏ. As the virtual
/// power is Σ_i F_i · δb_i + e · δẏ, global forces on r0, u, v, w are A F_i. With spin = 0, ẏ = 0 and
/// velocities for accelerations the result is the momenta.
void inertia_forces(const Constants& c, Work& w, const Base& b, const Mat3d& spin, const double* y,
                    const double* yd, const double* ydd, Base& forces, double* elastic);

/// Mass matrix of natural coordinates at y: `mass` of the base vectors (12 × 12: blocks of origin and axes),
/// `coupling` of base vectors and modes, 12 rows of `stride` values. Modes among themselves: Constants::mass.
/// Global: r0, u, v, w turn with A, that is diag(A, A, A, A) mass diag(A, A, A, A)ᵀ and diag(A, A, A, A)
/// coupling.
void base_mass(const Constants& c, Work& w, const double* y, Mat12d& mass, double* coupling);

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
/// Exact where Constants::plain.
void rigid_mass(const Constants& c, Work& w, const double* y, Vec3d& first_moment, Mat3d& second_moment,
                double* integrals);

/// Base velocities of a rigid motion: of the origin, and ω × e_i.
Base rigid_base(const Vec3d& velocity, const Vec3d& omega);

}  // namespace mimbre::projection
