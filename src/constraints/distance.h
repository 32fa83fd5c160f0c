#pragma once
#include <fmt/format.h>

#include "constraints/equation_context.h"
#include "spec/nearest_place.h"

namespace mimbre::constraints {

/// Between the origins of both frames.
struct Distance {
  static constexpr std::array<LawNumber, 1> numbers{
      {{.key = "length", .unit = "m", .about = "between the points", .above = 0}}};
  /// As assembled.
  static void complete(const Eigen::Vector3d& a, const Eigen::Vector3d& b, std::vector<double>& given) {
    if (std::isnan(given[0])) given[0] = at_one_place(a, b) ? 0.0 : (b - a).norm();
  }
  static void check(const spec::Constraint& c, ConstraintInfo::Faults& faults) {
    if (c.numbers[0] == 0)
      faults.emplace_back(
          "length is 0, which has no direction: type: spherical under 'joints' holds two points together");
  }
  static constexpr ConstraintInfo info{.name = "distance",
                                       .equations = 1,
                                       .lengths = 0b1,
                                       .force = true,
                                       .numbers = numbers,
                                       .two_places = true,
                                       .complete = complete,
                                       .check = check};

  /// Half of what the square of the distance exceeds that of `length` by, over it: the distance itself to
  /// first order, and smooth where both points meet.
  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    const RelativeMotion<T>& r = c.motion;
    const T length = c.number(0);
    ScalarEquation<T>& e = out[0];
    e.value = T(0.5) * (r.displacement.squaredNorm() / length - length);
    e.linear = r.displacement / length;
    e.angular.setZero();
    e.bias = r.velocity.squaredNorm() / length;
  }
};

}  // namespace mimbre::constraints
