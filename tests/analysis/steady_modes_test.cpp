#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mimbre/modes.h"
#include "support/models.h"

/// Modes of steady motions: rotors that turn as a whole, blades, tops and wheels, against published figures
/// and closed forms.
namespace mimbre::test::steady_modes_test {
namespace {

LinearisedModes steady_modes(std::shared_ptr<const Model> model) {
  ModesOptions options;
  options.linear.point.at = LinearPoint::At::steady;
  return find_modes(std::move(model), options);
}

/// Frequencies from the ground of oscillating modes, ascending.
std::vector<double> frequencies(const LinearisedModes& found) {
  std::vector<double> out;
  for (const Mode& m : found.modes)
    if (m.kind == Mode::Kind::oscillating) out.push_back(m.seen().imag());
  std::sort(out.begin(), out.end());
  return out;
}

double nearest(const std::vector<double>& all, double to) {
  double best = 1e300;
  for (const double x : all)
    if (std::abs(x - to) < std::abs(best - to)) best = x;
  return best;
}

/// Friswell, Penny, Garvey, Lees, Dynamics of Rotating Machines (2010), with the twist of the shaft. The
/// shaft turns; its coordinates turn with it, and the table is that of the ground.
TEST(SteadyModes, OfARotorOfTwoDiscs) {
  for (const auto& [rpm, published] : std::vector<std::pair<std::string, std::vector<double>>>{
           {"0", {86.66, 86.66, 274.31, 274.31, 650.41, 716.78}},
           {"4000", {85.39, 87.80, 251.78, 294.71, 600.18, 650.41}}}) {
    const LinearisedModes found = steady_modes(example("rotor/two-discs.yaml", {{"rpm", rpm}}));
    EXPECT_TRUE(found.model.warnings.empty());
    const std::vector<double> all = frequencies(found);
    for (const double value : published) EXPECT_NEAR(nearest(all, value), value, 1e-3 * value) << rpm;
    for (const Mode& m : found.modes) EXPECT_FALSE(m.grows);
    // Rotation about the axis alone is free.
    EXPECT_EQ(std::count_if(found.modes.begin(), found.modes.end(),
                            [](const Mode& m) { return m.kind != Mode::Kind::oscillating; }),
              1);
    if (rpm == "0") continue;
    EXPECT_NEAR(found.turning, 4000 * std::numbers::pi / 30, 1e-9);
    for (const Mode& m : found.modes) {
      const double from_ground = m.seen().imag();
      if (std::abs(from_ground - 87.80) < 0.1) {
        EXPECT_GT(m.whirl, 0.99);
      } else if (std::abs(from_ground - 85.39) < 0.1) {
        EXPECT_LT(m.whirl, -0.99);
      }
    }
  }
}

/// A square blade, clamped at a hub of no radius that turns with η √(EI/ρA)/L².
std::string blade(const std::string& stiffening, double eta) {
  const double pace = std::sqrt(1.2e9 * 0.01 * 0.01 / 12 / 1000);
  return fmt::format(R"yaml(
gravity: [0, 0, 0]
materials: {{stuff: {{young: 1.2e9, poisson: 0.3, density: 1000}}}}
sections: {{square: {{type: rectangle, width: 0.01, height: 0.01}}}}
bodies:
  hub: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
  blade:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: stuff
      section: square
      nodes: {{root: [0, 0, 0], tip: [1, 0, 0]}}
      bars: {{all: {{from: root, to: tip, elements: 20}}}}
      clamped: [root]
      dynamic_modes: 12
      stiffening: {}
joints:
  hub: {{type: revolute, between: [ground, hub], at: [0, 0, 0], axis: [0, 0, 1], drive: {{speed: {}}}}}
  root: {{type: fixed, between: [hub, blade], at: [0, 0, 0]}}
)yaml",
                     stiffening, eta * pace);
}

/// Flapping: A. D. Wright, C. E. Smith, R. W. Thresher, J. L. C. Wang, Vibration modes of centrifugally
/// stiffened beams, Journal of Applied Mechanics 49 (1982) 197–202, table 1. In the plane of rotation ω² is
/// smaller by Ω².
TEST(SteadyModes, OfABladeThatTurns) {
  const double pace = std::sqrt(1.2e9 * 0.01 * 0.01 / 12 / 1000);
  const std::vector<std::array<double, 3>> table{{0, 3.5160, 22.0345},
                                                 {3, 4.7973, 23.3203},
                                                 {6, 7.3604, 26.8091},
                                                 {9, 10.2257, 31.7705},
                                                 {12, 13.1702, 37.6031}};
  for (const std::string stiffening : {"geometric_stiffness", "foreshortening",
                                       "nonlinear_stiffness_1\n      axial_modes: {count: 4, end: free}",
                                       "nonlinear_stiffness_2\n      axial_modes: {count: 4, end: free}"})
    for (const auto& [eta, first, second] : table) {
      const LinearisedModes found = steady_modes(model_of(blade(stiffening, eta)));
      EXPECT_TRUE(found.model.warnings.empty()) << stiffening << eta << found.model.warnings.front();
      const std::vector<double> all = frequencies(found);
      for (const double flap : {first, second}) {
        EXPECT_NEAR(nearest(all, flap * pace), flap * pace, 5e-3 * flap * pace)
            << stiffening << " flap " << eta;
        const double lag = std::sqrt(flap * flap - eta * eta);
        EXPECT_NEAR(nearest(all, lag * pace), lag * pace, 5e-3 * lag * pace) << stiffening << " lag " << eta;
      }
    }
}

TEST(SteadyModes, WarnOfABladeThatIsNotStiffened) {
  const LinearisedModes found = steady_modes(model_of(blade("linear", 6)));
  ASSERT_FALSE(found.model.warnings.empty());
  EXPECT_THAT(found.model.warnings.front(), testing::HasSubstr("body 'blade' is beyond linear theory"));
  EXPECT_TRUE(steady_modes(model_of(blade("linear", 0))).model.warnings.empty());
}

/// The same of all beams that stiffen. In pieces the tension acts on their ends; it is missing within linear
/// ones, which then warn.
TEST(SteadyModes, OfABladeOfAnyBeam) {
  const double eta = 12, pace = std::sqrt(1.2e9 * 0.01 * 0.01 / 12 / 1000);
  const auto check = [&](const std::string& keys, bool flaps, bool lags, double share) {
    std::string text = blade("linear", eta);
    if (keys.find("ancf") != std::string::npos) text.replace(text.find("elements: 20"), 12, "elements: 6");
    const std::string modes = "dynamic_modes: 12\n      stiffening: linear";
    text.replace(text.find(modes), modes.size(), keys);
    const LinearisedModes found = steady_modes(model_of(text));
    EXPECT_TRUE(found.model.warnings.empty()) << keys << found.model.warnings.front();
    const std::vector<double> all = frequencies(found);
    for (const double flap : {13.1702, 37.6031}) {
      const double lag = std::sqrt(flap * flap - eta * eta);
      if (flaps) {
        EXPECT_NEAR(nearest(all, flap * pace), flap * pace, share * flap * pace) << keys;
      }
      if (lags) {
        EXPECT_NEAR(nearest(all, lag * pace), lag * pace, share * lag * pace) << keys;
      }
    }
  };
  check("beam: corotational", true, true, 5e-3);
  check("beam: corotational\n      mass_matrix: lumped", true, true, 5e-3);
  check("beam: ancf\n      planar: [0, 1, 0]", true, false, 5e-3);
  check("beam: ancf\n      planar: [0, 0, 1]", false, true, 5e-3);
  check("beam: ancf_cable", true, true, 5e-3);
  check("stiffening: foreshortening\n      substructures: 5\n      dynamic_modes: 4", true, true, 5e-3);
  check("stiffening: geometric_stiffness\n      substructures: 5\n      dynamic_modes: 4", true, true, 5e-3);
  check("stiffening: nonlinear_stiffness_2\n      substructures: 5\n      dynamic_modes: 8", true, true,
        5e-3);
  // Of the second order of the elements' length; lagging, by the difference of squares, three times that.
  check("beam: segments", true, false, 5e-3);
  check("beam: segments", false, true, 15e-3);
  check("beam: stretching_segments", true, true, 6e-3);
}

TEST(SteadyModes, WarnOfLinearPiecesThatStiffen) {
  for (const int pieces : {2, 5, 10}) {
    std::string text = blade("linear", 12);
    const std::string modes = "dynamic_modes: 12";
    text.replace(text.find(modes), modes.size(),
                 fmt::format("substructures: {}\n      dynamic_modes: 2", pieces));
    const LinearisedModes found = steady_modes(model_of(text));
    ASSERT_FALSE(found.model.warnings.empty()) << pieces;
    EXPECT_THAT(found.model.warnings.front(), testing::HasSubstr("stiffening by rotation or tension"));
    EXPECT_THAT(found.model.warnings.front(), testing::HasSubstr("`stiffening: foreshortening` or more"));
  }
}

/// A top that sleeps: seen from the ground its axis circles with (C Ω ± √(C²Ω² − 4 A m g l))/2A (A about the
/// support).
TEST(SteadyModes, OfATopThatSleeps) {
  constexpr double m = 2, l = 0.1, across = 0.03, along = 0.012, spin = 80, g = 9.81;
  const LinearisedModes found = steady_modes(model_of(fmt::format(R"yaml(
gravity: [0, 0, -9.81]
bodies: {{top: {{mass: {}, com: [0, 0, {}], inertia: [{}, {}, {}]}}}}
joints: {{tip: {{type: spherical, between: [ground, top], at: [0, 0, 0], velocity: [0, 0, {}]}}}}
)yaml",
                                                                  m, l, across, across, along, spin)));
  const double A = across + m * l * l, root = std::sqrt(along * along * spin * spin - 4 * A * m * g * l);
  const std::vector<double> all = frequencies(found);
  for (const double sign : {-1, 1}) {
    const double omega = (along * spin + sign * root) / (2 * A);
    EXPECT_NEAR(nearest(all, omega), omega, 1e-9 * omega);
  }
  EXPECT_TRUE(found.model.warnings.empty());
}

