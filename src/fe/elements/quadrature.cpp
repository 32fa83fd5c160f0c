#include "fe/elements/quadrature.h"

#include <cmath>
#include <stdexcept>

namespace mimbre::fe {
namespace {

struct LinePoint {
  double at;
  double weight;
};

std::vector<LinePoint> line_rule(int points) {
  if (points == 1) return {{0, 2}};
  if (points == 2) return {{-std::sqrt(1.0 / 3), 1}, {std::sqrt(1.0 / 3), 1}};
  return {{-std::sqrt(0.6), 5.0 / 9}, {0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}};
}

/// The four points with barycentric coordinates (a, a, a, 1 − 3a).
void add_tetrahedron_corners(Quadrature& rule, double a, double weight) {
  const double b = 1 - 3 * a;
  rule.push_back({{a, a, a}, weight});
  rule.push_back({{b, a, a}, weight});
  rule.push_back({{a, b, a}, weight});
  rule.push_back({{a, a, b}, weight});
}

/// The six points with barycentric coordinates (a, a, ½ − a, ½ − a).
void add_tetrahedron_edges(Quadrature& rule, double a, double weight) {
  const double b = 0.5 - a;
  rule.push_back({{a, b, b}, weight});
  rule.push_back({{b, a, b}, weight});
  rule.push_back({{b, b, a}, weight});
  rule.push_back({{b, a, a}, weight});
  rule.push_back({{a, b, a}, weight});
  rule.push_back({{a, a, b}, weight});
}

/// The three points with barycentric coordinates (a, a, 1 − 2a).
void add_triangle_corners(Quadrature& rule, double a, double weight) {
  rule.push_back({{a, a, 0}, weight});
  rule.push_back({{1 - 2 * a, a, 0}, weight});
  rule.push_back({{a, 1 - 2 * a, 0}, weight});
}

/// Exact up to degree 1, 2 (four points) and 5 (14 points; Walkington 2000).
Quadrature tetrahedron_rule(int points) {
  Quadrature rule;
  if (points == 1) {
    rule.push_back({{0.25, 0.25, 0.25}, 1.0 / 6});
  } else if (points == 4) {
    add_tetrahedron_corners(rule, (5 - std::sqrt(5.0)) / 20, 1.0 / 24);
  } else {
    add_tetrahedron_corners(rule, 0.31088591926330060980, 0.018781320953002641800);
    add_tetrahedron_corners(rule, 0.092735250310891226402, 0.012248840519393658257);
    add_tetrahedron_edges(rule, 0.045503704125649649492, 0.0070910034628469110730);
  }
  return rule;
}

Quadrature wedge_rule(int triangle_points, int line_points) {
  Quadrature rule;
  for (const LinePoint& z : line_rule(line_points))
    for (const IntegrationPoint& p : triangle_rule(triangle_points))
      rule.push_back({{p.at.x(), p.at.y(), z.at}, p.weight * z.weight});
  return rule;
}

/// Bricks pressed together towards the apex, with Gauss–Jacobi's rule for the weight (1 − ζ)² along ζ.
Quadrature pyramid_rule(int points_each_way) {
  static const std::vector<LinePoint> two{{0.54415184401122528879, 0.10078588207982543058},
                                          {0.12251482265544137786, 0.23254745125350790274}};
  static const std::vector<LinePoint> three{{0.70500220988849838312, 0.02995070300858069801},
                                            {0.34700376603835188472, 0.14624626925986602200},
                                            {0.07299402407314973215, 0.15713636106488661331}};
  Quadrature rule;
  for (const LinePoint& z : points_each_way == 2 ? two : three)
    for (const IntegrationPoint& p : square_rule(points_each_way))
      rule.push_back({{(1 - z.at) * p.at.x(), (1 - z.at) * p.at.y(), z.at}, p.weight * z.weight});
  return rule;
}

/// Five points, exact up to degree 2.
Quadrature pyramid_corners() {
  const double side = std::sqrt(32.0 / 135);
  Quadrature rule;
  for (const double y : {-side, side})
    for (const double x : {-side, side}) rule.push_back({{x, y, 1.0 / 6}, 9.0 / 32});
  rule.push_back({{0, 0, 0.7}, 5.0 / 24});
  return rule;
}

[[noreturn]] void not_a_solid() { throw std::logic_error("shells have rules of their own"); }

}  // namespace

Quadrature brick_rule(int points_each_way) {
  Quadrature rule;
  for (const LinePoint& z : line_rule(points_each_way))
    for (const IntegrationPoint& p : square_rule(points_each_way))
      rule.push_back({{p.at.x(), p.at.y(), z.at}, p.weight * z.weight});
  return rule;
}

Quadrature square_rule(int points_each_way) {
  Quadrature rule;
  for (const LinePoint& y : line_rule(points_each_way))
    for (const LinePoint& x : line_rule(points_each_way))
      rule.push_back({{x.at, y.at, 0}, x.weight * y.weight});
  return rule;
}

Quadrature triangle_rule(int points) {
  Quadrature rule;
  if (points == 1) {
    rule.push_back({{1.0 / 3, 1.0 / 3, 0}, 0.5});
  } else if (points == 3) {
    add_triangle_corners(rule, 1.0 / 6, 1.0 / 6);
  } else {  // Strang, Fix 1973
    add_triangle_corners(rule, 0.44594849091596488632, 0.11169079483900573285);
    add_triangle_corners(rule, 0.091576213509770743460, 0.054975871827660933819);
  }
  return rule;
}

const Quadrature& stiffness_quadrature(ElementType type) {
  static const Quadrature tet4 = tetrahedron_rule(1), tet10 = tetrahedron_rule(4);
  static const Quadrature hex8 = brick_rule(2), hex20 = brick_rule(3);
  static const Quadrature wedge6 = wedge_rule(1, 2), wedge15 = wedge_rule(3, 3);
  static const Quadrature pyramid5 = pyramid_rule(2), pyramid13 = pyramid_rule(3);
  switch (type) {
    case ElementType::tet4:
      return tet4;
    case ElementType::tet10:
      return tet10;
    case ElementType::hex8:
      return hex8;
    case ElementType::hex20:
      return hex20;
    case ElementType::wedge6:
      return wedge6;
    case ElementType::wedge15:
      return wedge15;
    case ElementType::pyramid5:
      return pyramid5;
    case ElementType::pyramid13:
      return pyramid13;
    default:
      not_a_solid();
  }
}

const Quadrature& mass_quadrature(ElementType type) {
  static const Quadrature tet4 = tetrahedron_rule(4), tet10 = tetrahedron_rule(14);
  static const Quadrature hex = brick_rule(3), wedge = wedge_rule(6, 3);
  static const Quadrature pyramid = pyramid_rule(3);
  switch (type) {
    case ElementType::tet4:
      return tet4;
    case ElementType::tet10:
      return tet10;
    case ElementType::hex8:
    case ElementType::hex20:
      return hex;
    case ElementType::wedge6:
    case ElementType::wedge15:
      return wedge;
    case ElementType::pyramid5:
      return pyramid;
    case ElementType::pyramid13:
      return pyramid;
    default:
      not_a_solid();
  }
}

const Quadrature& stress_points(ElementType type) {
  static const Quadrature tet4 = tetrahedron_rule(1), tet10 = tetrahedron_rule(4);
  static const Quadrature hex = brick_rule(2);
  static const Quadrature wedge6 = wedge_rule(1, 2), wedge15 = wedge_rule(3, 2);
  static const Quadrature pyramid5{{{0, 0, 0.25}, 4.0 / 3}}, pyramid13 = pyramid_corners();
  switch (type) {
    case ElementType::tet4:
      return tet4;
    case ElementType::tet10:
      return tet10;
    case ElementType::hex8:
    case ElementType::hex20:
      return hex;
    case ElementType::wedge6:
      return wedge6;
    case ElementType::wedge15:
      return wedge15;
    case ElementType::pyramid5:
      return pyramid5;
    case ElementType::pyramid13:
      return pyramid13;
    default:
      not_a_solid();
  }
}

}  // namespace mimbre::fe
