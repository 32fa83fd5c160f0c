#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// `beam_theory` and the shear areas of sections.
namespace mimbre::test::beam_theory_test {
namespace {

/// A stocky cantilever of steel, 0.1 m × 0.2 m × 1 m, with 10 kN at its tip along z.
std::string cantilever(const std::string& section, const std::string& theory, const std::string& kind) {
  return R"(
gravity: [0, 0, 0]
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {s: )" +
         section + R"(}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: s
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 4)" +
         theory + R"(}}
      clamped: [root]
)" + kind +
         R"(
joints: {wall: {type: fixed, between: [ground, beam], at: [0, 0, 0]}}
loads: {end: {on: beam.tip, force: [0, 0, 1e4]}}
outputs: [{name: z, displacement: beam.tip, relative_to: beam, component: z}]
)";
}

constexpr const char* rectangle_section = "{type: rectangle, width: 0.1, height: 0.2}";
constexpr const char* corotational = "      beam: corotational\n";
constexpr const char* reduced = "      static_modes: [{node: tip, all: true}]\n";

double deflection(const std::string& text, spec::Simulation::Formulation formulation) {
  RunOptions options;
  options.formulation = formulation;
  const StaticResult r = static_equilibrium(model_of(text), options);
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    if (r.channels[k].name == "z") return r.values[static_cast<Eigen::Index>(k)];
  return std::nan("");
}

TEST(BeamTheoryKey, ABarShearsInBothFormulations) {
  constexpr double I = 0.1 * 0.008 / 12, bent = 1e4 / (3 * 2.1e11 * I), G = 2.1e11 / 2.6;
  const double cowper = 1e4 / (G * 0.02 * 13 / 15.3), given = 1e4 / (G * 0.01);
  const std::string areas = "{type: rectangle, width: 0.1, height: 0.2, shear_areas: [0.02, 0.01]}",
                    general =
                        "{area: 0.02, Iy: 6.66666666667e-5, Iz: 2e-5, J: 4e-5, shear_areas: [0.02, 0.01]}",
                    timoshenko = ", beam_theory: timoshenko";
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural})
    for (const char* kind : {reduced, corotational}) {
      const auto z = [&](const std::string& section, const std::string& theory) {
        return deflection(cantilever(section, theory, kind), formulation);
      };
      EXPECT_NEAR(z(rectangle_section, ""), bent, 1e-5 * bent);
      EXPECT_NEAR(z(rectangle_section, ", beam_theory: rayleigh"), bent, 1e-5 * bent);
      EXPECT_NEAR(z(rectangle_section, timoshenko), bent + cowper, 1e-5 * bent);
      EXPECT_NEAR(z(areas, timoshenko), bent + given, 1e-5 * bent);
      EXPECT_NEAR(z(general, timoshenko), bent + given, 1e-5 * bent);
    }
}

std::string error_of(const std::string& text) {
  try {
    model_of(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(BeamTheoryKey, SaysWhatIsMissing) {
  const std::string general = "{area: 0.02, Iy: 1e-4, Iz: 1e-4, J: 1e-4}";
  EXPECT_EQ(error_of(cantilever(general, ", beam_theory: rayleigh", reduced)), "");
  EXPECT_NE(error_of(cantilever(general, ", beam_theory: timoshenko", reduced)).find("shear_areas"),
            std::string::npos);
  EXPECT_NE(error_of(cantilever(rectangle_section, ", beam_theory: timoshenko",
                                "      planar: [0, 1, 0]\n      beam: ancf\n"))
                .find("has shear or rotary inertia"),
            std::string::npos);
  EXPECT_NE(error_of(cantilever(rectangle_section, ", beam_theory: reissner", reduced)).find("timoshenko"),
            std::string::npos);
  EXPECT_NE(
      error_of(cantilever("{type: round, diameter: 0.1, shear_areas: [1]}", "", reduced)).find("two areas"),
      std::string::npos);
}

}  // namespace
}  // namespace mimbre::test::beam_theory_test
