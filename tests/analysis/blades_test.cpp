#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "mimbre/modes.h"
#include "support/models.h"

/// Waves of equal blades that only the hub joins, which turns as it is driven: modes of equal eigenvalues.
/// Waves of blades that move the hub are in floquet_test.cpp.
namespace mimbre::test::blades_test {
namespace {

/// Blades of two links that flap about axes across, each turned by its part of a turn about the z axis.
std::string rotor(int blades, double speed, double last_mass = 1) {
  std::string text = "gravity: [0, 0, 0]\nbodies:\n  hub: {mass: 5, com: [0, 0, 0], inertia: [1, 1, 1]}\n";
  std::string joints = fmt::format(
      "joints:\n  turn: {{type: revolute, between: [ground, hub], at: [0, 0, 0], axis: [0, 0, 1], drive: "
      "{{speed: "
      "{}}}}}\n",
      speed);
  for (int k = 0; k < blades; ++k) {
    const double psi = 2 * std::numbers::pi * k / blades + 0.3, c = std::cos(psi), s = std::sin(psi);
    const double mass = k + 1 == blades ? last_mass : 1;
    for (const auto& [link, from, com] : {std::tuple("in", 0.2, 0.7), std::tuple("out", 1.2, 1.6)}) {
      // Long ones: their inertia shows how they are turned.
      text += fmt::format(
          "  {0}{1}: {{mass: {7}, com: [{2:.17g}, {3:.17g}, 0], inertia: [{4:.17g}, {5:.17g}, 0.1, {6:.17g}, "
          "0, "
          "0]}}\n",
          link, k, com * c, com * s, 0.01 * c * c + 0.09 * s * s, 0.01 * s * s + 0.09 * c * c,
          (0.01 - 0.09) * s * c, mass);
      joints += fmt::format(
          "  {0}j{1}: {{type: revolute, between: [{2}, {0}{1}], at: [{3:.17g}, {4:.17g}, 0], axis: "
          "[{5:.17g}, "
          "{6:.17g}, 0], spring: {{stiffness: 200, damping: 0.5}}}}\n",
          link, k, std::string(link) == "in" ? "hub" : fmt::format("in{}", k), from * c, from * s, s, -c);
    }
  }
  return text + joints;
}

LinearisedModes modes_of(const std::string& text) {
  ModesOptions options;
  options.linear.point.at = LinearPoint::At::steady;
  return find_modes(model_of(text), options);
}

std::multiset<std::string> waves(const LinearisedModes& found) {
  std::multiset<std::string> out;
  for (const Mode& mode : found.modes) {
    if (mode.blades.empty()) continue;
    EXPECT_NEAR(mode.blades[0].share, 1, 1e-6) << mode.text;
    out.insert(mode.blades[0].name);
  }
  return out;
}

TEST(Blades, EqualModesAreWaves) {
  for (const double speed : {0.0, 7.0, -7.0}) {
    const auto of = [&](int blades) { return waves(modes_of(rotor(blades, speed))); };
    using Set = std::multiset<std::string>;
    EXPECT_EQ(of(3), (Set{"collective", "collective", "forward", "forward", "backward", "backward"}));
    EXPECT_EQ(of(4), (Set{"collective", "collective", "forward", "forward", "backward", "backward",
                          "differential", "differential"}));
    EXPECT_EQ(of(5), (Set{"collective", "collective", "forward", "forward", "backward", "backward",
                          "forward of harmonic 2", "forward of harmonic 2", "backward of harmonic 2",
                          "backward of harmonic 2"}));
    EXPECT_EQ(of(2), Set());
  }
}

/// They are eigenvectors still, and left ones belong to them.
TEST(Blades, WavesAreEigenvectors) {
  const LinearisedModes found = modes_of(rotor(4, 7));
  const Eigen::MatrixXd& A = found.model.A;
  for (const Mode& mode : found.modes) {
    EXPECT_LE((A * mode.shape - mode.value * mode.shape).norm(),
              1e-9 * std::abs(mode.value) * mode.shape.norm());
    for (const Mode& other : found.modes)
      EXPECT_NEAR(std::abs(other.left.dot(mode.shape)), &mode == &other ? 1 : 0, 1e-8);
  }
}

/// A wave travels in the sense in which the hub turns: the next blade in that sense does the same later.
TEST(Blades, ForwardIsInTheSenseOfTheHub) {
  for (const double speed : {7.0, -7.0}) {
    const LinearisedModes found = modes_of(rotor(4, speed));
    for (const Mode& mode : found.modes) {
      const std::string& wave = mode.blades.at(0).name;
      if (wave != "forward" && wave != "backward") continue;
      const auto of = [&](const std::string& name) {
        for (std::size_t k = 0; k < found.coordinates.size(); ++k)
          if (found.coordinates[k].name == name) return mode.motion[static_cast<Eigen::Index>(k)];
        throw std::runtime_error(name);
      };
      const bool along = (wave == "forward") == (speed > 0);
      EXPECT_NEAR(std::arg(of("inj1") / of("inj0")), (along ? -1 : 1) * std::numbers::pi / 2, 1e-6)
          << mode.text;
    }
  }
}

/// A nacelle that is drawn upright and tilted by a drive carries the hub: the sense is that of the hub as it
/// is.
TEST(Blades, TurnWithTheHub) {
  for (const double tilt : {0.0, 2.0, 3.0}) {
    std::string text = rotor(4, 7);
    const auto replace = [&](const std::string& from, const std::string& to) {
      text.replace(text.find(from), from.size(), to);
    };
    replace("bodies:\n", "bodies:\n  nacelle: {mass: 5, com: [0, 0, 0], inertia: [1, 1, 1]}\n");
    replace("between: [ground, hub]", "between: [nacelle, hub]");
    text += fmt::format(
        "  tilt: {{type: revolute, between: [ground, nacelle], at: [0, 0, 0], axis: [1, 0, 0], drive: "
        "{{position: "
        "{}}}}}\n",
        tilt);
    int checked = 0;
    for (const LinearisedModes found = modes_of(text); const Mode& mode : found.modes) {
      if (mode.blades.empty() || (mode.blades[0].name != "forward" && mode.blades[0].name != "backward"))
        continue;
      const auto of = [&](const std::string& name) {
        for (std::size_t k = 0; k < found.coordinates.size(); ++k)
          if (found.coordinates[k].name == name) return mode.motion[static_cast<Eigen::Index>(k)];
        throw std::runtime_error(name);
      };
      EXPECT_NEAR(std::arg(of("inj1") / of("inj0")),
                  (mode.blades[0].name == "forward" ? -1 : 1) * std::numbers::pi / 2, 1e-6)
          << mode.text << ", " << tilt;
      ++checked;
    }
    EXPECT_EQ(checked, 4);
  }
}

/// Two rotors with equal blades on hubs of their own have modes of equal eigenvalues.
TEST(Blades, OfTwoEqualRotorsAreWaves) {
  std::string text = rotor(3, 7), other = text;
  const std::size_t bodies = other.find("bodies:\n") + 8, joints = other.find("joints:\n");
  std::string more_bodies = other.substr(bodies, joints - bodies), more_joints = other.substr(joints + 8);
  for (std::string* part : {&more_bodies, &more_joints})
    for (const std::string name : {"hub", "inj", "outj", "turn", "in0", "in1", "in2", "out0", "out1", "out2"})
      for (std::size_t at = 0; (at = part->find(name, at)) != std::string::npos; at += name.size() + 1)
        if (at == 0 || (std::isalnum(static_cast<unsigned char>((*part)[at - 1])) == 0))
          part->insert(at, "x");
  text.insert(text.find("joints:\n"), more_bodies);
  text += more_joints;
  const std::multiset<std::string> found = waves(modes_of(text));
  EXPECT_EQ(found.count("collective"), 4u);
  EXPECT_EQ(found.count("forward"), 4u);
  EXPECT_EQ(found.count("backward"), 4u);
}

TEST(Blades, AreEqual) {
  EXPECT_TRUE(waves(modes_of(rotor(3, 7, 1.01))).empty());
  EXPECT_FALSE(waves(modes_of(rotor(3, 7))).empty());
}

}  // namespace
}  // namespace mimbre::test::blades_test
