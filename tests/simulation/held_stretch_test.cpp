#include "simulation/watch/held_stretch.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "mimbre/fe_reduce.h"
#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// The watch over what ends that are held do to bending, against closed forms and nonlinear beams.
namespace mimbre::test::held_stretch_test {
namespace {

using std::numbers::pi;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;

// A strip of steel along x.
struct Strip {
  double length = 1, width = 0.02, thickness = 0.002, young = 2.1e11, density = 7850, gravity = 0;
  std::string joints, more,
      options =
          "static_modes: [{node: m, all: true}, {node: e, all: true}]\n      "
          "dynamic_modes: 6";

  double area() const { return width * thickness; }
  double inertia() const { return width * std::pow(thickness, 3) / 12; }
};

Simulation at_rest(const Strip& s) {
  return Simulation(model_of(fmt::format(
      R"(gravity: [0, 0, {}]
materials: {{steel: {{young: {}, poisson: 0.3, density: {}}}}}
sections: {{flat: {{type: rectangle, width: {}, height: {}}}}}
bodies:
  strip:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: steel
      section: flat
      nodes: {{a: [0, 0, 0], m: [{}, 0, 0], e: [{}, 0, 0]}}
      bars: {{x: {{from: a, to: m, elements: 10}}, y: {{from: m, to: e, elements: 10}}}}
      clamped: [a]
      {}
joints:
  start: {}
{}
outputs: [{{name: w, position: strip.m, component: z}}]
initial: equilibrium
)",
      s.gravity, s.young, s.density, s.width, s.thickness, s.length / 2, s.length, s.options, s.joints,
      s.more)));
}

std::string joint(const std::string& type, double at, const std::string& more = "") {
  return fmt::format("{{type: {}, between: [ground, strip], at: [{}, 0, 0]{}}}", type, at, more);
}

Strip pushed(const std::string& end, double force) {
  Strip s;
  s.joints = joint("fixed", 0);
  s.more = (end.empty() ? "" : "  end: " + end + "\n") +
           fmt::format("loads: {{load: {{on: strip.m, force: [0, 0, {}]}}}}", force);
  return s;
}

const std::string fixed = joint("fixed", 1, ", cut: always"),
                  sliding = joint("prismatic", 1, ", axis: [1, 0, 0], cut: always");

double held(const Simulation& s) { return s.validity().at(0).held.value; }
double deflection(Simulation& s) {
  ResultsRow row;
  s.sample(row);
  return row.channels[0];
}

/// α + ρ α³ = 1.
double exaggerated(double ratio) {
  double low = 0, high = 1;
  for (int k = 0; k < 200; ++k) {
    const double a = 0.5 * (low + high);
    (a + ratio * a * a * a < 1 ? low : high) = a;
  }
  return 1 / low - 1;
}

TEST(HeldStretch, ExaggerationSolvesTheCubicEquation) {
  for (const double ratio : {1e-9, 1e-3, 0.1, 1.0, 30.0, 1e6})
    EXPECT_NEAR(HeldStretch::exaggeration({ratio, 1}), exaggerated(ratio), 1e-9 * (1 + exaggerated(ratio)))
        << ratio;
  EXPECT_EQ(HeldStretch::exaggeration({}), 0);
}

TEST(HeldStretch, WhetherItExceedsAgreesWithItsSize) {
  for (const double missing : {0.0, 1e-4, 0.05, 0.3, 5.0})
    for (const double pressed : {1.0, 0.999, 0.9, 0.4})
      for (const double most : {0.0, 1e-5, 0.01, 0.1, 0.24, 1.0, 3.0}) {
        const HeldStretch::Ratios ratios{missing, pressed};
        EXPECT_EQ(HeldStretch::exceeds(ratios, most), std::abs(HeldStretch::exaggeration(ratios)) > most)
            << missing << " " << pressed << " " << most;
      }
}

TEST(HeldStretch, AStripThatIsHeldAtBothEndsBendsLessThanLinear) {
  for (const double force : {0.3, 1.0, 3.0, 10.0}) {
    Simulation linear = at_rest(pushed(fixed, force));
    Strip s = pushed(fixed, force);
    s.options = "beam: corotational";
    Simulation exact = at_rest(s);
    const double error = deflection(linear) / deflection(exact) - 1;
    EXPECT_NEAR(held(linear), error, 0.1 * error + 0.003) << force;
    EXPECT_EQ(held(exact), 0);
    const auto warned =
        Contains(AllOf(HasSubstr("'strip'"), HasSubstr("as it bends"), HasSubstr("foreshortening")));
    if (force > 0.9) {
      EXPECT_THAT(linear.warnings(), warned);
    }
    EXPECT_THAT(exact.warnings(), Not(Contains(HasSubstr("as it bends"))));
  }
}

TEST(HeldStretch, AnEndThatSlidesOrIsFreeHoldsNothing) {
  for (const std::string& end :
       {sliding, joint("cylindrical", 1, ", axis: [1, 0, 0], cut: always"), std::string()}) {
    const Simulation s = at_rest(pushed(end, 1.0));
    EXPECT_TRUE(s.validity().at(0).held.watched);
    EXPECT_LT(held(s), 1e-6) << end;
    EXPECT_THAT(s.warnings(), Each(Not(HasSubstr("as it bends"))));
  }
}

/// What is asked of its modes, by outputs and by signals that a force depends on, changes nothing.
TEST(HeldStretch, IsWatchedWhereOutputsAndSignalsSeeTheModes) {
  const Strip s = pushed(fixed, 3);
  Strip seen = s;
  seen.more = "  end: " + fixed + R"(
actuators:
  push: {between: [ground, strip], at: [0.5, 0, 0], along: [0, 0, 1], force: "3 + 0*bent + 0*now + 0*moment"}
signals:
  bent: {modal_amplitude: strip, component: 15, every: 0.01}
  now: {modal_amplitude: strip, component: 15}
  moment: {section_force: strip, at: [0.5, 0, 0], component: My, every: 0.01}
)";
  const double expected = held(at_rest(s));
  EXPECT_GT(expected, 0.1);
  EXPECT_NEAR(held(at_rest(seen)), expected, 1e-6 * expected);
}

