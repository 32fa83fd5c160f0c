#include "roads/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>

#include "roads/road_data.h"

/// Heights over places of a curved grid.
namespace mimbre::roads::grid_test {
namespace {

using test::road_path;

struct Place {
  double x, y;
};
/// On the line of constant u through point i, at v; along the mitre of the segments next to it.
Place place_of(const GridArrays& arrays, int i, double v) {
  const double* p = grid::point(arrays, i);
  return {p[0] + v * p[2], p[1] + v * p[3]};
}

/// A plane's heights are linear along and across every segment's grid, bends or not.
TEST(RoadGridHeight, OfAPlaneIsThatPlaneInBends) {
  RoadGrid road = read_road_grid(road_path("bend_double.crg"));
  std::fill(road.bank.begin(), road.bank.end(), 0.0);
  std::fill(road.line_height.begin(), road.line_height.end(), 0.0);
  GridArrays arrays = arrays_of(road, 0);
  for (int i = 0; i < static_cast<int>(road.along()); ++i)
    for (std::size_t k = 0; k < road.across(); ++k) {
      const auto [x, y] = place_of(arrays, i, road.v[k]);
      arrays.height[static_cast<std::size_t>(i) * road.across() + k] = 3 + 0.1 * x - 0.05 * y;
    }
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(0, 39.999), across(-2, 2);
  for (int n = 0; n < 2000; ++n) {
    const double u = along(random), v = across(random), f = u - std::floor(u);
    const Place a = place_of(arrays, static_cast<int>(u), v),
                b = place_of(arrays, static_cast<int>(u) + 1, v);
    const double x = (1 - f) * a.x + f * b.x, y = (1 - f) * a.y + f * b.y;
    const Height at = grid_height(arrays, x, y);
    EXPECT_NEAR(at.z, 3 + 0.1 * x - 0.05 * y, 1e-12);
    EXPECT_NEAR(at.x, 0.1, 1e-10);
    EXPECT_NEAR(at.y, -0.05, 1e-10);
  }
}

TEST(RoadGridHeight, OfAPointIsItsHeight) {
  const RoadGrid road = read_road_grid(road_path("bend_double.crg"));
  const GridArrays arrays = arrays_of(road, 0);
  for (int i = 0; i < 41; ++i)
    for (std::size_t k = 0; k < road.across(); ++k) {
      const auto [x, y] = place_of(arrays, i, road.v[k]);
      const std::size_t row = static_cast<std::size_t>(i);
      EXPECT_NEAR(grid_height(arrays, x, y).z,
                  road.height[row * road.across() + k] + road.line_height[row] + road.bank[row] * road.v[k],
                  1e-12);
    }
}

/// ASAM's own library, whose places in bends and heights are of the same formulas but heights in single
/// precision.
TEST(RoadGridHeight, IsThatOfOpenCrgsOwnLibrary) {
  const GridArrays arrays = arrays_of(read_road_grid(road_path("bend_double.crg")), 0);
  std::ifstream file(road_path("bend.csv"));
  int count = 0;
  double worst = 0;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    double x = 0, y = 0, z = 0;
    char comma = 0;
    if (!(words >> x >> comma >> y >> comma >> z)) continue;
    ++count;
    worst = std::max(worst, std::abs(grid_height(arrays, x, y).z - z));
  }
  EXPECT_EQ(count, 300);
  EXPECT_LT(worst, 1e-6);
}

/// By differences, except where a kink of a sharp road or a mitre lies between.
TEST(RoadGridHeight, HasItsDerivatives) {
  const double h = 1e-5;
  for (const double rounding : {0.0, 1e-3}) {
    const GridArrays arrays = arrays_of(read_road_grid(road_path("bend_double.crg")), rounding);
    std::mt19937 random(7);
    // Also far beside and beyond the road.
    std::uniform_real_distribution<double> xs(5, 32), ys(-12, 12);
    int steep = 0, bent = 0;
    for (int n = 0; n < 4000; ++n) {
      const double x = xs(random), y = ys(random);
      const auto same_piece = [&](double dx, double dy) {
        const grid::OnSegment a = grid::spot(arrays, x + dx, y + dy), b = grid::spot(arrays, x - dx, y - dy);
        const auto near_kink = [&](double v) {
          return std::any_of(arrays.v.begin(), arrays.v.end(),
                             [&](double at) { return std::abs(v - at) < 2 * h; });
        };
        return a.segment == b.segment && (a.f < 0) == (b.f < 0) && (a.f > 1) == (b.f > 1) && !near_kink(a.v);
      };
      if (!same_piece(h, 0) || !same_piece(0, h)) continue;
      const Height at = grid_height(arrays, x, y), east = grid_height(arrays, x + h, y),
                   west = grid_height(arrays, x - h, y), north = grid_height(arrays, x, y + h),
                   south = grid_height(arrays, x, y - h);
      // Where a rounding begins or ends the second derivative jumps.
      const double first = 1e-5 * (1 + std::abs(at.xx) + std::abs(at.yy) + std::abs(east.xx) +
                                   std::abs(west.xx) + std::abs(north.yy) + std::abs(south.yy));
      EXPECT_NEAR((east.z - west.z) / (2 * h), at.x, first) << x << " " << y;
      EXPECT_NEAR((north.z - south.z) / (2 * h), at.y, first) << x << " " << y;
      const auto alike = [](double a, double b, double c) {
        return std::max({a, b, c}) - std::min({a, b, c}) < 1e-2 * (1e-3 + std::abs(b));
      };
      if (alike(east.xx, at.xx, west.xx) && alike(north.yy, at.yy, south.yy) &&
          alike(north.xy, at.xy, south.xy)) {
        const double second = 1e-2 * (1e-2 + std::abs(at.xx) + std::abs(at.xy) + std::abs(at.yy));
        EXPECT_NEAR((east.x - west.x) / (2 * h), at.xx, second) << x << " " << y;
        EXPECT_NEAR((north.x - south.x) / (2 * h), at.xy, second);
        EXPECT_NEAR((east.y - west.y) / (2 * h), at.xy, second);
        EXPECT_NEAR((north.y - south.y) / (2 * h), at.yy, second);
        bent += std::abs(at.xx) > 0.01 ? 1 : 0;
      }
      steep += at.x != 0 ? 1 : 0;
    }
    EXPECT_GT(steep, 1000);
    EXPECT_GT(bent, 200);
  }
}

/// Along lines across the whole road, also through the mitres of its bends, no step is larger than the slope.
TEST(RoadGridHeight, HasNoSteps) {
  const GridArrays arrays = arrays_of(read_road_grid(road_path("bend_double.crg")), 0);
  const double h = 1e-4;
  for (const double v : {-1.9, -0.6, 0.1, 1.3, 1.99}) {
    double before = NAN;
    for (int i = 0; i < 40; ++i) {
      const Place a = place_of(arrays, i, v), b = place_of(arrays, i + 1, v);
      const int steps = static_cast<int>(std::hypot(b.x - a.x, b.y - a.y) / h);
      for (int k = 0; k < steps; ++k) {
        const double f = static_cast<double>(k) / steps;
        const double z = grid_height(arrays, a.x + f * (b.x - a.x), a.y + f * (b.y - a.y)).z;
        if (!std::isnan(before)) {
          ASSERT_LT(std::abs(z - before), 0.5 * h) << v << " " << i << " " << f;
        }
        before = z;
      }
    }
  }
}

TEST(RoadGridHeight, GoesOnBeyondItsEnds) {
  RoadGrid road;
  road.x = {0, 1, 2};
  road.y = road.line_height = road.bank = {0, 0, 0};
  road.v = {-1, 1};
  road.height = {1, 2, 3, 4, 5, 6};
  const GridArrays arrays = arrays_of(road, 0);
  const auto at = [&](double x, double y) { return grid_height(arrays, x, y); };
  EXPECT_DOUBLE_EQ(at(-5, 0).z, 1.5);
  EXPECT_DOUBLE_EQ(at(9, 0.5).z, 5.75);
  EXPECT_EQ(at(9, 0.5).x, 0);
  EXPECT_DOUBLE_EQ(at(9, 0.5).y, 0.5);
  EXPECT_DOUBLE_EQ(at(0.5, 7).z, 3);
  EXPECT_DOUBLE_EQ(at(0.5, 7).x, 2);
  EXPECT_EQ(at(0.5, 7).y, 0);
}

/// The search through the tree against one through all segments, on a road that comes back near itself.
TEST(RoadGridHeight, FindsTheNearestSegmentOfALongRoad) {
  RoadGrid road;
  for (int i = 0; i < 3000; ++i) {
    const double angle = 0.01 * i, radius = 20 + 0.2 * angle;
    road.x.push_back(radius * std::cos(angle));
    road.y.push_back(radius * std::sin(angle));
    road.height.insert(road.height.end(), {0, 0});
  }
  road.line_height = road.bank = std::vector<double>(3000);
  road.v = {-1, 1};
  const GridArrays arrays = arrays_of(road, 0);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(-40, 40);
  for (int n = 0; n < 300; ++n) {
    const double x = place(random), y = place(random);
    double nearest = INFINITY;
    for (int i = 0; i + 1 < grid::points(arrays); ++i)
      nearest = std::min(nearest, grid::distance_from(arrays, i, x, y));
    EXPECT_EQ(grid::distance_from(arrays, grid::nearest_segment(arrays, x, y), x, y), nearest);
  }
}

}  // namespace
}  // namespace mimbre::roads::grid_test
