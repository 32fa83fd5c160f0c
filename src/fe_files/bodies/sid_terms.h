#pragma once
#include <Eigen/Core>

/// Meaning: O. Wallrapp, Mech. Struct. Mach. 22(3), 1994; R. Schwertassek, O. Wallrapp, Dynamik flexibler
/// Mehrkörpersysteme, 1999, 6.3. With φ_k the displacement of mode k, r the undeformed position:
///   mdCM1 = ∫φ_k dm         J1 = −∫(r~ φ_k~ + φ_k~ r~) dm        Ct0 = ∫φ_kᵀ dm      Cr0 = ∫(r × φ_k)ᵀ dm
///   Cr1(k, m) = ∫(φ_m × φ_k)ᵀ dm      Gr0_l = −2∫r~ φ_l~ dm      Gr1_lm = −2∫φ_m~ φ_l~ dm
///   Ge0_l(k) = 2∫(φ_l × φ_k)ᵀ dm      Oe(k)·(ωx², ωy², ωz², ωxωy, ωyωz, ωxωz) = ∫φ_k · ω × (ω × (r + Σ φ_m
///   y_m)) dm
/// Geometric stiffness adds to the linear parts of Oe (angular velocity), Ct (acceleration less gravity) and
/// Cr (angular acceleration), of the body with nothing but its frame held. That of forces at a node is minus
/// the linear part of its phi, that of torques of its psi, so that phiᵀ F is the force on the modes: under
/// tension the node comes nearer by what the modes bend. sigma: stress at a node, xx yy zz xy yz zx, m1 of
/// the modes.
namespace mimbre::fe {

/// Columns of Oe: the products ω_a ω_b.
inline constexpr int kProducts[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
/// Rows of J.
inline constexpr int kInertia[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

/// ∫φ × r dm of A = ∫φ rᵀ dm.
inline Eigen::RowVector3d cross_of(const Eigen::Matrix3d& A) {
  return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)};
}

}  // namespace mimbre::fe
