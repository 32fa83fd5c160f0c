#pragma once
#include "compile/compiled.h"
#include "math/recorded.h"

namespace mimbre::roads {
template <class T>
struct Place;
/// Before the kernel that calls it.
Place<Recorded> place(const RoadData& road, double footprint, const Recorded& x, const Recorded& y);
template <class T>
struct Bend;
Bend<Recorded> bend(const RoadData& road, const Recorded& x, const Recorded& y);
}  // namespace mimbre::roads

#include "forces/road_surface.h"
#include "forces/surfaces/mesh.h"
#include "forces/user.h"
#include "math/space_curve.h"
#include "signals/blocks/table_2d.h"
#include "signals/values.h"

/// What kernels do with the values of other scalars, for recorded ones: before the kernels are instantiated.
namespace mimbre {

/// Time is the recorder's own.
template <>
inline JetOf<Recorded> held_input<Recorded>(const SignalsData::HeldInput&, const Recorded*, double) {
  throw NotRecordable("has an input whose time is not known");
}

inline void curve_point(const SpaceCurve&, const Recorded&, CurvePoint<Recorded>&) {
  throw NotRecordable("has a body on a curve, which code cannot be made of");
}

namespace forces {
template <>
inline void user_law<Recorded>(const LawContext<Recorded>&, ElementState<Recorded>&) {
  throw NotRecordable("has a law of the user's own");
}
}  // namespace forces

namespace blocks::table_2d {
template <>
inline std::array<Recorded, 3> look_up<Recorded>(const BlockCall<Recorded>& c) {
  const std::vector<Recorded> parts =
      record_call({c.numbers, 0, static_cast<int>(RecordedCallee::table_of_two)}, c.in[0], &c.in[1], 3);
  return {parts[0], parts[1], parts[2]};
}
}  // namespace blocks::table_2d

namespace surfaces {
template <>
inline Touch<Recorded> Mesh::touch<Recorded>(const SurfaceData& s, const Vec3<Recorded>& p) {
  const std::vector<Recorded> parts =
      record_call({&s.mesh, 0, static_cast<int>(RecordedCallee::mesh)}, p[0], &p[1], 4, &p[2]);
  return {parts[0], Vec3<Recorded>(parts[1], parts[2], parts[3])};
}
}  // namespace surfaces

namespace roads {
inline Bend<Recorded> bend(const RoadData&, const Recorded&, const Recorded&) {
  throw NotRecordable("has wheels that roll on a road without slip");
}
inline Place<Recorded> place(const RoadData& road, double footprint, const Recorded& x, const Recorded& y) {
  if (road.over == spec::Road::Over::time) return {0, 0, 0, road.friction};
  const std::vector<Recorded> parts =
      record_call({&road, footprint, static_cast<int>(RecordedCallee::road)}, x, &y, 4);
  return {parts[0], parts[1], parts[2], parts[3]};
}
}  // namespace roads

}  // namespace mimbre
