#pragma once

namespace mimbre::spec {

/// Axis convention, frame a to frame b: revolute and cylindrical about/along z; prismatic along z; universal:
/// first axis x of a, second axis y of b (right angle at zero); planar: translation along x, y of a, rotation
/// about z; pin_slot: translation along x of a, rotation about z. Joint coordinates describe b relative to a,
/// all zero when the frames coincide (spherical, floating: unit quaternion). Velocity coordinates: rates; for
/// spherical the relative angular velocity in b's axes; for floating the origin's velocity in a's axes, then
/// the relative angular velocity in b's axes. `bracket` is `fixed` between flexible bodies (all six static
/// modes); dynamics treats both alike.
enum class JointType {
  fixed,
  bracket,
  revolute,
  prismatic,
  cylindrical,
  universal,
  spherical,
  planar,
  floating,
  pin_slot
};

}  // namespace mimbre::spec
