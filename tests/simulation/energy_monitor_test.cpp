#include "simulation/watch/energy_monitor.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// The watch over what the numerics do to the energy.
namespace mimbre::test::energy_monitor_test {
namespace {

using std::numbers::pi;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Simulation after(const std::shared_ptr<const Model>& model, double step, double end) {
  RunOptions options;
  options.step = step;
  Simulation s(model, options);
  const int steps = static_cast<int>(std::lround(end / step));
  for (int k = 0; k < steps; ++k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      break;
    }
  }
  return s;
}

/// A mass of 1 kg on a spring without damping, let go 0.1 m from rest.
std::shared_ptr<const Model> oscillator(double stiffness) {
  return model_of(fmt::format(R"(
gravity: [0, 0, 0]
bodies: {{a: {{mass: 1, com: [0, 0, 1], inertia: [1, 1, 1]}}}}
joints:
  slide:
    type: prismatic
    between: [ground, a]
    at: [0, 0, 1]
    axis: [0, 0, 1]
    position: 0.1
    spring: {{stiffness: {}, damping: 0}}
)",
                              stiffness));
}

/// Ten periods with so many steps each.
Simulation ten_periods(int steps) {
  const double period = 0.2;
  return after(oscillator(4 * pi * pi / (period * period)), period / steps, 10 * period);
}

TEST(EnergyMonitor, NumericalDampingIsNamedWithWhatItDamps) {
  for (const int steps : {1, 2, 4, 10}) {
    const Simulation s = ten_periods(steps);
    EXPECT_LT(s.energy().numerical, -0.01 * 0.5 * pi * pi) << steps;  // of ½ k 0.1²
    EXPECT_THAT(s.warnings(), ElementsAre(AllOf(HasSubstr("took out"), HasSubstr("joint 'slide'")))) << steps;
  }
  EXPECT_THAT(ten_periods(100).warnings(), IsEmpty());
}

/// The same ratios at any size: a spring of 10⁶ times the energy, and one of a millionth.
TEST(EnergyMonitor, SizeDoesNotMatter) {
  for (const double scale : {1e6, 1e-3}) {
    const double stiffness = 1000 * scale, period = 2 * pi / std::sqrt(stiffness);
    EXPECT_THAT(after(oscillator(stiffness), period / 10, 10 * period).warnings(),
                ElementsAre(HasSubstr("took out")));
    EXPECT_THAT(after(oscillator(stiffness), period / 100, 10 * period).warnings(), IsEmpty());
  }
}

/// The same on a cart that has far more energy.
TEST(EnergyMonitor, ATravellingWholeHidesNoVibration) {
  const auto cart = [](double step) {
    return after(model_of(R"(
gravity: [0, 0, 0]
bodies: {cart: {mass: 1000, com: [0, 0, 0], inertia: [1, 1, 1]}, a: {mass: 1, com: [0, 0, 1], inertia: [1, 1, 1]}}
joints:
  roll: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0], velocity: 6}
  slide: {type: prismatic, between: [cart, a], at: [0, 0, 1], axis: [0, 0, 1], position: 0.1, spring: {stiffness: 1000}}
)"),
                 step, 2)
        .warnings();
  };
  EXPECT_THAT(cart(0.02), ElementsAre(AllOf(HasSubstr("took out"), HasSubstr("joint 'slide'"))));
  EXPECT_THAT(cart(0.002), IsEmpty());
}

/// Beside a damper that takes the energy anyway nothing is lost that matters.
TEST(EnergyMonitor, LittleBesideDampersIsInOrder) {
  const auto damped = model_of(R"(
gravity: [0, 0, 0]
bodies: {a: {mass: 1, com: [0, 0, 1], inertia: [1, 1, 1]}}
joints:
  slide: {type: prismatic, between: [ground, a], at: [0, 0, 1], axis: [0, 0, 1], position: 0.1, spring: {stiffness: 1000, damping: 12}}
)");
  const Simulation s = after(damped, 0.05, 3);  // of 0.2 s: alone it would lose nearly all of 5 J
  EXPECT_LT(s.energy().numerical, 0);
  EXPECT_NEAR(s.energy().dissipated, 5, 0.5);
  EXPECT_THAT(s.warnings(), IsEmpty());
}

/// A mass between two springs that press against each other with far more energy than it has itself.
TEST(EnergyMonitor, PrestressIsNoGain) {
  for (const double stiffness : {1e4, 1e8, 1e12})
    EXPECT_THAT(after(model_of(fmt::format(R"(
bodies: {{a: {{mass: 1, com: [0, 0, 1], inertia: [1, 1, 1]}}}}
joints: {{slide: {{type: prismatic, between: [ground, a], at: [0, 0, 1], axis: [0, 0, 1]}}}}
springs:
  below: {{between: [ground, a], at: [[0, 0, 0], [0, 0, 1]], elastic: {{stiffness: {0}, zero: 1.1}}}}
  above: {{between: [ground, a], at: [[0, 0, 2], [0, 0, 1]], elastic: {{stiffness: {0}, zero: 1.1}}}}
initial: equilibrium
)",
                                           stiffness)),
                      0.01, 1)
                    .warnings(),
                IsEmpty())
        << stiffness;
}

/// A pendulum's loss of 3e-5 J beside a spring that a constraint holds at rest: no share of the round-off in
/// it.
TEST(EnergyMonitor, RoundOffIsNotAtPlay) {
  const auto model = Model::compile(load_model(MIMBRE_SOURCE_DIR "/tests/data/monitors/wolf.yaml"));
  const Simulation s = after(model, 0.001, 0.2);
  EXPECT_LT(s.energy().springs, 1e-20);
  EXPECT_LT(s.energy().numerical, -1e-5);
  EXPECT_THAT(s.warnings(), IsEmpty());
}

/// The part of an expression that depends on the rate takes energy like a damper's law of the same size.
TEST(EnergyMonitor, ADamperInAnExpressionDissipates) {
  const auto strut = [](const std::string& law) {
    return after(model_of(R"(
gravity: [0, 0, 0]
bodies: {a: {mass: 1, com: [0, 0, 1], inertia: [1, 1, 1]}}
joints: {slide: {type: prismatic, between: [ground, a], at: [0, 0, 1], axis: [0, 0, 1], position: 0.1}}
springs:
  strut: {between: [ground, a], at: [[0, 0, 0], [0, 0, 1]], )" +
                          law + "}\n"),
                 0.001, 1)
        .energy();
  };
  const EnergyBalance laws = strut("elastic: {stiffness: 100, zero: 1}, damping: {coefficient: 2}"),
                      expression = strut("force: \"100*(l - 1) + 2*v\"");
  EXPECT_NEAR(laws.dissipated, 0.5 * (1 - std::exp(-2.0)), 0.05);
  EXPECT_NEAR(expression.dissipated, laws.dissipated, 1e-6);
  EXPECT_NEAR(expression.load_work, 0.5 * 100 * 0.01 - laws.springs, 1e-5);
  EXPECT_NEAR(expression.numerical, laws.numerical, 1e-5);
}

}  // namespace
}  // namespace mimbre::test::energy_monitor_test
