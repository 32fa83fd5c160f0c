#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mimbre/modes.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// Models that are alike but for their size and mass have the same modes and rest alike.
namespace mimbre::test::similar_models_test {
namespace {

/// A body on a bushing, with a beam on a ball joint that another bushing holds. Lengths by `size`, masses by
/// its cube times `mass`, times as they are.
std::string carried_beam(const std::string& how, double size, double mass) {
  const double m = mass * size * size * size, k = m, t = m * size * size;
  const bool nonlinear = how.starts_with("beam");
  return fmt::format(
      R"(
gravity: [0, 0, {}]
materials: {{soft: {{young: {}, poisson: 0.3, density: {}}}}}
sections: {{round: {{type: round, diameter: {}}}}}
bodies:
  a: {{mass: {}, com: [0, 0, 0], inertia: [{}, {}, {}]}}
  b:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: soft
      section: round
      nodes: {{root: [0, 0, 0], tip: [{}, 0, 0]}}
      bars: {{bar: {{from: root, to: tip, elements: 4}}}}
      clamped: [root]
      {}{}
joints:
  j: {{type: floating, between: [ground, a]}}
  k: {{type: spherical, between: [a, b], at: [0, 0, 0]}}
bushings:
  h: {{between: [ground, a], at: [0, 0, 0], stiffness: [{}, {}, {}, {}, {}, {}]}}
  g: {{between: [ground, b], at: [{}, 0, 0], stiffness: [{}, {}, {}, {}, {}, {}]}}
outputs: [{{name: z, position: b.tip, component: z}}]
)",
      -9.81 * size, 2e9 * mass * size * size, 1200 * mass, 0.02 * size, m, 0.01 * t, 0.01 * t, 0.01 * t,
      0.5 * size, nonlinear ? "" : "static_modes: [{node: tip, all: true}]\n      dynamic_modes: 2\n      ",
      how, 500 * k, 600 * k, 700 * k, 10 * t, 12 * t, 14 * t, 0.5 * size, 500 * k, 600 * k, 700 * k, 10 * t,
      12 * t, 14 * t);
}

TEST(SimilarModels, HaveTheSameModesAndRestAlike) {
  for (const char* how :
       {"stiffening: linear", "stiffening: foreshortening", "stiffening: geometric_stiffness",
        "beam: corotational", "beam: ancf_cable", "beam: segments"}) {
    ModesOptions options;
    options.linear.point.at = LinearPoint::At::equilibrium;
    const auto first = model_of(carried_beam(how, 1, 1));
    const LinearisedModes expected = find_modes(first, options);
    const double place = static_equilibrium(first).values[0];
    for (const double size : {1e2, 1e-1, 1e-2, 1e-3})
      for (const double mass : {1.0, 1e-3, 1e3}) {
        SCOPED_TRACE(fmt::format("{}, size {}, mass {}", how, size, mass));
        const auto model = model_of(carried_beam(how, size, mass));
        EXPECT_NEAR(static_equilibrium(model).values[0] / size, place, 1e-6 * std::abs(place));
        const LinearisedModes found = find_modes(model, options);
        ASSERT_EQ(found.modes.size(), expected.modes.size());
        for (std::size_t k = 0; k < 6; ++k)
          EXPECT_NEAR(std::abs(found.modes[k].value), std::abs(expected.modes[k].value),
                      1e-5 * std::abs(expected.modes[k].value));
      }
  }
}

}  // namespace
}  // namespace mimbre::test::similar_models_test
