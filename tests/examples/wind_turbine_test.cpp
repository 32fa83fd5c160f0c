#include <array>
#include <cmath>

#include "examples/example.h"

/// examples/wind-turbine against Southwell's rule, with the shape of a stepped cantilever found by
/// integration.
namespace mimbre::examples_test::wind_turbine_test {
namespace {

constexpr double hub = 1.5, length = 61.5;
constexpr int parts = 2460;
constexpr double part = length / parts;

/// The blade at the middle of its parts: where, kg/m, flapwise stiffness N m².
struct Blade {
  Eigen::ArrayXd at{parts}, mass{parts}, stiffness{parts};

  Blade() {
    constexpr std::array<double, 10> ends{4, 9, 15, 22, 29, 36, 43, 50, 56, 61.5};
    constexpr std::array<double, 10> masses{758.9, 458.9, 412.5, 352.5, 316.1,
                                            261.9, 197.1, 144.3, 98.7,  61.1};
    constexpr std::array<double, 10> flapwise{16779e6, 6325e6,  3474e6,  2010e6,  1173e6,
                                              512.4e6, 196.3e6, 90.35e6, 47.05e6, 19.41e6};
    std::size_t piece = 0;
    for (int i = 0; i < parts; ++i) {
      at[i] = (i + 0.5) * part;
      while (at[i] > ends[piece]) ++piece;
      mass[i] = masses[piece];
      stiffness[i] = flapwise[piece];
    }
  }

  /// From the tip inwards.
  static Eigen::ArrayXd beyond(const Eigen::ArrayXd& per_length) {
    Eigen::ArrayXd sum(parts);
    double outside = 0;
    for (int i = parts - 1; i >= 0; --i) {
      sum[i] = outside + 0.5 * part * per_length[i];
      outside += part * per_length[i];
    }
    return sum;
  }
  /// From the root outwards.
  static Eigen::ArrayXd within(const Eigen::ArrayXd& slope) { return beyond(slope.reverse()).reverse(); }
};

/// The lowest flapping mode at rest, rad²/s², and what the square of the speed adds to it: ∫ N w'²/∫ m w².
std::pair<double, double> southwell() {
  const Blade blade;
  Eigen::ArrayXd shape = blade.at.square(), slope;
  double squared = 0;
  for (int iteration = 0; iteration < 30; ++iteration) {  // what its own inertia bends: Stodola's method
    const Eigen::ArrayXd moment = Blade::beyond(Blade::beyond(blade.mass * shape));
    slope = Blade::within(moment / blade.stiffness);
    const Eigen::ArrayXd bent = Blade::within(slope);
    squared = (blade.mass * shape * bent).sum() / (blade.mass * bent * bent).sum();
    slope /= bent[parts - 1];
    shape = bent / bent[parts - 1];
  }
  const Eigen::ArrayXd tension = Blade::beyond(blade.mass * (hub + blade.at));
  return {squared, (tension * slope.square()).sum() / (blade.mass * shape.square()).sum()};
}

class WindTurbine : public ExampleTest {
 protected:
  /// Of the first blade's flapping after the wind has stopped, Hz; without weight.
  double flapping(const std::string& rpm) const {
    const Table calm = run_example("wind-turbine", {"--set", "weight=0", "--set", "rpm=" + rpm}).from(22);
    return frequency(calm["t"], calm["blade1.flap"]);
  }
};

TEST_F(WindTurbine, FlapsFasterAsItTurns) {
  const auto [squared, added] = southwell();
  const double speed = 12.1 * M_PI / 30, at_rest = std::sqrt(squared) / (2 * M_PI);
  EXPECT_NEAR(at_rest, 0.650, 0.001) << "examples/wind-turbine/README.md says so";
  EXPECT_NEAR(flapping("0"), at_rest, 0.003 * at_rest);
  const double turning = std::sqrt(squared + added * speed * speed) / (2 * M_PI);
  EXPECT_NEAR(turning, 0.706, 0.001) << "examples/wind-turbine/README.md says so";
  EXPECT_NEAR(flapping("12.1"), turning, 0.003 * turning);
}

/// The hub holds the blades against the wind.
TEST_F(WindTurbine, CarriesItsThrust) {
  const Table run = run_example("wind-turbine", {"--until", "19"});
  EXPECT_NEAR(run.from(16)["blade1.root_fx"].mean(), -267e3, 0.01 * 267e3);
}

/// As heavy as the published blade, with its first moment of mass.
TEST_F(WindTurbine, HasThePublishedMass) {
  const Blade blade;
  EXPECT_NEAR(part * blade.mass.sum(), 17740, 0.01 * 17740);
  EXPECT_NEAR(part * (blade.mass * blade.at).sum(), 363231, 0.01 * 363231);
}

}  // namespace
}  // namespace mimbre::examples_test::wind_turbine_test
