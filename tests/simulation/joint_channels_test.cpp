#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "math/rotation.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// The standard channels of joints: the same whether a joint is in the tree or cut.
namespace mimbre::test::joint_channels_test {
namespace {

/// Two bodies in space, in a loop of one kind of joint and others that leave it motions, at rest on springs.
std::string loop(const std::string& joint, const std::string& cut) {
  return fmt::format(R"(
bodies:
  a: {{mass: 2, com: [0.3, 0.1, 0.2], inertia: [0.1, 0.2, 0.15]}}
  b: {{mass: 3, com: [0.9, -0.2, 0.3], inertia: [0.2, 0.1, 0.25]}}
joints:
  left: {{type: spherical, between: [ground, a], at: [0, 0, 0]{1}}}
  middle: {{{0}, between: [a, b], at: [0.6, 0.1, 0.4]{2}}}
  right: {{type: spherical, between: [b, ground], at: [1.2, -0.1, 0.1]}}
)",
                     joint, cut == "left" ? ", cut: always" : "", cut == "middle" ? ", cut: always" : "");
}

std::map<std::string, double> channels_after(const std::string& text, double time) {
  RunOptions options;
  options.step = 0.001;
  options.tolerance = 1e-10;
  Simulation s(model_of(text), options);
  for (int k = static_cast<int>(std::lround(time / *options.step)); k > 0; --k) EXPECT_TRUE(s.step().ok());
  ResultsRow row;
  s.sample(row);
  std::map<std::string, double> values;
  for (std::size_t k = 0; k < s.channels().size(); ++k)
    values[s.channels()[k].name] = row.channels[static_cast<Eigen::Index>(k)];
  return values;
}

TEST(JointChannels, AreTheSameForTreeJointsAndCutOnes) {
  for (const char* joint : {"type: revolute, axis: [0, 1, 0.3]", "type: cylindrical, axis: [1, 1, 0]",
                            "type: universal, axis: [1, 0, 0], axis2: [0, 0, 1]",
                            "type: prismatic, axis: [1, 0.2, 0]", "type: planar, axis: [0, 0, 1]"}) {
    const auto one = channels_after(loop(joint, "left"), 0.05),
               other = channels_after(loop(joint, "middle"), 0.05);
    ASSERT_EQ(one.size(), other.size());
    int compared = 0;
    double sign = 0;  // of the quaternion
    for (const auto& [name, value] : one) {
      if (!name.starts_with("joint.left.") && !name.starts_with("joint.middle.")) continue;
      const double there = other.at(name);
      if (name.starts_with("joint.left.rotation.")) {
        if (sign == 0 && std::abs(value) > 0.1) sign = value * there > 0 ? 1 : -1;
        EXPECT_NEAR(std::abs(value), std::abs(there), 1e-7) << joint << ' ' << name;
        continue;
      }
      EXPECT_NEAR(value, there, 1e-4 * (1 + std::abs(value))) << joint << ' ' << name;
      ++compared;
    }
    EXPECT_GT(compared, 24) << joint;
  }
}

TEST(JointChannels, ReactionsInTheJointsAxesAreThoseOfTheGlobalOnes) {
  const auto c = channels_after(loop("type: universal, axis: [1, 0, 0], axis2: [0, 0, 1]", ""), 0.05);
  for (const char* what : {"force", "moment"}) {
    double global = 0, own = 0;
    for (const char* axis : {"x", "y", "z"}) {
      global += std::pow(c.at(fmt::format("joint.middle.{}.{}", what, axis)), 2);
      own += std::pow(c.at(fmt::format("joint.middle.{}_joint.{}", what, axis)), 2);
    }
    EXPECT_NEAR(std::sqrt(own / global), 1, 1e-12);
  }
  // A universal joint transmits no moment about its second axis, the second body's y.
  EXPECT_NEAR(c.at("joint.middle.moment_joint.y"), 0, 1e-4);
  // A ball transmits no moment at all.
  for (const char* axis : {"x", "y", "z"})
    EXPECT_NEAR(c.at(fmt::format("joint.left.moment.{}", axis)), 0, 1e-4);
}

}  // namespace
}  // namespace mimbre::test::joint_channels_test
