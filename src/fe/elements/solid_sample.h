#pragma once
#include <vector>

#include "fe/elements/quadrature.h"
#include "fe/elements/solid_shape.h"

/// What an element needs of its type at the points of a rule.
namespace mimbre::fe {

struct ShapeSample {
  double weight;
  ShapeValues values;        ///< of the nodes' functions
  ShapeGradients gradients;  ///< of the nodes' functions, then of the incompatible modes
};
using ShapeSamples = std::vector<ShapeSample>;

/// The 8-node brick has the three incompatible modes 1 − ξ², 1 − η², 1 − ζ².
constexpr int incompatible_modes(ElementType type) { return type == ElementType::hex8 ? 3 : 0; }

ShapeSamples sample_shapes(ElementType type, const Quadrature& rule);

/// Made once per type.
const ShapeSamples& stiffness_samples(ElementType type);
const ShapeSamples& mass_samples(ElementType type);
const ShapeSamples& stress_samples(ElementType type);

}  // namespace mimbre::fe