/// Too slow, it falls.
TEST(SteadyModes, OfATopThatFalls) {
  constexpr double m = 2, l = 0.1, across = 0.03, along = 0.012, spin = 20, g = 9.81;
  const LinearisedModes found = steady_modes(model_of(fmt::format(R"yaml(
gravity: [0, 0, -9.81]
bodies: {{top: {{mass: {}, com: [0, 0, {}], inertia: [{}, {}, {}]}}}}
joints: {{tip: {{type: spherical, between: [ground, top], at: [0, 0, 0], velocity: [0, 0, {}]}}}}
)yaml",
                                                                  m, l, across, across, along, spin)));
  const double A = across + m * l * l,
               rate = std::sqrt(4 * A * m * g * l - along * along * spin * spin) / (2 * A);
  const auto grows =
      std::find_if(found.modes.begin(), found.modes.end(), [](const Mode& x) { return x.grows; });
  ASSERT_NE(grows, found.modes.end());
  EXPECT_NEAR(grows->value.real(), rate, 1e-9 * rate);
}

/// A gyroscope in gimbals of no mass, its axis upright in the outer one: nutation C Ω/A.
TEST(SteadyModes, OfAGyroscope) {
  const LinearisedModes found = steady_modes(model_of(R"yaml(
gravity: [0, 0, 0]
bodies:
  outer: {mass: 0.1, com: [0, 0, 0], inertia: [0.001, 0.001, 0.002]}
  inner: {mass: 0.1, com: [0, 0, 0], inertia: [0.003, 0.001, 0.002]}
  rotor: {mass: 2, com: [0, 0, 0], inertia: [0.05, 0.03, 0.03]}
joints:
  outer: {type: revolute, between: [ground, outer], at: [0, 0, 0], axis: [0, 0, 1]}
  inner: {type: revolute, between: [outer, inner], at: [0, 0, 0], axis: [0, 1, 0]}
  rotor: {type: revolute, between: [inner, rotor], at: [0, 0, 0], axis: [1, 0, 0], velocity: 200}
)yaml"));
  const double omega = 0.05 * 200 / std::sqrt((0.03 + 0.002 + 0.002) * (0.03 + 0.001));
  const std::vector<double> all = frequencies(found);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_NEAR(all[0], omega, 1e-9 * omega);
}

/// A disc that rolls straight ahead upright: (A + m r²) ω² = (C + m r²) C Ω²/A − m g r. Its velocities are
/// constrained, its positions only in height.
TEST(SteadyModes, OfADiscThatRolls) {
  constexpr double m = 2, r = 0.3, across = 0.05, along = 0.08, g = 9.81;
  for (const double spin : {10., 1.}) {
    const LinearisedModes found = steady_modes(model_of(fmt::format(R"yaml(
bodies: {{disc: {{mass: 2, com: [0, 0, 0.3], inertia: [0.05, 0.08, 0.05]}}}}
joints: {{free: {{type: floating, between: [ground, disc], at: [0, 0, 0.3], velocity: [null, null, null, 0, {}, 0]}}}}
constraints:
  rim: {{type: rolling, between: [ground, disc], at: [[0, 0, 0], [0, 0, 0.3]], axis: [0, 0, 1], axis2: [0, 1, 0], radius: 0.3}}
)yaml",
                                                                    spin)));
    EXPECT_TRUE(found.model.warnings.empty()) << found.model.warnings.front();
    EXPECT_EQ(found.model.coordinates, 5);
    EXPECT_EQ(found.model.speeds, 3);
    const double square =
        ((along + m * r * r) * along * spin * spin / across - m * g * r) / (across + m * r * r);
    std::complex<double> expected = std::sqrt(std::complex<double>(-square)), best = 1e300;
    int moving = 0;
    for (const Mode& mode : found.modes) {
      if (std::abs(mode.value - expected) < std::abs(best - expected)) best = mode.value;
      moving += std::abs(mode.value) > 1e-6 ? 1 : 0;
    }
    EXPECT_LT(std::abs(best - expected), 1e-9 * std::abs(expected)) << spin;
    EXPECT_EQ(moving, square > 0 ? 1 : 2);
  }
}

