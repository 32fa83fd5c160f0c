#pragma once
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// A sphere and what it can touch: a surface, or another sphere.
struct ContactPair {
  int contact = -1;
  int surface = -1;                ///< -1: a sphere about frame a
  int frame_a = -1, frame_b = -1;  ///< of the surface, of the sphere
  double radius = 0, other_radius = 0;
};

/// The pairs of all contacts in their order, of different bodies. Makes frames for the spheres on surfaces of
/// flexible bodies.
std::vector<ContactPair> contact_pairs(spec::Model& model);

}  // namespace mimbre
