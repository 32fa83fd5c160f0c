#include <gtest/gtest.h>

#include <complex>
#include <string>
#include <vector>

#include "mimbre/model_file.h"
#include "mimbre/modes.h"
#include "support/models.h"

/// Eigenvalues of the Iltis, rigid, links without mass, against those published of a Robotran model.
namespace mimbre::test::vehicle_modes_test {
namespace {

using Values = std::vector<std::complex<double>>;

/// The published eigenvalues: pitch, bounce, and the two lower modes of wheel hop, 1/s.
const Values published{{-4.094, 6.929}, {-5.528, 7.509}, {-29.53, 80.32}, {-29.28, 81.41}};

/// By the published values: how far the nearest eigenvalue is, as a share.
std::vector<double> distances(const spec::Model& spec) {
  ModesOptions options;
  options.linear.point.at = LinearPoint::At::equilibrium;
  const LinearisedModes found = find_modes(Model::compile(spec), options);
  std::vector<double> all;
  for (const std::complex<double>& value : published) {
    double nearest = 1e300;
    for (const Mode& m : found.modes) nearest = std::min(nearest, std::abs(m.value - value));
    all.push_back(nearest / std::abs(value));
  }
  return all;
}

spec::Model iltis() {
  return load_model(std::string(MIMBRE_SOURCE_DIR) + "/examples/iltis/vehicle.yaml",
                    {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}, {"massless_links", "true"}});
}

/// The benchmark's springs (leaf 35.9 kN/m, and at equilibrium 27 kN/m of the shock absorber's rubber) give a
/// ride a third stiffer than the published one; wheel hop, which is the tyres', agrees.
TEST(VehicleModes, OfTheBenchmarkAgreeInWheelHop) {
  const std::vector<double> off = distances(iltis());
  EXPECT_GT(off[0], 0.2);
  EXPECT_GT(off[1], 0.2);
  EXPECT_LT(off[2], 0.03);
  EXPECT_LT(off[3], 0.03);
}

/// One change explains the rest, damping and all: leaf springs of 27.9 kN/m about the nominal length and the
/// static force, and rubber that yields without stiffness.
TEST(VehicleModes, AreThePublishedOnesWithSofterSprings) {
  spec::Model spec = iltis();
  constexpr double nominal = 0.176, force = -2728.9, stiffness = 27.9e3;
  int leaves = 0, absorbers = 0;
  for (spec::Spring& s : spec.springs) {
    if (s.name.ends_with("leaf")) {
      s.elastic = Function::polynomial({force - nominal * stiffness, stiffness});
      ++leaves;
    } else if (s.name.ends_with("shock")) {
      s.elastic = Function::polynomial({-128.});
      ++absorbers;
    }
  }
  EXPECT_EQ(leaves, 4);
  EXPECT_EQ(absorbers, 4);
  for (const double off : distances(spec)) EXPECT_LT(off, 0.02);
}

/// Parked on a slope its brakes and carcasses hold it. The equilibrium has them bent, and nothing is left
/// that accelerates; no motion is rigid, also where links bend, whose stiffness is 1e7 times that of the
/// ride.
TEST(VehicleModes, ParkedOnASlope) {
  std::vector<std::vector<std::complex<double>>> slow;
  for (const std::string kind : {"rigid", "flexible"}) {
    ModesOptions options;
    const LinearisedModes found =
        find_modes(example("iltis/slope.yaml", {{"arms", kind}, {"links", kind}, {"rods", kind}}), options);
    EXPECT_EQ(found.model.point, "equilibrium");
    EXPECT_TRUE(found.model.warnings.empty()) << kind << found.model.warnings.front();
    EXPECT_LT(found.model.unsteady, 1e-6) << kind;
    slow.emplace_back();
    for (const Mode& m : found.modes) {
      EXPECT_NE(m.kind, Mode::Kind::rigid) << kind << m.text;
      EXPECT_FALSE(m.grows) << kind << m.text;
      if (m.kind == Mode::Kind::oscillating && slow.back().size() < 3) slow.back().push_back(m.value);
    }
  }
  ASSERT_EQ(slow[0].size(), 3u);
  ASSERT_EQ(slow[1].size(), 3u);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_LE(std::abs(slow[1][k] - slow[0][k]), 0.03 * std::abs(slow[0][k])) << slow[1][k];
}

}  // namespace
}  // namespace mimbre::test::vehicle_modes_test
