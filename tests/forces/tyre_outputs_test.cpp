#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "forces/cart.h"
#include "mimbre/diagnostics.h"
#include "support/models.h"
#include "support/simulate.h"

/// What tyres do as outputs, and as what signals sample.
namespace mimbre::test::tyre_outputs_test {
namespace {

/// Key and component of an output, the channel that says the same, its unit.
struct Said {
  std::string key, component, channel, unit;
};
const std::array said{
    Said{"tyre_force", "", "vertical", "N"},
    Said{"tyre_force", "vertical", "vertical", "N"},
    Said{"tyre_force", "longitudinal", "longitudinal", "N"},
    Said{"tyre_force", "lateral", "lateral", "N"},
    Said{"tyre_moment", "overturning", "overturning", "N m"},
    Said{"tyre_moment", "rolling", "rolling", "N m"},
    Said{"tyre_moment", "aligning", "aligning", "N m"},
    Said{"tyre_slip", "", "slip", "1"},
    Said{"tyre_slip_angle", "", "slip_angle", "rad"},
    Said{"tyre_camber", "", "camber", "rad"},
    Said{"tyre_deflection", "", "deflection", "m"},
};

std::string field(const Said& s, const std::string& tyre) {
  return s.key + ": " + tyre + (s.component.empty() ? "" : ", component: " + s.component);
}

class TyreOutputs : public testing::TestWithParam<Formulation> {};

/// While it brakes in a skid, each is the channel, and what is sampled that of the last instant.
TEST_P(TyreOutputs, AreTheChannels) {
  for (const std::string& tyre : {brush_of_cart, formula_of_cart("car_205_60R15_61.tir")}) {
    std::string outputs, signals = "signals:\n";
    for (std::size_t k = 0; k < said.size(); ++k) {
      outputs += fmt::format("  - {{name: o{}, {}}}\n", k, field(said[k], "fl"));
      signals += fmt::format("  s{}: {{{}, every: 0.02}}\n", k, field(said[k], "fl"));
    }
    std::string text =
        cart_text({.tyre = tyre, .more = outputs + signals, .brake = 600, .speed = 15, .arms = true});
    const std::string straight = "velocity: [15, 0, 0, 0, 0, 0]";
    text.replace(text.find(straight), straight.size(), "velocity: [15, 1.5, 0, 0, 0, 0.3]");
    Simulation s = simulation_of(text, GetParam());
    run_to(s, 0.38);
    std::array<double, said.size()> sampled{};
    for (int k = 0; k < 8; ++k) {
      // Within half a step of round-off an instant is due.
      if (std::abs(std::remainder(s.time(), 0.02)) < 1e-9)
        for (std::size_t i = 0; i < said.size(); ++i) sampled[i] = channel(s, fmt::format("o{}", i));
      ASSERT_TRUE(s.step().ok());
      for (std::size_t i = 0; i < said.size(); ++i) {
        const double here = channel(s, fmt::format("o{}", i));
        EXPECT_EQ(here, channel(s, "tyre.fl." + said[i].channel)) << said[i].channel;
        EXPECT_EQ(channel(s, fmt::format("signal.s{}", i)), sampled[i]) << said[i].channel;
      }
    }
    EXPECT_LT(channel(s, "o7"), -1e-3);  // it brakes,
    EXPECT_LT(channel(s, "o2"), -100);
    EXPECT_GT(std::abs(channel(s, "o8")), 0.003);  // goes askew
    EXPECT_GT(std::abs(channel(s, "o3")), 100);
    EXPECT_GT(channel(s, "o10"), 1e-3);  // and carries
    for (const ChannelInfo& c : s.channels())
      if (c.name[0] == 'o' && c.name[1] >= '0' && c.name[1] <= '9') {
        EXPECT_EQ(c.unit, said[static_cast<std::size_t>(std::stoi(c.name.substr(1)))].unit) << c.name;
      }
  }
}

INSTANTIATE_TEST_SUITE_P(Both, TyreOutputs, testing::Values(Formulation::relative, Formulation::natural));

std::string told(const std::string& text) {
  try {
    model_of(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

/// A wheel of the size L under the same gravity, drawn along and driven: speeds grow with √L, forces with L³.
std::string drawn_wheel(double L) {
  return fmt::format(R"y(
parameters: {{L: {:.17g}}}
bodies:
  slide: {{mass: 10*L^3, com: [0, 0, L], inertia: [L^5, L^5, L^5]}}
  steered: {{mass: 10*L^3, com: [0, 0, L], inertia: [L^5, L^5, L^5]}}
  wheel: {{mass: 10*L^3, com: [0, 0, L], inertia: [L^5, L^5, L^5]}}
joints:
  rail: {{type: prismatic, between: [ground, slide], at: [0, 0, L], axis: [1, 0, 0], drive: {{position: "0.7*sqrt(L)*t"}}}}
  turned: {{type: revolute, between: [slide, steered], at: [0, 0, L], axis: [0, 0, 1], drive: {{position: "0.05"}}}}
  axle: {{type: revolute, between: [steered, wheel], at: [0, 0, L], axis: [0, 1, 0], drive: {{speed: "0.8/sqrt(L)"}}}}
roads: {{track: {{over: distance, points: [[-1000, 0], [1000, 0]]}}}}
tyres: {{t: {{on: wheel, at: [0, 0, L], road: track, model: brush, radius: 1.02*L, stiffness: 2e5*L^2, damping: 500*L^2.5,
  longitudinal_stiffness: 8e4*L^3, cornering_stiffness: 6e4*L^3, friction: 1, longitudinal_relaxation: 0.3*L,
  lateral_relaxation: 0.5*L, half_length: 0.08*L, load: 3000*L^3}}}}
outputs:
  - {{name: slip, tyre_slip: t}}
  - {{name: angle, tyre_slip_angle: t}}
simulation: {{step: 0.01*sqrt(L), end: 2*sqrt(L)}}
)y",
                     L);
}

/// No speed is slow by itself: a toy's wheel slips as that of a car does.
TEST(TyreOutputsOfSimilarWheels, AreTheSame) {
  const auto slips = [](double L) {
    Simulation s = simulation_of(drawn_wheel(L), Formulation::relative);
    run_to(s, std::sqrt(L));
    return std::array{channel(s, "slip"), channel(s, "angle")};
  };
  const auto [slip, angle] = slips(1);
  EXPECT_NEAR(slip, 0.15, 0.03);
  EXPECT_NEAR(angle, -0.05, 1e-3);
  for (const double L : {1e-4, 1e-2, 1e2}) {
    EXPECT_NEAR(slips(L)[0], slip, 1e-6) << L;
    EXPECT_NEAR(slips(L)[1], angle, 1e-6) << L;
  }
}

TEST(TyreOutputsFile, SaysWhatIsWrong) {
  const auto with = [](const std::string& output, const std::string& tyre = brush_of_cart) {
    return told(cart_text({.tyre = tyre, .more = "  - {name: o, " + output + "}\n"}));
  };
  EXPECT_EQ(with("tyre_slip: fl"), "");
  EXPECT_NE(with("tyre_moment: fl").find("component"), std::string::npos);
  EXPECT_NE(with("tyre_slip: fl, component: lateral").find("'tyre_slip' has no component"),
            std::string::npos);
  EXPECT_NE(with("tyre_force: fl, component: sideways").find("lateral"), std::string::npos);
  EXPECT_NE(with("tyre_slip: fx").find("fx"), std::string::npos);
  const std::string carrier = "stiffness: 2e5, radius: 0.32";
  EXPECT_EQ(with("tyre_force: fl", carrier), "");
  EXPECT_NE(with("tyre_slip: fl", carrier).find("only carries"), std::string::npos);
  EXPECT_NE(with("tyre_force: fl, component: lateral", carrier).find("only carries"), std::string::npos);
  // What forces decide is seen at instants.
  EXPECT_NE(told(cart_text({.tyre = brush_of_cart,
                            .more = "signals: {slip: {tyre_slip: fl}}\nactuators: {a: {joint: fl, torque: "
                                    "slip}}\n"}))
                .find("every"),
            std::string::npos);
}

}  // namespace
}  // namespace mimbre::test::tyre_outputs_test
