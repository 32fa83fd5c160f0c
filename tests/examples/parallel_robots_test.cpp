#include <array>
#include <cmath>
#include <numbers>

#include "examples/example.h"

/// examples/stewart-platform and examples/delta-robot: platforms that legs or arms move, against their
/// inverse kinematics.
namespace mimbre::examples_test::parallel_robots_test {
namespace {

using Eigen::Vector3d;
constexpr double pi = std::numbers::pi, gravity = 9.81;

/// 10 s³ − 15 s⁴ + 6 s⁵ between 0 and 1.
double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 - 15 * s + 6 * s * s);
}

class StewartPlatform : public ExampleTest {
 protected:
  static constexpr double height = 1.2;
  /// Where the leg 0 … 5 stands, and where it holds the platform, in the platform's axes from its middle.
  static Vector3d foot(int leg) { return around(leg, 0.9, 12 * pi / 180); }
  static Vector3d head(int leg) { return around(leg, 0.6, 48 * pi / 180); }
  static std::string name(int leg, const std::string& channel) {
    return "leg" + std::to_string(leg + 1) + "." + channel;
  }

 private:
  static Vector3d around(int leg, double radius, double angle) {
    const double at = leg / 2 * 2 * pi / 3 + (leg % 2 == 0 ? angle : -angle);
    return radius * Vector3d(std::cos(at), std::sin(at), 0);
  }
};

TEST_F(StewartPlatform, GoesWhereItIsWanted) {
  const Table run = run_example("stewart-platform");
  double farthest = 0;
  for (Eigen::Index row = 0; row < run["t"].size(); ++row) {
    const double t = run["t"][row], fade = smooth(t);
    const Vector3d at(0.10 * fade * std::sin(2 * pi * 0.6 * t), 0,
                      height + 0.08 * fade * std::sin(2 * pi * t));
    const double pitch = 0.12 * fade * std::sin(2 * pi * 0.8 * t);
    EXPECT_NEAR(run["platform.x"][row], at.x(), 1e-9);
    EXPECT_NEAR(run["platform.y"][row], 0, 1e-9);
    EXPECT_NEAR(run["platform.z"][row], at.z(), 1e-9);
    EXPECT_NEAR(run["platform.pitch"][row], pitch, 1e-9);
    EXPECT_NEAR(run["platform.roll"][row], 0, 1e-9);
    EXPECT_NEAR(run["platform.yaw"][row], 0, 1e-9);
    const Eigen::AngleAxisd turned(pitch, Vector3d::UnitY());
    for (int leg = 0; leg < 6; ++leg)
      EXPECT_NEAR(run[name(leg, "length")][row], (at + turned * head(leg) - foot(leg)).norm(), 1e-9);
    farthest = std::max(farthest, std::abs(pitch));
  }
  EXPECT_GT(farthest, 0.1);
}

/// Lifted by dz, every leg grows by h/l dz, and its two halves rise by a share of it: virtual work, by
/// symmetry of one leg.
TEST_F(StewartPlatform, StandsOnForcesThatVirtualWorkGives) {
  const Table run = run_example("stewart-platform", {"--until", "0.01"});
  const Vector3d along = head(0) + Vector3d(0, 0, height) - foot(0);
  const double length = along.norm();
  const double rod_from_head = 0.25 * length, cylinder_from_foot = 0.25 * length;
  // Heights of the halves: (1 − c/l(h)) h and c h/l(h), with dl/dh = h/l.
  const auto rises = [&](double from) { return from * (1 / length - height * height / std::pow(length, 3)); };
  const double work = 500.0 / 6 + 6 * (1 - rises(rod_from_head)) + 14 * rises(cylinder_from_foot);
  const double expected = gravity * work * length / height;
  EXPECT_NEAR(expected, 966, 1) << "examples/stewart-platform/README.md says so";
  for (int leg = 0; leg < 6; ++leg) {
    const Vector3d direction = (head(leg) + Vector3d(0, 0, height) - foot(leg)) / length;
    const Vector3d force(run[name(leg, "fx")][0], run[name(leg, "fy")][0], run[name(leg, "fz")][0]);
    EXPECT_NEAR(force.dot(direction), expected, 1e-6 * expected);
  }
}

