#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "roads/crg_file.h"
#include "roads/crg_writer.h"
#include "roads/grid.h"
#include "roads/overlap.h"

/// Roads that come back to themselves: closed, crossing, or bent more tightly than they are wide.
namespace mimbre::test::road_overlap_test {
namespace {

constexpr double pi = std::numbers::pi;

RoadGrid read(const RoadSketch& road) { return roads::parse_road_grid(written(road, "LDFI"), "written.crg"); }

/// Once around in `rows` steps; heights by u as a share of the way around.
template <class Height>
RoadSketch ring(double radius, int rows, const Height& height, double turns = 1) {
  RoadSketch road;
  road.v = {-1, 0, 1};
  road.increment = 2 * radius * std::sin(pi * turns / rows);
  for (int i = 0; i <= rows; ++i) {
    const double share = static_cast<double>(i) / rows;
    road.phi.push_back(2 * pi * turns * (share - 0.5 / rows));
    for (const double v : road.v) road.height.push_back(height(share) * (1 + 0.1 * v));
  }
  return road;
}

TEST(ClosedRoad, GoesOnOverItsSeam) {
  const RoadGrid road = read(ring(10, 240, [](double s) { return 0.2 * std::sin(2 * pi * s); }));
  const roads::GridArrays grid = roads::arrays_of(road, roads::file_rounding);
  EXPECT_TRUE(grid.closed);
  EXPECT_FALSE(roads::worst_overlap(road, roads::arrays_of(road, 0)));
  // The line starts at the origin along x; its middle is over (0, 10).
  const double h = 1e-4;
  for (const double v : {-0.9, -0.3, 0.4, 0.95}) {
    const double r = 10 - v;
    double before = NAN;
    for (int k = -3000; k <= 3000; ++k) {
      const double angle = k * h / r, x = r * std::sin(angle), y = 10 - r * std::cos(angle);
      const roads::Height at = roads::grid_height(grid, x, y);
      ASSERT_TRUE(roads::is_on_road(grid, x, y));
      // 0.2 sin(θ) (1 + 0.1 v) with θ along the circle, as chords of 1.5° have it.
      ASSERT_NEAR(at.z, 0.2 * std::sin(angle) * (1 + 0.1 * v), 2e-4);
      if (k > -3000) {
        ASSERT_NEAR(at.z, before, 0.05 * h);
      }
      before = at.z;
    }
  }
}

TEST(ClosedRoad, WithOtherHeightsAtItsEndIsNone) {
  const RoadGrid road = read(ring(10, 240, [](double s) { return 0.3 * s; }));
  EXPECT_FALSE(roads::arrays_of(road, 0).closed);
  const auto overlap = roads::worst_overlap(road, roads::arrays_of(road, 0));
  ASSERT_TRUE(overlap);
  EXPECT_NEAR(overlap->difference, 0.33, 0.005);
  EXPECT_FALSE(overlap->bend);
}

/// Twice around, the second time 0.5 m higher: only one of them can be felt.
TEST(RoadOverlap, IsFoundWhereARoadComesBack) {
  const RoadGrid road = read(ring(
      10, 480, [](double s) { return s < 0.5 ? 0.0 : 0.5; }, 1.9));
  const auto overlap = roads::worst_overlap(road, roads::arrays_of(road, 0));
  ASSERT_TRUE(overlap);
  EXPECT_NEAR(overlap->difference, 0.55, 1e-3);
  EXPECT_FALSE(overlap->bend);
  EXPECT_NEAR(std::abs(overlap->u - overlap->other_u), 2 * pi * 10, 0.5);
}

/// A figure of eight that crosses itself at one height is sound; one that crosses itself as a bridge is not.
TEST(RoadOverlap, OfACrossingIsTheHeightOfTheBridge) {
  for (const double bridge : {0.0, 4.0}) {
    RoadSketch road;
    road.v = {-1.5, 0, 1.5};
    road.increment = 0.2;
    for (int i = 0; i <= 600; ++i) {
      const double u = 0.2 * i;
      // Straight, three quarters of a circle to the left, and straight on across the first piece.
      road.phi.push_back(1.5 * pi * std::clamp((u - 30) / (1.5 * pi * 10), 0.0, 1.0));
      for (std::size_t k = 0; k < road.v.size(); ++k) road.height.push_back(u > 60 ? bridge : 0);
    }
    const RoadGrid grid = read(road);
    const auto overlap = roads::worst_overlap(grid, roads::arrays_of(grid, 0));
    ASSERT_EQ(overlap.has_value(), bridge > 0);
    if (overlap) {
      EXPECT_NEAR(overlap->difference, bridge, 1e-9);
      EXPECT_FALSE(overlap->bend);
    }
  }
}

TEST(RoadOverlap, NamesBendsThatAreTooTight) {
  RoadSketch road;
  road.v = {-2, -1, 0, 1, 2};
  road.increment = 0.1;
  for (int i = 0; i <= 100; ++i) {
    const double u = 0.1 * i;
    road.phi.push_back(std::clamp((u - 4) / 1.5, 0.0, 1.5));  // a radius of 1.5 m to the left
    for (std::size_t k = 0; k < road.v.size(); ++k) road.height.push_back(0.1 * u);
  }
  const RoadGrid grid = read(road);
  const auto overlap = roads::worst_overlap(grid, roads::arrays_of(grid, 0));
  ASSERT_TRUE(overlap);
  EXPECT_TRUE(overlap->bend);
  EXPECT_EQ(overlap->v, 2);
  // The same road is sound where nothing is known on that side.
  for (std::size_t i = 0; i < road.rows(); ++i) road.height[i * 5 + 4] = NAN;
  const RoadGrid narrow = read(road);
  EXPECT_FALSE(roads::worst_overlap(narrow, roads::arrays_of(narrow, 0)));
  // All places have some height.
  const roads::GridArrays arrays = roads::arrays_of(narrow, roads::file_rounding);
  for (int i = -30; i < 80; ++i)
    for (int j = -30; j < 60; ++j) {
      const roads::Height at = roads::grid_height(arrays, 0.1 * i, 0.1 * j);
      ASSERT_TRUE(at.z > -1e-9 && at.z < 1 + 1e-9) << i << " " << j;
      ASSERT_TRUE(std::isfinite(at.x + at.y + at.xx + at.xy + at.yy)) << i << " " << j;
    }
}

TEST(OnRoad, AreThePlacesThatTheFileKnows) {
  RoadSketch road = handmade_road(0, false, false);
  road.height[5 * 7 + 6] = NAN;  // the outermost on the left at u = 5
  road.height[9 * 7 + 3] = NAN;  // a hole
  const RoadGrid read_road = read(road);
  EXPECT_EQ(read_road.gaps, 2u);
  EXPECT_EQ(read_road.holes, 1u);
  const roads::GridArrays grid = roads::arrays_of(read_road, 0);
  const auto on = [&](double x, double y) { return roads::is_on_road(grid, x, y); };
  EXPECT_TRUE(on(0, 0));
  EXPECT_TRUE(on(22, -1.5));
  EXPECT_FALSE(on(-0.01, 0));
  EXPECT_FALSE(on(22.01, 0));
  EXPECT_FALSE(on(3, 1.51));
  EXPECT_FALSE(on(3, -1.51));
  EXPECT_FALSE(on(5, 1.3));
  EXPECT_TRUE(on(5, 1.2));
  EXPECT_TRUE(on(9, 0));
}

}  // namespace
}  // namespace mimbre::test::road_overlap_test
