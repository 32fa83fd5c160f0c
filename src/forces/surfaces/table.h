#pragma once
#include <array>

#include "forces/surfaces/box.h"
#include "forces/surfaces/capsule.h"
#include "forces/surfaces/cylinder.h"
#include "forces/surfaces/half_space.h"
#include "forces/surfaces/heights.h"
#include "forces/surfaces/mesh.h"
#include "forces/surfaces/sphere.h"
#include "spec/surface_kind.h"

/// The surfaces that spheres touch. A new one is a file like box.h and its name in this list.
namespace mimbre::surfaces {

template <class... Kinds>
struct SurfaceList {};
/// In the order of SurfaceData::kind.
using Surfaces = SurfaceList<HalfSpace, Box, Cylinder, Capsule, Sphere, Heights, Mesh>;

template <class T>
using TouchFunction = Touch<T> (*)(const SurfaceData&, const Vec3<T>&);

template <class T, class... Kind>
constexpr std::array<TouchFunction<T>, sizeof...(Kind)> rows_of(SurfaceList<Kind...>) {
  return {Kind::template touch<T>...};
}
template <class T>
constexpr auto rows = rows_of<T>(Surfaces());

template <class... Kind>
constexpr std::array<const SurfaceInfo*, sizeof...(Kind)> infos_of(SurfaceList<Kind...>) {
  return {&Kind::info...};
}
inline constexpr auto infos = infos_of(Surfaces());

/// Of a point in the surface's axes.
template <class T>
Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
  return rows<T>[static_cast<std::size_t>(s.kind)](s, p);
}

}  // namespace mimbre::surfaces
