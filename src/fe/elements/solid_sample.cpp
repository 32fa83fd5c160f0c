#include "fe/elements/solid_sample.h"

#include <array>

namespace mimbre::fe {
namespace {

constexpr int kSolidTypes = 8;
using Table = std::array<ShapeSamples, kSolidTypes>;

Table make_table(const Quadrature& (*rule)(ElementType)) {
  Table table;
  for (int t = 0; t < kSolidTypes; ++t) {
    const auto type = static_cast<ElementType>(t);
    table[t] = sample_shapes(type, rule(type));
  }
  return table;
}

}  // namespace

ShapeSamples sample_shapes(ElementType type, const Quadrature& rule) {
  ShapeSamples samples;
  for (const IntegrationPoint& point : rule) {
    ShapeSample sample{point.weight, shape_values(type, point.at), shape_gradients(type, point.at)};
    const int nodes = node_count(type);
    const int extra = incompatible_modes(type);
    sample.gradients.conservativeResize(3, nodes + extra);
    for (int k = 0; k < extra; ++k)
      sample.gradients.col(nodes + k) = -2 * point.at[k] * Eigen::Vector3d::Unit(k);
    samples.push_back(sample);
  }
  return samples;
}

const ShapeSamples& stiffness_samples(ElementType type) {
  static const Table table = make_table(stiffness_quadrature);
  return table.at(static_cast<int>(type));
}

const ShapeSamples& mass_samples(ElementType type) {
  static const Table table = make_table(mass_quadrature);
  return table.at(static_cast<int>(type));
}

const ShapeSamples& stress_samples(ElementType type) {
  static const Table table = make_table(stress_points);
  return table.at(static_cast<int>(type));
}

}  // namespace mimbre::fe
