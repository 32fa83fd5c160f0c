#pragma once
#include <array>

/// Factors of the joints' coordinates in couplings that have names of their own.
namespace mimbre {

/// Of the first and the second joint: θ₁ = ratio θ₂.
constexpr std::array<double, 2> gear_factors(double ratio) { return {1, -ratio}; }
/// Of the pinion and the rack: x = radius θ.
constexpr std::array<double, 2> rack_factors(double radius) { return {-radius, 1}; }
/// Of the cage and both sides: it turns with their mean.
constexpr std::array<double, 3> differential_factors{-2, 1, 1};

}  // namespace mimbre
