#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// A strip on edge that a force at its tip lets tip over sideways.
namespace mimbre::test::lateral_stability_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Formulation = spec::Simulation::Formulation;

/// 1 m long, 0.1 m high, 2 mm thick: so thin that how far it bends before does not matter.
constexpr double young = 2.1e11, poisson = 0.3, thin = 0.1 * 8e-9 / 12, high = 2e-3 * 1e-3 / 12,
                 twist = 0.1 * 8e-9 / 3;

std::string strip(const std::string& method, double force) {
  return R"(
gravity: [0, 0, 0]
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {strip: {area: 2e-4, Iy: )" +
         std::to_string(high * 1e9) + "e-9, Iz: " + std::to_string(thin * 1e12) +
         "e-12, J: " + std::to_string(twist * 1e12) + R"(e-12}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: strip
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 16, y: [0, 1, 0]}}
      clamped: [root]
)" + method +
         R"(
joints: {wall: {type: bracket, between: [ground, beam], at: [0, 0, 0]}}
loads: {end: {on: beam.tip, force: [0, 0, )" +
         std::to_string(force) + R"(]}}
outputs: [{name: uz, displacement: beam.tip, relative_to: beam, component: z}]
)";
}

const std::string corotational = "      beam: corotational\n",
                  geometric =
                      "      static_modes: [{node: tip, along: [0, 0, 1]}]\n"
                      "      dynamic_modes: 16\n      stiffening: geometric_stiffness\n";

struct Case {
  const char* name;
  const std::string& method;
  Formulation formulation;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class LateralStability : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Methods, LateralStability,
                         testing::Values(Case{"corotational", corotational, Formulation::relative},
                                         Case{"geometric_stiffness", geometric, Formulation::relative},
                                         Case{"geometric_stiffness_natural", geometric,
                                              Formulation::natural}),
                         [](const auto& p) { return p.param.name; });

/// P = 4.0126 √(EI GJ)/L² (Prandtl 1899), either way.
TEST_P(LateralStability, OfACantileverIsLostAtPrandtlsLoad) {
  RunOptions options;
  options.formulation = GetParam().formulation;
  const double critical = 4.0126 * young * std::sqrt(thin * twist / (2 * (1 + poisson)));
  for (const double part : {0.99, -0.99, 1.01, -1.01}) {
    const StaticResult r = static_equilibrium(model_of(strip(GetParam().method, part * critical)), options);
    EXPECT_EQ(r.stable, std::abs(part) < 1) << part;
    if (r.stable)
      EXPECT_THAT(r.warnings, IsEmpty());
    else
      EXPECT_THAT(r.warnings, testing::Contains(HasSubstr("unstable")));
    EXPECT_NEAR(r.values[0], part * critical / (3 * young * high), 1e-3 * critical / (3 * young * high));
  }
}

/// Without stress that stiffens or softens, nothing buckles.
TEST(LateralStability, LinearBodiesKnowNothingOfIt) {
  const std::string linear = "      static_modes: [{node: tip, along: [0, 0, 1]}]\n      dynamic_modes: 4\n";
  EXPECT_TRUE(static_equilibrium(model_of(strip(linear, 400))).stable);
}

}  // namespace
}  // namespace mimbre::test::lateral_stability_test
