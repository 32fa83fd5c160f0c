#pragma once
#include <algorithm>

#include "constraints/equation_context.h"
#include "math/space_curve.h"

namespace mimbre::constraints {

/// The origin of b lies on the curve of a.
struct OnCurve {
  static void check(const spec::Constraint& c, ConstraintInfo::Faults& faults) {
    const std::size_t least = c.closed ? 3 : 2, count = c.points.size();
    if (count < least) {
      faults.push_back(fmt::format("has {} points; {} curve needs {} at least", count,
                                   c.closed ? "a closed" : "an open", least));
      return;
    }
    if (!std::all_of(c.points.begin(), c.points.end(), [](const auto& p) { return p.allFinite(); })) {
      faults.emplace_back("a point of the curve is not finite");
      return;
    }
    double extent = 0;
    for (const Eigen::Vector3d& p : c.points) extent = std::max(extent, (p - c.points.front()).norm());
    for (std::size_t k = c.closed ? 0 : 1; k < count; ++k) {
      const std::size_t before = k > 0 ? k - 1 : count - 1;
      if (!((c.points[k] - c.points[before]).norm() > 1e-9 * extent))
        faults.push_back(
            fmt::format("points {} and {} of the curve are at one place{}", before, k,
                        k == 0 ? "; a closed curve returns to its first point automatically" : ""));
    }
  }
  static void compile(const spec::Constraint& s, ConstraintData& data) {
    data.curve = space_curve(s.points, s.closed);
  }
  static void start(const ConstraintData& data, const Eigen::Vector3d& apart, double* states) {
    states[0] = nearest_on(data.curve, apart);
  }
  static constexpr ConstraintInfo info{.name = "on_curve",
                                       .equations = 2,
                                       .lengths = 0b11,
                                       .force = true,
                                       .states = 1,
                                       .curve = true,
                                       .check = check,
                                       .compile = compile,
                                       .start = start};

  /// b's origin d on a curve c(s) of a: what leads from its nearest point to it, e = d − c(s) with c' · e =
  /// 0, has no component along two directions n(s) across the curve, Φ = n · e. From c' · e = 0
  ///
  ///     ṡ = c' · u / (c' · c' − e · c'')
  ///     Φ̇ = n · u + (n' · e) ṡ                    since n · c' = 0 at most up to the size of e
  ///
  /// so that with g = n' · e − n · c'
  ///
  ///     Φ̈ = n · u̇ + g s̈ + (2 n' · u) ṡ + (n'' · e − 2 n' · c' − n · c'') ṡ²
  ///     s̈ = (c' · u̇ + 2 c'' · u ṡ + (e · c''' − 3 c' · c'') ṡ²) / (c' · c' − e · c'')
  ///
  /// of which e · c''' ṡ² is left out: g and e vanish where Φ does. The state is s at the start of the step,
  /// near which the nearest point is looked for.
  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    const RelativeMotion<T>& r = c.motion;
    CurvePoint<T> at;
    const T s = nearest_near<T>(c.data.curve, r.displacement, c.states[0], at);
    const Vec3<T>&c1 = at.first[0], &c2 = at.second[0];
    const Vec3<T> e = r.displacement - at.value[0], &u = r.velocity;
    const T speed = c1.squaredNorm(), bend = speed - e.dot(c2);
    // At a centre of curvature all points are as near: any of them, far from where Φ vanishes.
    const T stretch = select(bend * bend > T(1e-6) * speed * speed, bend, speed);
    const T rate = c1.dot(u) / stretch;
    const T own = (T(2) * c2.dot(u) * rate - T(3) * c1.dot(c2) * rate * rate) / stretch;
    for (int k = 0; k < 2; ++k) {
      const Vec3<T>&n = at.value[1 + k], &n1 = at.first[1 + k], &n2 = at.second[1 + k];
      const T g = n1.dot(e) - n.dot(c1);
      out[k].value = n.dot(e);
      out[k].linear = n + (g / stretch) * c1;
      out[k].angular.setZero();
      out[k].bias =
          g * own + T(2) * n1.dot(u) * rate + (n2.dot(e) - T(2) * n1.dot(c1) - n.dot(c2)) * rate * rate;
    }
    c.next[0] = s;
  }
};

}  // namespace mimbre::constraints