/// The nodes of its surface meet a floor below: the watch needs none of that, and does not mind it.
TEST(HeldStretch, IsWatchedWhereTheSurfaceTouches) {
  const fe::SolidMesh mesh = block(fe::ElementType::hex8, {1, 0.05, 0.01}, {20, 1, 1}, steel());
  fe::ModelReduction options;
  for (const double x : {0.0, 1.0}) {
    fe::Interface end;
    end.name = x == 0 ? "start" : "end";
    end.point = {x, 0.025, 0.005};
    for (int node = 0; node < mesh.nodes.cols(); ++node)
      if (std::abs(mesh.nodes(0, node) - x) < 1e-9) end.nodes.push_back(node);
    options.interfaces.push_back(end);
  }
  options.dynamic_modes = 6;
  options.free_modes = 0;
  const std::string path =
      (std::filesystem::path(testing::TempDir()) / fmt::format("held_surface_{}.h5", getpid())).string();
  save(reduce(mesh, assemble(mesh), options).body, path);
  const auto at_rest = [&](const char* contacts) {
    return Simulation(model_of(fmt::format(R"(gravity: [0, 0, -400]
bodies: {{strip: {{frame: {{at: [0, 0, 0]}}, reduced: {}}}}}
joints:
  start: {{type: fixed, between: [ground, strip.start]}}
  end: {{type: fixed, between: [ground, strip.end], cut: always}}
surfaces: {{floor: {{type: half_space, at: [0, 0, -1]}}}}
{}
initial: equilibrium
)",
                                           path, contacts)));
  };
  const double expected = held(at_rest(""));
  EXPECT_GT(expected, 0.05);
  EXPECT_NEAR(held(at_rest("contacts: {touch: {spheres: {surface_of: strip, radius: 0.005}, surfaces: floor, "
                           "stiffness: 1e5, restitution: 0.3}}")),
              expected, 1e-6 * expected);
  std::filesystem::remove(path);
}

/// The force between the ends goes through the strip and the spring: EA/L over 1 + EA/(L k) of what held ends
/// bear.
TEST(HeldStretch, ASpringHoldsAsItsStiffnessAndTheStripsShareTheStretch) {
  const auto ratio = [](const Simulation& s) {
    const double x = 1 / (1 + held(s));
    return (1 - x) / (x * x * x);
  };
  const double most = ratio(at_rest(pushed(fixed, 3)));
  const Strip strip;
  const double axial = strip.young * strip.area() / strip.length;
  for (const double stiffness : {0.01 * axial, 0.3 * axial, 5 * axial}) {
    Strip s = pushed(sliding, 3);
    s.more += fmt::format(
        "\nbushings: {{spring: {{between: [ground, strip], at: [1, 0, 0], x: [1, 0, 0], stiffness: [{}, 0, "
        "0, "
        "0, 0, 0]}}}}",
        stiffness);
    EXPECT_NEAR(ratio(at_rest(s)), most / (1 + axial / stiffness), 1e-3 * most) << stiffness / axial;
  }
}

