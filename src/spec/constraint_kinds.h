#pragma once
#include <array>
#include <string_view>

#include "mimbre/spec.h"

/// The properties of the kinds of constraints besides their equations, which are in src/constraints:
/// the rows here and the cases there have the same order.
namespace mimbre {

struct ConstraintInfo {
  spec::Constraint::Kind kind;
  std::string_view name;  ///< of its type in model files
  int equations = 1;
  unsigned lengths = 0;  ///< bit k: equation k is a length (m), otherwise an angle (rad); of a coupling it is
                         ///< what its coordinates are
  bool force = false, moment = false;  ///< that it may exert on its frames
  int states = 0;                      ///< that it remembers; of a coupling as its coordinates need
};

// clang-format off
constexpr std::array<ConstraintInfo, 9> constraint_table{{
    {spec::Constraint::Kind::coupling, "coupling"},
    {spec::Constraint::Kind::distance, "distance", 1, 0b1, true},
    {spec::Constraint::Kind::on_line, "on_line", 2, 0b11, true},
    {spec::Constraint::Kind::on_plane, "on_plane", 1, 0b1, true},
    {spec::Constraint::Kind::on_curve, "on_curve", 2, 0b11, true, false, 1},
    {spec::Constraint::Kind::parallel, "parallel", 2, 0, false, true},
    {spec::Constraint::Kind::perpendicular, "perpendicular", 1, 0, false, true},
    {spec::Constraint::Kind::constant_velocity, "constant_velocity", 4, 0b0111, true, true},
    {spec::Constraint::Kind::screw, "screw", 5, 0b10011, true, true, 1},
}};
// clang-format on

constexpr const ConstraintInfo& constraint_info(spec::Constraint::Kind kind) {
  return constraint_table[static_cast<std::size_t>(kind)];
}

}  // namespace mimbre