/// A free chain of masses and springs: ω = 2 √(k/m) sin(j π/2n), and one rigid motion.
TEST(SteadyModes, OfAFreeChain) {
  constexpr int n = 5;
  std::string bodies, joints, springs;
  for (int k = 0; k < n; ++k) {
    bodies += fmt::format("  b{}: {{mass: 3, com: [{}, 0, 0], inertia: [1, 1, 1]}}\n", k, k);
    joints += fmt::format(
        "  j{}: {{type: prismatic, between: [ground, b{}], at: [{}, 0, 0], axis: [1, 0, 0]}}\n", k, k, k);
    if (k > 0)
      springs += fmt::format(
          "  s{}: {{between: [b{}, b{}], at: [[{}, 0, 0], [{}, 0, 0]], elastic: {{stiffness: 700, zero: "
          "1}}}}\n",
          k, k - 1, k, k - 1, k);
  }
  const LinearisedModes found =
      find_modes(model_of("bodies:\n" + bodies + "joints:\n" + joints + "springs:\n" + springs));
  ASSERT_EQ(found.modes.size(), static_cast<std::size_t>(n));
  EXPECT_EQ(found.modes[0].kind, Mode::Kind::rigid);
  for (int j = 1; j < n; ++j) {
    const double omega = 2 * std::sqrt(700. / 3) * std::sin(j * std::numbers::pi / (2 * n));
    EXPECT_NEAR(found.modes[static_cast<std::size_t>(j)].value.imag(), omega, 1e-9 * omega);
  }
}

}  // namespace
}  // namespace mimbre::test::steady_modes_test
