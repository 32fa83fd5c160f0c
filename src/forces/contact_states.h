#pragma once

/// What a contact remembers from step to step; vectors are in the surface's axes.
namespace mimbre::contact_states {

constexpr int gap = 0;     ///< m; negative: they touch
constexpr int place = 1;   ///< 3: of the sphere's centre
constexpr int turn = 4;    ///< 4: unit quaternion of the sphere's frame; while they touch
constexpr int speed = 8;   ///< rate of the gap
constexpr int impact = 9;  ///< speed of the last impact, m/s
constexpr int bend = 10;   ///< 3: of the bristles, m
constexpr int pull = 13;   ///< 3: tangential force, N
// Where it resists turning, also:
constexpr int twist = 16;   ///< 3: of the bristles, rad
constexpr int moment = 19;  ///< 3: N m

}  // namespace mimbre::contact_states