class DeltaRobot : public ExampleTest {
 protected:
  static constexpr double base = 0.2, arm = 0.3, rod = 0.8, top = 0.05;

  /// Of the arms, by the intersection of the circle of the elbow with the sphere around the wrist: Newton's
  /// method on what the elbow's distance lacks, from the arm level on.
  static double angle(int limb, const Vector3d& platform) {
    const Eigen::AngleAxisd back(-limb * 2 * pi / 3, Vector3d::UnitZ());
    const Vector3d wrist = back * platform + Vector3d(top, 0, 0);
    double found = 0;
    for (int i = 0; i < 50; ++i) {
      const Vector3d elbow(base + arm * std::cos(found), 0, -arm * std::sin(found));
      const Vector3d moves(-arm * std::sin(found), 0, -arm * std::cos(found));
      found -= ((elbow - wrist).squaredNorm() - rod * rod) / (2 * moves.dot(elbow - wrist));
    }
    return found;
  }
};

TEST_F(DeltaRobot, PicksAndPlacesWithItsPlatformLevel) {
  const Table run = run_example("delta-robot");
  for (Eigen::Index row = 0; row < run["t"].size(); ++row) {
    const double t = run["t"][row];
    const Vector3d wanted(-0.1525 + 0.305 * smooth((t - 0.06) / 0.28), 0,
                          -0.75 + 0.025 * (smooth(t / 0.12) - smooth((t - 0.28) / 0.12)));
    EXPECT_NEAR(run["platform.x"][row], wanted.x(), 1e-9);
    EXPECT_NEAR(run["platform.y"][row], 0, 1e-9);
    EXPECT_NEAR(run["platform.z"][row], wanted.z(), 1e-9);
    for (const char* turned : {"platform.roll", "platform.pitch", "platform.yaw"})
      EXPECT_NEAR(run[turned][row], 0, 1e-9);
    for (int limb = 0; limb < 3; ++limb)
      EXPECT_NEAR(run["limb" + std::to_string(limb + 1) + ".angle"][row], angle(limb, wanted), 1e-9);
  }
}

/// What holds it at rest: the slope of its weight's work, with the arms' angles by the platform's place as
/// coordinates.
TEST_F(DeltaRobot, HoldsItsLoadWithTheTorquesOfVirtualWork) {
  const Table run = run_example("delta-robot", {"--until", "0.001"});
  const Vector3d at(-0.1525, 0, -0.75);
  const double step = 1e-6;
  Eigen::Matrix3d by_place;            // of the angles
  Vector3d weight = Vector3d::Zero();  // of the potential energy, by the platform's place
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d aside = step * Vector3d::Unit(axis);
    double rise = 0;
    for (int limb = 0; limb < 3; ++limb) {
      const double after = angle(limb, at + aside), before = angle(limb, at - aside);
      by_place(limb, axis) = (after - before) / (2 * step);
      const double elbow = -arm * (std::sin(after) - std::sin(before)) / (2 * step);
      rise += (0.4 / 2 + 2 * 0.06 / 2) * elbow;
    }
    weight[axis] = gravity * (rise + (axis == 2 ? 0.8 + 6 * 0.06 / 2 : 0));
  }
  const Vector3d torque = by_place.transpose().fullPivLu().solve(weight);
  for (int limb = 0; limb < 3; ++limb) {
    const std::string name = "limb" + std::to_string(limb + 1);
    const double turn = limb * 2 * pi / 3;
    EXPECT_NEAR(-std::sin(turn) * run[name + ".mx"][0] + std::cos(turn) * run[name + ".my"][0], torque[limb],
                1e-5);
  }
  EXPECT_NEAR(torque[0], -1.008, 1e-3) << "examples/delta-robot/README.md says so";
}

}  // namespace
}  // namespace mimbre::examples_test::parallel_robots_test
