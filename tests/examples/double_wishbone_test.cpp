#include <cmath>
#include <numbers>

#include "examples/example.h"

/// examples/double-wishbone against the four-bar linkage of its front view and virtual work.
namespace mimbre::examples_test::double_wishbone_test {
namespace {

using Eigen::Vector2d;
constexpr double gravity = 9.81;

Vector2d turned(const Vector2d& v, double angle) { return Eigen::Rotation2Dd(angle) * v; }

/// The left side in the plane y–z, at an angle of the lower arm about x from where it is written.
struct FrontView {
  double camber;  ///< rotation of the wheel about x
  Vector2d wheel, patch;
  double coil;       ///< length
  double potential;  ///< of the weights of arms, rod and wheel, and of the bushings' turning, J

  explicit FrontView(double arm) {
    const Vector2d lower_pivot(0.35, 0.18), upper_pivot(0.42, 0.45), lower_ball(0.70, 0.15),
        upper_ball(0.66, 0.46);
    const Vector2d ball = lower_pivot + turned(lower_ball - lower_pivot, arm);
    // The upper ball: on a circle about the pivot and at the carrier's length from the lower one.
    const Vector2d base = ball - upper_pivot;
    const double upper = (upper_ball - upper_pivot).norm(), carrier = (upper_ball - lower_ball).norm();
    const double along = (upper * upper - carrier * carrier + base.squaredNorm()) / (2 * base.norm());
    const double aside = std::sqrt(upper * upper - along * along);
    const Vector2d axis = base.normalized(), normal(-axis.y(), axis.x());
    const Vector2d second = upper_pivot + along * axis + aside * normal;
    const Vector2d before = upper_ball - lower_ball, after = second - ball;
    camber = std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
    const auto carried = [&](const Vector2d& p) { return Vector2d(ball + turned(p - lower_ball, camber)); };
    wheel = carried({0.74, 0.30});
    patch = carried({0.75, 0});
    const auto on_arm = [&](const Vector2d& p) {
      return Vector2d(lower_pivot + turned(p - lower_pivot, arm));
    };
    coil = (on_arm({0.60, 0.16}) - Vector2d(0.48, 0.60)).norm();
    const double upper_turn = std::atan2(second.y() - upper_pivot.y(), second.x() - upper_pivot.x()) -
                              std::atan2(upper_ball.y() - upper_pivot.y(), upper_ball.x() - upper_pivot.x());
    const double upper_centre = upper_pivot.y() + turned(Vector2d(0.54, 0.455) - upper_pivot, upper_turn).y();
    const double rod_end = carried({0.69, 0.18}).y();
    potential =
        gravity * (5 * on_arm({0.5, 0.165}).y() + 2 * upper_centre + 0.8 * rod_end / 2 + 32 * wheel.y()) +
        15 * upper_turn * upper_turn;
  }
};

/// By the arm's angle.
template <typename Of>
double slope(double arm, Of of) {
  return (of(FrontView(arm + 1e-5)) - of(FrontView(arm - 1e-5))) / 2e-5;
}

/// The wheel load at which the arm rests so: what coil, weights and a torque on the arm leave, N.
double load(double arm, double torque) {
  const double coil =
      45e3 * (FrontView(arm).coil - 0.565) * slope(arm, [](const FrontView& v) { return v.coil; });
  const double weight = slope(arm, [](const FrontView& v) { return v.potential; });
  return (coil + weight - torque) / slope(arm, [](const FrontView& v) { return v.patch.y(); });
}

class DoubleWishbone : public ExampleTest {
 protected:
  /// At rest with these wheel loads; hardly any rubber, no friction.
  test::Json at_rest(double left, double right, const char* bar) const {
    const app_test::Outcome outcome =
        run({"static", model_of("double-wishbone").string(), "--json", "--set", "rubber=1000", "--set",
             "rubbing=0", "--set", "bar=" + std::string(bar), "--set", "left=" + std::to_string(left),
             "--set", "right=" + std::to_string(right)});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.json().at("outputs");
  }
};

TEST_F(DoubleWishbone, CarriesItsLoadsAsVirtualWorkSays) {
  for (const double wheel : {2500.0, 3500.0, 4500.0}) {
    const test::Json rest = at_rest(wheel, wheel, "1500");
    const double arm = rest.at("left.arm");
    EXPECT_NEAR(load(arm, 0), wheel, 2e-3 * wheel);
    const FrontView view(arm);
    EXPECT_NEAR(rest.at("left.z"), view.wheel.y(), 5e-5);
    EXPECT_NEAR(rest.at("left.camber"), view.camber, 2e-4);
    EXPECT_NEAR(rest.at("left.track"), view.patch.x(), 1e-4);
    EXPECT_NEAR(rest.at("right.arm"), arm, 1e-6);
  }
}

/// Wheel rate: what a newton more on both wheels lifts them. The coil's rate times the square of its motion
/// ratio, and what the turning of the coil's lever adds.
TEST_F(DoubleWishbone, HasTheWheelRateOfItsMotionRatio) {
  const double lower = at_rest(3400, 3400, "1500").at("left.z"),
               upper = at_rest(3600, 3600, "1500").at("left.z");
  const double rate = 200 / (upper - lower);
  const double ratio = slope(0, [](const FrontView& v) { return v.coil; }) /
                       slope(0, [](const FrontView& v) { return v.patch.y(); });
  EXPECT_NEAR(45e3 * ratio * ratio, 20e3, 0.5e3) << "examples/double-wishbone/README.md says so";
  EXPECT_NEAR(rate, 45e3 * ratio * ratio, 0.1 * rate);
}

/// In roll the bar has its share: k (φl − φr) on either arm.
TEST_F(DoubleWishbone, RollsAgainstItsBar) {
  const test::Json rest = at_rest(4000, 3000, "1500");
  const double left = rest.at("left.arm"), right = rest.at("right.arm");
  EXPECT_GT(left - right, 0.03);
  EXPECT_NEAR(load(left, -1500 * (left - right)), 4000, 10);
  EXPECT_NEAR(load(right, -1500 * (right - left)), 3000, 10);
  const test::Json without = at_rest(4000, 3000, "0");
  const double without_left = without.at("left.arm"), without_right = without.at("right.arm");
  EXPECT_GT(without_left - without_right, 1.3 * (left - right));
}

/// Over the bump, into its stop; friction then holds the wheel a little beside where it was.
TEST_F(DoubleWishbone, RestsWhereFrictionHoldsIt) {
  const Table run = run_example("double-wishbone");
  EXPECT_GT(run["left.z"].maxCoeff(), run["left.z"][0] + 0.06);
  const double off = std::abs(run["left.z"].tail(1)[0] - run["left.z"][0]);
  EXPECT_GT(off, 1e-5);
  EXPECT_LT(off, 3e-3);
  const Eigen::ArrayXd last = run.from(1.9)["left.z"];
  EXPECT_LT(amplitude(last), 1e-5);
}

}  // namespace
}  // namespace mimbre::examples_test::double_wishbone_test
