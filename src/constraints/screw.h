#pragma once
#include <numbers>

#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// b turns about a's z and moves along it by the lead for each turn.
struct Screw {
  static constexpr std::array<LawNumber, 1> numbers{
      {{.key = "lead", .unit = "m", .about = "for each turn, right-handed where positive"}}};
  static void check(const spec::Constraint& c, ConstraintInfo::Faults& faults) {
    if (c.numbers[0] == 0)
      faults.emplace_back("lead is 0, so that it never moves along its axis; a revolute joint does that");
  }
  /// Its number becomes m/rad.
  static void compile(const spec::Constraint& s, ConstraintData& data) {
    data.numbers.push_back(s.numbers[0] / (2 * std::numbers::pi));
  }
  static constexpr ConstraintInfo info{.name = "screw",
                                       .equations = 5,
                                       .lengths = 0b10011,
                                       .force = true,
                                       .moment = true,
                                       .states = 1,
                                       .numbers = numbers,
                                       .handed = 0b1,
                                       .axes = 1,
                                       .check = check,
                                       .compile = compile};

  /// The state is the angle.
  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    const RelativeMotion<T>& r = c.motion;
    out[0] = along_axis<T>(r, 0);
    out[1] = along_axis<T>(r, 1);
    out[2] = axes_product<T>(r, 0, 2);
    out[3] = axes_product<T>(r, 1, 2);
    const ScalarEquation<T> turn = coordinate<T>(spec::JointType::cylindrical, 2, 0, r, nullptr, c.states[0]);
    c.next[0] = turn.value;
    out[4] = along_axis<T>(r, 2) - c.number(0) * turn;
  }
};

}  // namespace mimbre::constraints
