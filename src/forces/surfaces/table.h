#pragma once
#include <array>

#include "forces/surfaces/box.h"
#include "forces/surfaces/capsule.h"
#include "forces/surfaces/cylinder.h"
#include "forces/surfaces/half_space.h"
#include "forces/surfaces/mesh.h"
#include "forces/surfaces/sphere.h"
#include "spec/surface_kinds.h"

/// The surfaces that spheres touch. A new one is a file like box.h, a row here and one in
/// spec/surface_kinds.h.
namespace mimbre::surfaces {

template <class T>
using TouchFunction = Touch<T> (*)(const SurfaceData&, const Vec3<T>&);

template <class T>
constexpr std::array<TouchFunction<T>, surface_kinds.size()> rows{
    half_space<T>, box<T>, cylinder<T>, capsule<T>, sphere<T>, mesh<T>, mesh<T>};

/// Of a point in the surface's axes.
template <class T>
Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
  return rows<T>[static_cast<std::size_t>(s.kind)](s, p);
}

}  // namespace mimbre::surfaces
