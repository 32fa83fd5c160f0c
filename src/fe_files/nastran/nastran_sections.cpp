#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "fe_files/nastran/nastran_model.h"
#include "fe_files/text.h"

// MSC Nastran Quick Reference Guide, PBARL: "Definition of cross section geometry". y is up, z to the left.

namespace mimbre::fe {

namespace {

using Eigen::Vector2d;

struct Shape {
  const char* name;
  std::size_t sizes;
};
constexpr Shape kShapes[] = {{"ROD", 1},   {"TUBE", 2}, {"TUBE2", 2}, {"BAR", 2},  {"BOX", 4},
                             {"BOX1", 6},  {"I", 6},    {"I1", 4},    {"CHAN", 4}, {"CHAN1", 4},
                             {"CHAN2", 4}, {"T", 4},    {"T1", 4},    {"T2", 4},   {"CROSS", 4},
                             {"H", 4},     {"Z", 4},    {"L", 4},     {"HEXA", 3}, {"HAT", 4}};

struct Rectangle {
  double y, z;           ///< of its centre
  double height, width;  ///< along y and z
};

/// J. C. Young, Roark's Formulas: torsion of a rectangle.
double torsion(const Rectangle& r) {
  const double a = std::max(r.height, r.width), b = std::min(r.height, r.width);
  if (!(a > 0)) return 0;
  return a * b * b * b * (1.0 / 3 - 0.21 * b / a * (1 - std::pow(b / a, 4) / 12));
}

NastranSection of_rectangles(const std::vector<Rectangle>& parts) {
  NastranSection s;
  double upright = 0, flat = 0;
  for (const Rectangle& r : parts) {
    if (!(r.height >= 0 && r.width >= 0))
      throw std::invalid_argument("the sizes of the section do not fit each other");
    const double area = r.height * r.width;
    s.area += area;
    s.centroid += area * Vector2d(r.y, r.z);
    s.J += torsion(r);
    (r.height >= r.width ? upright : flat) += area;
  }
  if (!(s.area > 0)) throw std::invalid_argument("the section has no area");
  s.centroid /= s.area;
  for (const Rectangle& r : parts) {
    const double area = r.height * r.width, y = r.y - s.centroid[0], z = r.z - s.centroid[1];
    s.I1 += area * (r.height * r.height / 12 + y * y);
    s.I2 += area * (r.width * r.width / 12 + z * z);
    s.I12 += area * y * z;
    s.reach_y = std::max(s.reach_y, std::abs(y) + r.height / 2);
    s.reach_z = std::max(s.reach_z, std::abs(z) + r.width / 2);
  }
  // The shear along y is carried by what stands upright.
  if (parts.size() == 1) {
    s.shear1 = s.shear2 = 5.0 / 6;
  } else {
    s.shear1 = upright > 0 ? upright / s.area : 5.0 / 6;
    s.shear2 = flat > 0 ? 5.0 / 6 * flat / s.area : 5.0 / 6;
  }
  return s;
}

NastranSection ring(double outer, double inner) {
  if (!(outer > 0 && inner >= 0 && inner < outer))
    throw std::invalid_argument("the radii of the section do not fit each other");
  NastranSection s;
  s.area = std::numbers::pi * (outer * outer - inner * inner);
  s.I1 = s.I2 = std::numbers::pi / 4 * (std::pow(outer, 4) - std::pow(inner, 4));
  s.J = 2 * s.I1;
  s.shear1 = s.shear2 = inner > 0 ? 0.5 : 0.9;
  s.reach_y = s.reach_z = outer;
  s.round = true;
  return s;
}

/// Walls of a box round its outside: `top`, `bottom` thick across y, `left`, `right` across z.
NastranSection box(double width, double height, double top, double bottom, double left, double right) {
  const double inner = height - top - bottom;
  if (!(width > left + right && inner > 0))
    throw std::invalid_argument("the walls of the box are thicker than the box");
  NastranSection s = of_rectangles({{(height - top) / 2, 0, top, width},
                                    {-(height - bottom) / 2, 0, bottom, width},
                                    {(bottom - top) / 2, (width - left) / 2, inner, left},
                                    {(bottom - top) / 2, -(width - right) / 2, inner, right}});
  // Bredt: 4 A² / ∮ ds/t along the middle of the walls.
  const double across = width - (left + right) / 2, up = height - (top + bottom) / 2;
  s.J = 4 * std::pow(across * up, 2) / (across / top + across / bottom + up / left + up / right);
  return s;
}

}  // namespace

std::size_t nastran_shape_sizes(const std::string& shape) {
  std::string all;
  for (const Shape& one : kShapes) {
    if (shape == one.name) return one.sizes;
    all += fmt::format("{}{}", all.empty() ? "" : ", ", one.name);
  }
  throw std::invalid_argument(fmt::format("sections '{}' are not read; there are {}", shown(shape), all));
}

std::optional<Eigen::Vector2d> nastran_shear_centre(const std::string& shape, const std::vector<double>& d) {
  // S. Timoshenko, Strength of Materials II, of thin walls; y, z in the axes of nastran_section.
  const auto of_channel = [](double flange, double height, double flange_wall, double web) {
    const double force = flange * flange_wall;
    return 3 * flange * force / (height * web + 6 * force);  // behind the middle of the web
  };
  for (const char* whole : {"ROD", "TUBE", "TUBE2", "BAR", "BOX", "I1", "CROSS", "H", "Z", "HEXA"})
    if (shape == whole) return Vector2d::Zero();
  if (shape == "I") {
    const double bottom = d[4] * std::pow(d[1], 3), top = d[5] * std::pow(d[2], 3);
    const double low = (d[4] - d[0]) / 2, high = (d[0] - d[5]) / 2;
    return Vector2d((bottom * low + top * high) / (bottom + top), 0);
  }
  if (shape == "CHAN") return Vector2d(0, d[2] / 2 - of_channel(d[0] - d[2] / 2, d[1] - d[3], d[3], d[2]));
  if (shape == "CHAN1")
    return Vector2d(0, d[1] / 2 - of_channel(d[0] + d[1] / 2, (d[2] + d[3]) / 2, (d[3] - d[2]) / 2, d[1]));
  if (shape == "CHAN2") return Vector2d(d[1] / 2 - of_channel(d[2] - d[1] / 2, d[3] - d[0], d[0], d[1]), 0);
  if (shape == "T") return Vector2d(-d[2] / 2, 0);
  if (shape == "T2") return Vector2d(d[2] / 2, 0);
  if (shape == "T1") return Vector2d::Zero();
  if (shape == "L") return Vector2d(d[2] / 2, 0);
  return {};
}

NastranSection nastran_section(const std::string& shape, const std::vector<double>& d) {
  for (const double size : d)
    if (!(size >= 0)) throw std::invalid_argument("the sizes of a section must not be negative");
  if (shape == "ROD") return ring(d[0], 0);
  if (shape == "TUBE") return ring(d[0], d[1]);
  if (shape == "TUBE2") return ring(d[0], d[0] - d[1]);
  if (shape == "BAR") return of_rectangles({{0, 0, d[1], d[0]}});
  if (shape == "BOX") return box(d[0], d[1], d[2], d[2], d[3], d[3]);
  if (shape == "BOX1") return box(d[0], d[1], d[2], d[3], d[4], d[5]);
  if (shape == "I") {  // height, flanges' widths below and above, web, flanges' thicknesses below and above
    const double web = d[0] - d[4] - d[5];
    return of_rectangles({{(d[4] - d[0]) / 2, 0, d[4], d[1]},
                          {(d[0] - d[5]) / 2, 0, d[5], d[2]},
                          {(d[4] - d[5]) / 2, 0, web, d[3]}});
  }
  if (shape == "I1") {  // flanges beyond the web, web, height between the flanges, height
    const double t = (d[3] - d[2]) / 2;
    return of_rectangles(
        {{(d[2] + t) / 2, 0, t, d[0] + d[1]}, {-(d[2] + t) / 2, 0, t, d[0] + d[1]}, {0, 0, d[2], d[1]}});
  }
  if (shape == "CHAN") {  // flanges, height, web, flanges' thickness
    return of_rectangles({{0, d[2] / 2, d[1] - 2 * d[3], d[2]},
                          {(d[1] - d[3]) / 2, d[0] / 2, d[3], d[0]},
                          {(d[3] - d[1]) / 2, d[0] / 2, d[3], d[0]}});
  }
  if (shape == "CHAN1") {  // flanges beyond the web, web, height between the flanges, height
    const double t = (d[3] - d[2]) / 2;
    return of_rectangles({{0, d[1] / 2, d[3], d[1]},
                          {(d[2] + t) / 2, d[1] + d[0] / 2, t, d[0]},
                          {-(d[2] + t) / 2, d[1] + d[0] / 2, t, d[0]}});
  }
  if (shape == "CHAN2") {  // legs, web, height, width
    return of_rectangles({{d[2] / 2, (d[3] - d[0]) / 2, d[2], d[0]},
                          {d[2] / 2, (d[0] - d[3]) / 2, d[2], d[0]},
                          {d[1] / 2, 0, d[1], d[3] - 2 * d[0]}});
  }
  if (shape == "T" || shape == "T2") {  // flange, height, flange's thickness, stem; T2 upside down
    const double side = shape == "T" ? 1 : -1;
    return of_rectangles(
        {{side * -d[2] / 2, 0, d[2], d[0]}, {side * -(d[1] + d[2]) / 2, 0, d[1] - d[2], d[3]}});
  }
  if (shape == "T1") {  // flange's height, stem's length, flange's thickness, stem's
    return of_rectangles({{0, 0, d[0], d[2]}, {0, (d[2] + d[1]) / 2, d[3], d[1]}});
  }
  if (shape == "CROSS") {  // both arms' length, stem's thickness, its height, arms' thickness
    return of_rectangles({{0, 0, d[2], d[1]},
                          {0, (d[1] + d[0] / 2) / 2, d[3], d[0] / 2},
                          {0, -(d[1] + d[0] / 2) / 2, d[3], d[0] / 2}});
  }
  if (shape == "H") {  // between the flanges, both flanges' thickness, their height, web's thickness
    const double at = d[0] / 2 + d[1] / 4;
    return of_rectangles({{0, at, d[2], d[1] / 2}, {0, -at, d[2], d[1] / 2}, {0, 0, d[3], d[0]}});
  }
  if (shape == "Z") {  // flanges beyond the web, web, height between the flanges, height
    const double t = (d[3] - d[2]) / 2, aside = (d[1] + d[0]) / 2;
    return of_rectangles(
        {{0, 0, d[3], d[1]}, {(d[2] + t) / 2, -aside, t, d[0]}, {-(d[2] + t) / 2, aside, t, d[0]}});
  }
  if (shape == "L") {  // width, height, thickness of the flat leg, of the upright one
    return of_rectangles({{d[1] / 2, 0, d[1], d[3]}, {d[2] / 2, -d[0] / 2, d[2], d[0] - d[3]}});
  }
  if (shape == "HAT") {  // height, thickness, width of the top, brims beyond the sides
    const double t = d[1], side = (d[2] - t) / 2, brim = d[3] + t;
    return of_rectangles({{d[0] - t / 2, 0, t, d[2]},
                          {d[0] / 2, side, d[0] - 2 * t, t},
                          {d[0] / 2, -side, d[0] - 2 * t, t},
                          {t / 2, side - t / 2 + brim / 2, t, brim},
                          {t / 2, -(side - t / 2 + brim / 2), t, brim}});
  }
  if (shape == "HEXA") {  // points at the sides, width, height
    const double flat = d[1] - 2 * d[0], h = d[2], point = d[0];
    if (!(flat >= 0 && h > 0 && flat + point > 0))
      throw std::invalid_argument("the sizes of the section do not fit each other");
    NastranSection s;
    s.area = h * (flat + point);
    const double triangle = point * h / 2;
    s.I1 = flat * h * h * h / 12 + 2 * point * h * h * h / 48;
    s.I2 =
        h * flat * flat * flat / 12 + 2 * triangle * (point * point / 18 + std::pow(flat / 2 + point / 3, 2));
    s.J = std::pow(s.area, 4) / (40 * (s.I1 + s.I2));  // Saint-Venant
    s.shear1 = s.shear2 = 5.0 / 6;
    s.reach_y = h / 2;
    s.reach_z = d[1] / 2;
    return s;
  }
  throw std::invalid_argument("this section is not read");
}

}  // namespace mimbre::fe
