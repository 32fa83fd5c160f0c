#pragma once
#include <cstdint>
#include <vector>

#include "mimbre/road_file.h"

/// Random roads by the spectra of ISO 8608.
namespace mimbre {

/// Displacement spectral density Gd(n₀), m³, in the middle of a class A to H of ISO 8608:2016, table C.1, at
/// the spatial frequency n₀ = 0.1 cycles/m. Throws std::invalid_argument of other letters.
double road_roughness(char road_class);

/// A straight road whose profile along every track has the one-sided spectral density Gd(n₀) (n / n₀)^−w.
///
/// Tracks beside each other belong together as on a surface that is the same in all directions (Dodds and
/// Robson, The description of road surface roughness, J. Sound Vib. 31, 1973): with the coherence
/// 2 (π n b)^(w/2) K_(w/2)(2 π n b) / Γ(w/2) at the distance b, so that long waves lift both wheels of an
/// axle and short ones each by itself.
struct RandomRoad {
  double roughness = 0;                ///< Gd(n₀), m³; road_roughness() of a class
  double waviness = 2;                 ///< w
  double length = 100;                 ///< m
  double increment = 0.05;             ///< of the grid along the road, m
  std::vector<double> v{-0.75, 0.75};  ///< tracks, from right to left, m
  double lowest = 0.01, highest = 4;   ///< spatial frequencies that it has, cycles/m
  std::uint64_t seed = 1;              ///< the same seed gives the same road, whatever its length
};

/// Along x from x = 0, y to the left. A sum of cosines of random phases, so many to an octave that they are
/// no lines to any vehicle. Throws std::invalid_argument, saying which, where a number cannot be; `highest`
/// must not be above half of the sections that the grid has in a metre.
RoadGrid random_road(const RandomRoad& what);

}  // namespace mimbre
