#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "examples/example.h"
#include "mimbre/results.h"

/// examples/solar-array against the balance of energy and momentum of one degree of freedom: with belts that
/// do not give, the yoke's angle is all that moves, and the satellite follows so that momentum stays zero.
namespace mimbre::examples_test::solar_array_test {
namespace {

using Eigen::Vector2d;
constexpr double pi = std::numbers::pi;

/// The wing with the yoke at an angle, seen from the satellite.
struct Wing {
  double inertia;  ///< 2 T/(d angle/dt)², of all that moves, the satellite included
  double turning;  ///< how far the satellite turns by the yoke's angle
  double springs;  ///< energy, J

  explicit Wing(double angle) {
    struct Body {
      double mass, turn_inertia;
      Vector2d at;
      double turned;
    };
    const auto bodies = [](double root) {
      constexpr double side = 0.6, yoke = 0.8, panel = 1.6;
      const std::array<double, 4> hinges{root, -2 * root, 2 * root, -2 * root};
      const std::array<double, 4> lengths{yoke, panel, panel, panel};
      std::array<Body, 5> all{Body{320, 120, Vector2d::Zero(), 0}};
      Vector2d hinge(side, 0);
      double turned = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        turned += hinges[k];
        const Vector2d along(std::cos(turned), std::sin(turned));
        all[k + 1] = {k == 0 ? 3.0 : 9.0, k == 0 ? 0.16 : 9 * panel * panel / 12,
                      hinge + lengths[k] / 2 * along, turned};
        hinge += lengths[k] * along;
      }
      return all;
    };
    const auto at = bodies(angle), after = bodies(angle + 1e-6), before = bodies(angle - 1e-6);
    double mass = 0, energy = 0, spin = 0, about = 0;
    Vector2d centre = Vector2d::Zero(), drift = Vector2d::Zero();
    for (std::size_t k = 0; k < 5; ++k) {
      mass += at[k].mass;
      centre += at[k].mass * at[k].at;
      drift += at[k].mass * (after[k].at - before[k].at) / 2e-6;
    }
    centre /= mass;
    drift /= mass;
    for (std::size_t k = 0; k < 5; ++k) {
      const Vector2d v = (after[k].at - before[k].at) / 2e-6 - drift, r = at[k].at - centre;
      const double w = (after[k].turned - before[k].turned) / 2e-6;
      energy += at[k].mass * v.squaredNorm() + at[k].turn_inertia * w * w;
      spin += at[k].mass * (r.x() * v.y() - r.y() * v.x()) + at[k].turn_inertia * w;
      about += at[k].mass * r.squaredNorm() + at[k].turn_inertia;
    }
    inertia = energy - spin * spin / about;
    turning = -spin / about;
    // 0.10 N m/rad each, pushing on where the hinge is straight.
    springs = 0.05 * (std::pow(angle - 1, 2) + 3 * std::pow(2 * angle - 1, 2));
  }
};

class SolarArray : public ExampleTest {};

TEST_F(SolarArray, UnfoldsInTheTimeThatItsSpringsGiveIt) {
  const Table run = run_example("solar-array", {"--set", "panels=rigid", "--set", "latches=false", "--set",
                                                "belt=30000", "--until", "18"});
  Eigen::Index straight = 0;
  while (run["root"][straight] < 0) ++straight;
  const double share = -run["root"][straight - 1] / (run["root"][straight] - run["root"][straight - 1]);
  const double time = run["t"][straight - 1] + share * 0.02;

  // dt = dα √(I/(2 W)); the speed grows as the root of the way, so that α = −π/2 + s² has no singular start.
  const double stored = Wing(-pi / 2).springs;
  double expected = 0, turned = 0;
  const int parts = 4000;
  const double end = std::sqrt(pi / 2);
  for (int i = 0; i < parts; ++i) {
    const double s = end * (i + 0.5) / parts;
    const Wing wing(-pi / 2 + s * s);
    expected += 2 * s * end / parts * std::sqrt(wing.inertia / (2 * (stored - wing.springs)));
    turned += 2 * s * end / parts * wing.turning;
  }
  EXPECT_NEAR(expected, 15.6, 0.1) << "examples/solar-array/README.md says so";
  EXPECT_NEAR(time, expected, 1e-4 * expected);
  const Eigen::ArrayXd& yaw = run["satellite.yaw"];
  EXPECT_NEAR(yaw[straight - 1] + share * (yaw[straight] - yaw[straight - 1]), turned,
              0.02 * std::abs(turned));
  const double rate = std::sqrt(2 * (stored - Wing(0).springs) / Wing(0).inertia);
  EXPECT_NEAR(run["root_rate"][straight], rate, 5e-3 * rate);
  EXPECT_LT(run["momentum"].abs().maxCoeff(), 1e-9);
}

TEST_F(SolarArray, LatchesAndComesToRest) {
  const Table run = run_example("solar-array");
  const Table last = run.from(24);
  const Table latched = run.from(15.6);
  for (const char* hinge : {"root", "h1", "h2", "h3"}) {
    EXPECT_LT(latched[hinge].abs().maxCoeff(), 0.012) << hinge;
    EXPECT_LT(last[hinge].abs().maxCoeff(), 3e-4) << hinge;
  }
  EXPECT_GT(run["satellite.spin"].abs().maxCoeff(), 1e-2);
  EXPECT_LT(run["momentum"].abs().maxCoeff(), 1e-9);
  EXPECT_LT(amplitude(last["satellite.yaw"]), 1e-3);
}

/// Each latch falls in once, when its hinge is straight, about when an unlatched wing would be.
TEST_F(SolarArray, LatchesFallInWhereHingesAreStraight) {
  const app_test::Outcome ran =
      run({"run", model_of("solar-array").string(), "--output", "array.h5", "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const Results results = read_results((folder / "array.h5").string());
  const auto channel = [&](const std::string& name) -> Eigen::VectorXd {
    for (std::size_t k = 0; k < results.header.channels.size(); ++k)
      if (results.header.channels[k].name == name) return results.channels.col(static_cast<Eigen::Index>(k));
    ADD_FAILURE() << "no channel " << name;
    return Eigen::VectorXd::Zero(1);
  };
  for (const std::string& hinge : std::vector<std::string>{"root", "h1", "h2", "h3"}) {
    const Eigen::VectorXd latched = channel("input." + hinge + "_in"), angle = channel(hinge);
    EXPECT_EQ(channel("event." + hinge + "_straight").tail<1>()[0], 1) << hinge;
    const double when = channel("event." + hinge + "_straight.time").tail<1>()[0];
    EXPECT_NEAR(when, 15.6, 0.05) << hinge;
    for (Eigen::Index k = 0; k < results.time.size(); ++k) {
      EXPECT_EQ(latched[k], results.time[k] > when ? 1 : 0) << hinge << results.time[k];
      if (results.time[k] >= when) continue;
      EXPECT_LT(angle[k] * (hinge == "root" || hinge == "h2" ? 1 : -1), 0) << hinge;
    }
  }
}

}  // namespace
}  // namespace mimbre::examples_test::solar_array_test
