#pragma once
#include <Eigen/Core>
#include <array>

/// Numbers that people read from stresses. Components: xx yy zz xy yz zx, Pa.
namespace mimbre {

using Vector6 = Eigen::Matrix<double, 6, 1>;

inline constexpr std::array stress_components{
    "xx", "yy", "zz", "xy", "yz", "zx", "max_principal", "min_principal", "von_mises"};
constexpr int max_principal_component = 6, von_mises_component = 8;

/// √(½ Σ (σi − σj)²) of the principal stresses.
double von_mises(const Vector6& stress);
/// By its place in stress_components. Strains (engineering shears) go through tensor_strain first.
double stress_component(const Vector6& stress, int component);
/// Engineering shears to the tensor's entries.
Vector6 tensor_strain(const Vector6& strain);
/// nᵀ ε n: what a gauge along n (unit) shows.
double elongation(const Vector6& strain, const Eigen::Vector3d& n);

}  // namespace mimbre
