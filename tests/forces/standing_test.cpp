#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "forces/cart.h"
#include "mimbre/diagnostics.h"
#include "mimbre/statics.h"
#include "support/models.h"
#include "support/simulate.h"

/// Equilibria of cars on tyres that slip: what holds them on a slope, and that they stay there.
namespace mimbre::test::standing_test {
namespace {

const std::string wheels[] = {"fl", "fr", "rl", "rr"};

/// Of a channel of all tyres.
double sum(Simulation& s, const std::string& what) {
  double all = 0;
  for (const std::string& w : wheels) all += channel(s, fmt::format("tyre.{}.{}", w, what));
  return all;
}
double value(const StaticResult& r, const std::string& name) {
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    if (r.channels[k].name == name) return r.values[static_cast<Eigen::Index>(k)];
  ADD_FAILURE() << "no channel " << name;
  return 0;
}
StaticResult statics(const std::string& text, Formulation formulation) {
  RunOptions options;
  options.formulation = formulation;
  return static_equilibrium(model_of(text), options);
}

struct Kind {
  const char* name;
  std::string tyre;

  friend void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }
};
class Standing : public testing::TestWithParam<std::tuple<Kind, Formulation>> {};

/// From the first instant on, on its wheels alone and on swing arms.
TEST_P(Standing, WhatStandsOnASlopeStaysThere) {
  const auto& [kind, formulation] = GetParam();
  for (const bool arms : {false, true}) {
    const double slope = 0.15, weight = 9.81 * (1080 + (arms ? 40 : 0)) / std::hypot(1.0, slope);
    Simulation s = simulation_of(
        cart_text({.tyre = kind.tyre, .more = "initial: equilibrium\n", .slope = slope, .arms = arms}),
        formulation);
    EXPECT_NEAR(sum(s, "longitudinal"), slope * weight, 1e-3);
    EXPECT_NEAR(sum(s, "vertical"), weight, 1e-3);
    const Eigen::Vector3d start(channel(s, "x"), channel(s, "y"), channel(s, "z"));
    double most = 0;
    for (int k = 1; k <= 20; ++k) {
      run_to(s, 0.5 * k);
      const Eigen::Vector3d now(channel(s, "x"), channel(s, "y"), channel(s, "z"));
      most = std::max(most, (now - start).norm());
    }
    EXPECT_LT(most, 1e-6) << (arms ? "on arms" : "on wheels");
    EXPECT_LT(std::abs(channel(s, "energy.numerical")), 1e-6);
  }
}

/// Also of statics without a run, in the other formulation.
TEST_P(Standing, FormulationsAgree) {
  const auto& [kind, formulation] = GetParam();
  const std::string text = cart_text({.tyre = kind.tyre, .slope = 0.15, .arms = true});
  const StaticResult here = statics(text, formulation), there = statics(text, Formulation::relative);
  for (const std::string& w : wheels)
    for (const char* const what : {"vertical", "longitudinal", "lateral"}) {
      const std::string name = fmt::format("tyre.{}.{}", w, what);
      EXPECT_NEAR(value(here, name), value(there, name), 0.01) << name;
    }
}

/// A car that comes down on its arms spreads its wheels. As if it had been rolled there, these do not hold
/// each other: it sinks as on tyres that hold nothing across.
TEST_P(Standing, WheelsDoNotHoldEachOther) {
  const auto& [kind, formulation] = GetParam();
  if (std::string(kind.name) != "brush") return;
  std::string soft = kind.tyre;
  const std::string firm = "cornering_stiffness: 6e4";
  soft.replace(soft.find(firm), firm.size(), "cornering_stiffness: 1e-3");
  const StaticResult held = statics(cart_text({.tyre = kind.tyre, .arms = true}), formulation),
                     free = statics(cart_text({.tyre = soft, .arms = true}), formulation);
  EXPECT_GT(0.6 - value(free, "z"), 0.01);
  EXPECT_NEAR(value(held, "z"), value(free, "z"), 1e-6);
  for (const std::string& w : wheels) EXPECT_NEAR(value(held, "tyre." + w + ".lateral"), 0, 0.1);
}

/// Where the road is no plane the slope changes as the car comes down: it does not go on doing so.
TEST_P(Standing, WhatStandsOnWavesStaysWhereItIsPut) {
  const auto& [kind, formulation] = GetParam();
  std::string waves,
      text = cart_text({.tyre = kind.tyre, .more = "  - {name: pitch, pitch: car}\n", .arms = true});
  for (int k = -40; k <= 40; ++k)
    waves += fmt::format("{}[{}, {}]", k == -40 ? "" : ", ", 0.25 * k, 0.1 * std::sin(0.2 * k));
  const std::string flat = "[-1000, 0], [1000, 0]";
  text.replace(text.find(flat), flat.size(), waves);
  const StaticResult rest = statics(text, formulation);
  // Besides what its height over the road makes of its pitch.
  const double down = value(rest, "x") - value(rest, "z") * std::sin(value(rest, "pitch"));
  EXPECT_LT(down, 0);
  EXPECT_GT(down, -0.006);
}

TEST_P(Standing, WhatNothingHoldsHasNoEquilibrium) {
  const auto& [kind, formulation] = GetParam();
  for (const Cart& cart : {Cart{.tyre = kind.tyre, .slope = 0.15, .brake = 0},
                           Cart{.tyre = kind.tyre, .slope = 0.15, .friction = 0.1}})
    try {
      statics(cart_text(cart), formulation);
      ADD_FAILURE() << "an equilibrium was found";
    } catch (const std::runtime_error& e) {
      EXPECT_NE(std::string(e.what()).find("rolls away"), std::string::npos) << e.what();
    }
}

/// What rolls as it starts is not held by where its wheels were.
TEST_P(Standing, WhatRollsIsNotHeld) {
  const auto& [kind, formulation] = GetParam();
  if (std::string(kind.name) != "brush") return;  // the formula's forces at speed are not those at rest
  Simulation s = simulation_of(
      cart_text({.tyre = kind.tyre, .more = "initial: equilibrium\n", .brake = 0, .speed = 20, .arms = true}),
      formulation);
  for (const std::string& w : wheels) EXPECT_NEAR(channel(s, "tyre." + w + ".lateral"), 0, 1e-3);
  EXPECT_NEAR(sum(s, "vertical"), 1120 * 9.81, 1);
}

INSTANTIATE_TEST_SUITE_P(
    Tyres, Standing,
    testing::Combine(testing::Values(Kind{"brush", brush_of_cart},
                                     Kind{"formula_52", formula_of_cart("car_52.tir")},
                                     Kind{"formula_61", formula_of_cart("car_205_60R15_61.tir")}),
                     testing::Values(Formulation::relative, Formulation::natural)),
    [](const auto& p) {
      return fmt::format("{}_{}", std::get<0>(p.param).name,
                         std::get<1>(p.param) == Formulation::relative ? "relative" : "natural");
    });

}  // namespace
}  // namespace mimbre::test::standing_test
