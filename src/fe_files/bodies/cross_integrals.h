#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/reduced_body.h"

/// The integrals of a reduced body in the forms that other programs write: cross products of positions and
/// modes. With φ_m the displacement of mode m and r̄u the position.
namespace mimbre::fe {

/// P = ½ tr(J) I − J: ∫ r rᵀ dm of the inertia tensor J, both about the same point.
Eigen::Matrix3d second_moment_of(const Eigen::Matrix3d& inertia);
Eigen::Matrix3d inertia_of(const Eigen::Matrix3d& second_moment);

/// ∫ φ_m r̄uᵀ dm, from S_position.
Eigen::Matrix3d position_integral(const ReducedBody& body, int m);
/// ∫ r̄u × φ_m dm, 3 × modes (with rotary inertia).
Eigen::Matrix3Xd angular_coupling(const ReducedBody& body);
/// S_position whose symmetric part is that of `position` (one per mode) and whose other part gives
/// `coupling`.
void set_position_integrals(const std::vector<Eigen::Matrix3d>& position, const Eigen::Matrix3Xd& coupling,
                            ReducedBody& body);

/// ∫ φ_k φ_mᵀ dm, from S_modes.
Eigen::Matrix3d mode_integral(const ReducedBody& body, int k, int m);
/// S_modes with ∫ φ_k φ_mᵀ dm = integral(k, m), symmetric in the sense that it equals integral(m, k)ᵀ.
template <class Integral>
void set_mode_integrals(int modes, Integral&& integral, ReducedBody& body) {
  for (auto& row : body.S_modes)
    for (Eigen::MatrixXd& block : row) block.resize(modes, modes);
  for (int k = 0; k < modes; ++k)
    for (int m = k; m < modes; ++m) {
      const Eigen::Matrix3d value = 0.5 * (integral(k, m) + integral(m, k).transpose().eval());
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
          const double entry = value(static_cast<int>(i), static_cast<int>(j));
          body.S_modes[i][j](k, m) = entry;
          body.S_modes[j][i](m, k) = entry;
        }
    }
}

/// The body with all arrays zero and of their sizes, `mode 1`, `mode 2`, …
ReducedBody empty_body(int modes);
/// Symmetric parts of the matrices, and check(): what forbids the use of the body is thrown as InputError for
/// the file, the rest is returned.
std::vector<std::string> finish_body(const std::string& path, ReducedBody& body);

}  // namespace mimbre::fe
