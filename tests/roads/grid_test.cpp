#include "roads/grid.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "roads/road_data.h"

/// Heights over places of a curved grid.
namespace mimbre::roads {
namespace {

using test::road_path;

struct Place {
  double x, y;
};
/// On the line of constant u through point i, at v; along the mitre of the segments next to it.
Place place_of(const GridArrays& arrays, int i, double v) {
  const double* p = arrays.line.data() + i * grid::line_numbers;
  return {p[0] + v * p[2], p[1] + v * p[3]};
}

/// A plane's heights are linear along and across every segment's grid, bends or not.
TEST(RoadGridHeight, OfAPlaneIsThatPlaneInBends) {
  RoadGrid road = read_road_grid(road_path("bend_double.crg"));
  std::fill(road.bank.begin(), road.bank.end(), 0.0);
  std::fill(road.line_height.begin(), road.line_height.end(), 0.0);
  GridArrays arrays = arrays_of(road);
  for (int i = 0; i < static_cast<int>(road.along()); ++i)
    for (std::size_t k = 0; k < road.across(); ++k) {
      const auto [x, y] = place_of(arrays, i, road.v[k]);
      arrays.height[static_cast<std::size_t>(i) * road.across() + k] = 3 + 0.1 * x - 0.05 * y;
    }
  const GridData data = view_of(arrays);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(0, 39.999), across(-2, 2);
  for (int n = 0; n < 2000; ++n) {
    const double u = along(random), v = across(random), f = u - std::floor(u);
    const Place a = place_of(arrays, static_cast<int>(u), v),
                b = place_of(arrays, static_cast<int>(u) + 1, v);
    const double x = (1 - f) * a.x + f * b.x, y = (1 - f) * a.y + f * b.y;
    const RoadHeight<double> at = road_grid_height(data, x, y);
    EXPECT_NEAR(at.height, 3 + 0.1 * x - 0.05 * y, 1e-12);
    EXPECT_NEAR(at.dx, 0.1, 1e-10);
    EXPECT_NEAR(at.dy, -0.05, 1e-10);
  }
}

TEST(RoadGridHeight, OfAPointIsItsHeight) {
  const RoadGrid road = read_road_grid(road_path("bend_double.crg"));
  const GridArrays arrays = arrays_of(road);
  for (int i = 0; i < 41; ++i)
    for (std::size_t k = 0; k < road.across(); ++k) {
      const auto [x, y] = place_of(arrays, i, road.v[k]);
      const std::size_t row = static_cast<std::size_t>(i);
      EXPECT_NEAR(road_grid_height(view_of(arrays), x, y).height,
                  road.height[row * road.across() + k] + road.line_height[row] + road.bank[row] * road.v[k],
                  1e-12);
    }
}

/// ASAM's own library, whose places in bends and heights are of the same formulas but heights in single
/// precision.
TEST(RoadGridHeight, IsThatOfOpenCrgsOwnLibrary) {
  const GridArrays arrays = arrays_of(read_road_grid(road_path("bend_double.crg")));
  std::ifstream file(road_path("bend.csv"));
  int count = 0;
  double worst = 0;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    double x = 0, y = 0, z = 0;
    char comma = 0;
    if (!(words >> x >> comma >> y >> comma >> z)) continue;
    ++count;
    worst = std::max(worst, std::abs(road_grid_height(view_of(arrays), x, y).height - z));
  }
  EXPECT_EQ(count, 300);
  EXPECT_LT(worst, 1e-6);
}

TEST(RoadGridHeight, SlopesAreTheDerivatives) {
  const GridArrays arrays = arrays_of(read_road_grid(road_path("bend_double.crg")));
  const GridData data = view_of(arrays);
  std::mt19937 random(7);
  // Also far beside and beyond the road.
  std::uniform_real_distribution<double> xs(5, 32), ys(-12, 12);
  int steep = 0;
  for (int n = 0; n < 2000; ++n) {
    const double x = xs(random), y = ys(random);
    const RoadHeight<Dual> by_x = road_grid_height(data, Dual(x, 1), Dual(y)),
                           by_y = road_grid_height(data, Dual(x), Dual(y, 1));
    const RoadHeight<double> at = road_grid_height(data, x, y);
    EXPECT_NEAR(by_x.height.derivative, at.dx, 1e-9 * (1 + std::abs(at.dx))) << x << " " << y;
    EXPECT_NEAR(by_y.height.derivative, at.dy, 1e-9 * (1 + std::abs(at.dy)));
    steep += at.dx != 0 ? 1 : 0;
  }
  EXPECT_GT(steep, 500);
}

/// Along lines across the whole road, also through the mitres of its bends, no step is larger than the slope.
TEST(RoadGridHeight, HasNoSteps) {
  const GridArrays arrays = arrays_of(read_road_grid(road_path("bend_double.crg")));
  const GridData data = view_of(arrays);
  const double h = 1e-4;
  for (const double v : {-1.9, -0.6, 0.1, 1.3, 1.99}) {
    double before = NAN;
    for (int i = 0; i < 40; ++i) {
      const Place a = place_of(arrays, i, v), b = place_of(arrays, i + 1, v);
      const int steps = static_cast<int>(std::hypot(b.x - a.x, b.y - a.y) / h);
      for (int k = 0; k < steps; ++k) {
        const double f = static_cast<double>(k) / steps;
        const double z = road_grid_height(data, a.x + f * (b.x - a.x), a.y + f * (b.y - a.y)).height;
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
  const GridArrays arrays = arrays_of(road);
  const auto at = [&](double x, double y) { return road_grid_height(view_of(arrays), x, y); };
  EXPECT_DOUBLE_EQ(at(-5, 0).height, 1.5);
  EXPECT_DOUBLE_EQ(at(9, 0.5).height, 5.75);
  EXPECT_EQ(at(9, 0.5).dx, 0);
  EXPECT_DOUBLE_EQ(at(9, 0.5).dy, 0.5);
  EXPECT_DOUBLE_EQ(at(0.5, 7).height, 3);
  EXPECT_DOUBLE_EQ(at(0.5, 7).dx, 2);
  EXPECT_EQ(at(0.5, 7).dy, 0);
  const RoadHeight<Pack<2>> both = road_grid_height(view_of(arrays), Pack<2>(0.5), Pack<2>(0.25));
  EXPECT_EQ(both.height[1], at(0.5, 0.25).height);
}

/// The search through blocks against one through all segments, on a road that comes back near itself.
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
  const GridArrays arrays = arrays_of(road);
  const GridData data = view_of(arrays);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(-40, 40);
  for (int n = 0; n < 300; ++n) {
    const double x = place(random), y = place(random);
    double nearest = INFINITY;
    for (int i = 0; i + 1 < data.along; ++i) nearest = std::min(nearest, grid::distance_from(data, i, x, y));
    EXPECT_EQ(grid::distance_from(data, grid::nearest_segment(data, x, y), x, y), nearest);
  }
}

}  // namespace
}  // namespace mimbre::roads
