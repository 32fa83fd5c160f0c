#pragma once
#include <cstddef>
#include <vector>

#include "mimbre/modes.h"

/// Which mode of one model is which of another one with the same states.
namespace mimbre::linear {

/// 1: the same shape; 0: another one.
double alike(const Mode& a, const Mode& b);

/// Of exponents that are known but for multiples of `turn` the one that goes on from a mode, or that of the
/// conjugate; `turn` 0: they are known.
void go_on_from(const Mode& from, double turn, Mode& to);

/// Modes of equal eigenvalues, which have no shapes of their own; not those that have one shape in common.
std::vector<std::vector<std::size_t>> clusters_of(const std::vector<Mode>& modes);

/// Gives rigid modes, if there are as many, the shapes of those of `to`, and modes of equal eigenvalues those
/// that are nearest to those of `to`: X ← X (L Y), for the vectors Y of `to` that lie most in their space.
void align(std::vector<Mode>& modes, const std::vector<Mode>& to);

}  // namespace mimbre::linear
