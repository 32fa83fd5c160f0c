#pragma once

/// Format: MBDyn input manual, modal joint. Of node i, mass m and position u: invariants I3_j = Σ m φ_j,
/// I4_j = Σ (m u × φ_j + J ψ_j), I5_jk = Σ m φ_j × φ_k, I8_j = −Σ m u~ φ_j~, I9_jk = Σ m φ_j~ φ_k~.
/// Record group 19: a count, then for each matrix its index and the matrix. With them the modal stiffness has
/// Σ K_index s_index more, s: 1–6 ωx², ωy², ωz², ωxωy, ωyωz, ωzωx; 7–9 angular acceleration; 10–12
/// acceleration less gravity, all of the modal node and in its axes; from 13 on six of each node: force,
/// torque on the body.
namespace mimbre::fe {

/// Index of record group 19, from 0, as a number of GeometricStiffness or, from 12 on, six of each node.
inline constexpr int kStiffeningLoads[] = {0, 1, 2, 3, 4, 5, 9, 10, 11, 6, 7, 8};

}  // namespace mimbre::fe