/// Between hinges its own weight bends it to v = q/(24 EI) (x⁴ − 2 L x³ + L³ x), of which ½∫v'² = 17/70 L⁷ (q
/// / 24 EI)² and the energy q² L⁵/(240 EI). The body's frame turns with its first end, by v'(0): linear modes
/// know nothing of the former, but of ½ v'(0)² L, by which that frame's x axis is too long.
TEST(HeldStretch, BetweenHingesLinearModesAreTooStiff) {
  Strip s;
  s.joints = joint("revolute", 0, ", axis: [0, 1, 0]");
  s.more = "  end: " + joint("revolute", 1, ", axis: [0, 1, 0], cut: always");
  s.gravity = -0.02;
  const double load = s.density * s.area() * s.gravity, EI = s.young * s.inertia(), L = s.length,
               unit = load / (24 * EI), missing = 17.0 / 70 * std::pow(L, 7) * unit * unit,
               spurious = 0.5 * L * std::pow(unit * L * L * L, 2),
               energy = load * load * std::pow(L, 5) / (240 * EI), axial = s.young * s.area() / L;
  const double expected = axial * (spurious * spurious - missing * missing) / energy;
  EXPECT_GT(expected, 1e-3);
  EXPECT_NEAR(held(at_rest(s)), expected, 0.03 * expected);

  s.gravity = -0.1;
  Simulation linear = at_rest(s);
  s.options = "beam: corotational";
  Simulation exact = at_rest(s);
  const double error = deflection(linear) / deflection(exact) - 1;
  EXPECT_LT(error, -0.02);
  EXPECT_NEAR(held(linear), -error, -0.2 * error);
}

/// The same in millimetres, kilograms and milliseconds.
TEST(HeldStretch, DoesNotDependOnUnits) {
  Strip s = pushed(fixed, 3);
  Strip other = s;
  other.length *= 1e3;
  other.width *= 1e3;
  other.thickness *= 1e3;
  other.young *= 1e-9;    // kg/(mm ms²)
  other.density *= 1e-9;  // kg/mm³
  other.more = "  end: " + joint("fixed", 1e3, ", cut: always") +
               "\nloads: {load: {on: strip.m, force: [0, 0, 3e-3]}}";
  const double expected = held(at_rest(s));
  EXPECT_GT(expected, 0.1);
  EXPECT_NEAR(held(at_rest(other)), expected, 1e-6 * expected);
}

/// Two strips in a row, each of which stretches, as one of the same length does.
TEST(HeldStretch, BodiesInARowShareTheStretch) {
  const auto half = [](double at) {
    return fmt::format(R"(
    frame: {{at: [{0}, 0, 0]}}
    flexible:
      material: steel
      section: flat
      nodes: {{a: [{0}, 0, 0], e: [{1}, 0, 0]}}
      bars: {{x: {{from: a, to: e, elements: 10}}}}
      clamped: [a]
      static_modes: [{{node: e, all: true}}]
      dynamic_modes: 4
)",
                       at, at + 0.5);
  };
  const Simulation s(model_of(R"(gravity: [0, 0, 0]
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {flat: {type: rectangle, width: 0.02, height: 0.002}}
bodies:
  one:)" + half(0) +
                              "  two:" + half(0.5) + R"(joints:
  start: {type: fixed, between: [ground, one], at: [0, 0, 0]}
  middle: {type: fixed, between: [one, two], at: [0.5, 0, 0]}
  end: {type: fixed, between: [ground, two], at: [1, 0, 0], cut: always}
loads: {load: {on: two.a, force: [0, 0, 3]}}
initial: equilibrium
)"));
  const double whole = held(at_rest(pushed(fixed, 3)));
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(s.validity().at(k).held.value, whole, 0.02 * whole) << k;
}

}  // namespace
}  // namespace mimbre::test::held_stretch_test
