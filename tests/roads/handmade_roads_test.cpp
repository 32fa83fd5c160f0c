#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "base/cpu_time.h"
#include "roads/crg_file.h"
#include "roads/crg_writer.h"
#include "roads/grid.h"
#include "roads/overlap.h"

/// Roads of the kind of ASAM's hand-made files: heights over places against what their files mean.
namespace mimbre::test::handmade_roads_test {
namespace {

/// The largest difference of heights, m: at the points of the grid, and between them.
struct Differences {
  double at_points = 0, between = 0;
};
Differences differences(const RoadSketch& sketch, const roads::GridArrays& grid) {
  const RoadMeaning meaning(sketch);
  Differences worst;
  const auto compare = [&](const RoadPlace& at, double& most) {
    most = std::max(most, std::abs(roads::grid_height(grid, at.x, at.y).z - at.z));
  };
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0, 1), across(sketch.v.front(), sketch.v.back());
  const std::size_t each = 1 + sketch.rows() / 200;
  for (std::size_t i = 0; i < sketch.rows(); i += each) {
    for (const double v : sketch.v) compare(meaning.point(i, v), worst.at_points);
    if (i + 1 < sketch.rows())
      for (int n = 0; n < 40; ++n) compare(meaning.between(i, share(random), across(random)), worst.between);
  }
  return worst;
}

struct Kind {
  const char* name;
  RoadSketch road;
};
std::vector<Kind> kinds() {
  std::vector<Kind> all{{"straight", handmade_road(0, false, false)},
                        {"banked", handmade_road(0, true, false)},
                        {"sloped", handmade_road(0, false, true)},
                        {"curved", handmade_road(0.05, false, false)},
                        {"curved, banked and sloped", handmade_road(-0.08, true, true)},
                        {"half round", half_round_road()}};
  RoadSketch askew = handmade_road(0.04, true, true);
  askew.start_u = 100;
  askew.start_x = -320.5;
  askew.start_y = 47.25;
  askew.start_z = 12;
  all.push_back({"elsewhere", askew});
  RoadSketch wide = handmade_road(0.02, true, false);
  wide.increment = 0.8;
  wide.numbered = true;
  for (std::size_t k = 0; k < wide.v.size(); ++k) wide.v[k] = 0.5 * static_cast<double>(k) - 1;
  all.push_back({"by numbers, off the middle", wide});
  return all;
}

TEST(HandmadeRoads, HaveTheHeightsThatTheirFilesMean) {
  for (const Kind& kind : kinds())
    for (const char* form : {"LRFI", "LDFI", "KRFI", "KDFI", "KRBI", "KDBI", "LRBI", "LDBI"}) {
      SCOPED_TRACE(std::string(kind.name) + " " + form);
      const RoadGrid read = roads::parse_road_grid(written(kind.road, form), "written.crg");
      ASSERT_EQ(read.along(), kind.road.rows());
      // What seven digits and a sum of rounded headings leave.
      const double digits = form[1] == 'D' ? 1e-9 : 3e-5;
      const Differences exact = differences(kind.road, roads::arrays_of(read, 0));
      EXPECT_LT(exact.at_points, digits);
      EXPECT_LT(exact.between, digits);
      const Differences rounded = differences(kind.road, roads::arrays_of(read, roads::file_rounding));
      EXPECT_LT(rounded.at_points, 1e-4);
      EXPECT_LT(rounded.between, 1e-4);
      EXPECT_FALSE(roads::worst_overlap(read, roads::arrays_of(read, 0)));
    }
}

TEST(HandmadeRoads, OfAHalfRoundHas120Kilobytes) {
  EXPECT_THAT(written(half_round_road(), "LRFI").size(),
              testing::AllOf(testing::Ge(115000u), testing::Le(125000u)));
}

/// A bend costs no more than a few times what the same road costs straight: of the rows that a place may
/// belong to, few are looked at. CPU time, the least of some tries.
TEST(HandmadeRoads, OfAHalfRoundAreLoadedAtOnce) {
  const RoadSketch bent = half_round_road();
  RoadSketch straight = bent;
  straight.phi.clear();
  const auto seconds = [](const RoadSketch& road) {
    const std::string text = written(road, "LRFI");
    double least = 1e9;
    for (int k = 0; k < 5; ++k) {
      const double begin = thread_cpu_seconds();
      const RoadGrid read = roads::parse_road_grid(text, "written.crg");
      const roads::GridArrays grid = roads::arrays_of(read, roads::file_rounding);
      EXPECT_FALSE(roads::worst_overlap(read, grid));
      least = std::min(least, thread_cpu_seconds() - begin);
    }
    return least;
  };
  const double of_bend = seconds(bent);
  EXPECT_LT(of_bend, 1);
  EXPECT_LT(of_bend, 10 * seconds(straight));
}

/// From one edge of the road to the other and across its rows, slopes change by no jumps, although boards end
/// in kinks; with straight rows nothing else is left.
TEST(HandmadeRoads, RoundTheirKinks) {
  const RoadSketch sketch = handmade_road(0, true, true);
  const RoadGrid read = roads::parse_road_grid(written(sketch, "LDFI"), "written.crg");
  const roads::GridArrays grid = roads::arrays_of(read, roads::file_rounding);
  const double h = 1e-6;
  std::mt19937 random(8);
  std::uniform_real_distribution<double> direction(0, 6.283);
  for (int n = 0; n < 40; ++n) {
    const double angle = direction(random), dx = h * std::cos(angle), dy = h * std::sin(angle);
    // Around a point of the grid, and past the border.
    const double x = static_cast<double>(n % 23), y = sketch.v[static_cast<std::size_t>(n) % 7];
    roads::Height before = roads::grid_height(grid, x - 2000 * dx, y - 2000 * dy);
    for (int k = -1999; k <= 2000; ++k) {
      const roads::Height at = roads::grid_height(grid, x + k * dx, y + k * dy);
      const double curvature = std::abs(at.xx) + 2 * std::abs(at.xy) + std::abs(at.yy) + std::abs(before.xx) +
                               2 * std::abs(before.xy) + std::abs(before.yy);
      ASSERT_NEAR(at.x, before.x, h * curvature + 1e-9) << n << " " << k;
      ASSERT_NEAR(at.y, before.y, h * curvature + 1e-9) << n << " " << k;
      before = at;
    }
  }
}

}  // namespace
}  // namespace mimbre::test::handmade_roads_test
