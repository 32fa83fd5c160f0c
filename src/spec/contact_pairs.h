#pragma once
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// How many pairs of a swarm can be near each other, for each of its spheres. Of hard spheres of any sizes
/// fewer than 8 + 4√3 touch one on average (Kuperberg and Schramm, Mathematical Research Letters 1, 1994),
/// half of it a sphere.
constexpr int places_per_sphere = 8;

/// A sphere and what it can touch: a surface, or another sphere.
struct ContactPair {
  int contact = -1;
  int surface = -1;                ///< -1: a sphere about frame a
  int frame_a = -1, frame_b = -1;  ///< of the surface, of the sphere
  double radius = 0, other_radius = 0;
};

struct ContactSphere {
  int frame = -1;
  double radius = 0;
};

struct ContactPairs {
  /// Of all contacts in their order, of different bodies; of the spheres of a swarm only those with surfaces.
  std::vector<ContactPair> pairs;
  std::vector<std::vector<ContactSphere>> swarms;  ///< by contact, of swarms
};

/// Makes frames for the spheres on surfaces of flexible bodies.
ContactPairs contact_pairs(spec::Model& model);

}  // namespace mimbre
