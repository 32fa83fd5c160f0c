#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mimbre/model_file.h"
#include "mimbre/road_file.h"
#include "roads/grid.h"

/// Roads over grids, and tyres that roll, as model files say them.
namespace mimbre::test::roads_test {
namespace {

spec::Model read(const std::string& text) {
  return parse_model("mimbre: 1\ntitle: test\n" + text, "test.yaml",
                     std::string(MIMBRE_SOURCE_DIR) + "/tests/data");
}

const std::string body = R"yaml(bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {free: {type: floating, between: [ground, b]}}
)yaml";

/// A spacing asks for a straight grid of samples over the file's own.
TEST(RoadGrids, AnOpenCrgRoadIsSampledEverySpacing) {
  const spec::Model model =
      read(body + "roads: {bend: {over: grid, file: roads/bend.crg, spacing: [0.25, 0.2]}}\n");
  const spec::Road& road = model.roads.front();
  const RoadGrid file = read_road_grid(std::string(MIMBRE_SOURCE_DIR) + "/tests/data/roads/bend.crg");
  const roads::GridArrays grid = roads::arrays_of(file, 0);
  EXPECT_EQ(road.along_line.along(), 0u);
  EXPECT_EQ(road.spacing, Eigen::Vector2d(0.25, 0.2));
  for (Eigen::Index j = 0; j < road.heights.rows(); j += 3)
    for (Eigen::Index i = 0; i < road.heights.cols(); i += 4)
      EXPECT_EQ(road.heights(j, i), roads::grid_height(grid, road.origin[0] + 0.25 * static_cast<double>(i),
                                                       road.origin[1] + 0.2 * static_cast<double>(j))
                                        .z);
  // It reaches over all of the line.
  for (std::size_t k = 0; k < file.along(); ++k) {
    const Eigen::Vector2d place(file.x[k], file.y[k]);
    EXPECT_TRUE((place.array() >= road.origin.array()).all());
    const Eigen::Vector2d end = road.origin + road.spacing.cwiseProduct(Eigen::Vector2d(
                                                  static_cast<double>(road.heights.cols() - 1),
                                                  static_cast<double>(road.heights.rows() - 1)));
    EXPECT_TRUE((place.array() <= end.array()).all());
  }
}

/// Also where its line bends, and where it is put elsewhere: the corner of the box around it goes there.
TEST(RoadGrids, AnOpenCrgRoadKeepsItsOwnGrid) {
  const spec::Model model = read(body +
                                 "roads: {straight: {over: grid, file: roads/straight.crg}, "
                                 "bend: {over: grid, file: roads/bend.crg}, "
                                 "moved: {over: grid, file: roads/bend.crg, origin: [3, 4]}}\n");
  ASSERT_EQ(model.roads.size(), 3u);
  const RoadGrid& straight = model.roads[0].along_line;
  EXPECT_EQ(straight.x, (std::vector<double>{0, 2, 4}));
  EXPECT_EQ(straight.v, (std::vector<double>{-0.5, 0, 0.5}));
  EXPECT_EQ(straight.height, (std::vector<double>{0, 0, 0.1, 0.2, -0.1, 0.3, 0.4, 0.5, 0.6}));
  const RoadGrid file = read_road_grid(std::string(MIMBRE_SOURCE_DIR) + "/tests/data/roads/bend.crg");
  const RoadGrid &bend = model.roads[1].along_line, &moved = model.roads[2].along_line;
  EXPECT_EQ(bend.x, file.x);
  EXPECT_EQ(bend.height, file.height);
  const double low_x = *std::min_element(file.x.begin(), file.x.end()),
               low_y = *std::min_element(file.y.begin(), file.y.end());
  for (std::size_t k = 0; k < file.along(); ++k) {
    EXPECT_NEAR(moved.x[k], file.x[k] - low_x + 5, 1e-12);  // 2 m wide to either side
    EXPECT_NEAR(moved.y[k], file.y[k] - low_y + 6, 1e-12);
  }
}

TEST(RoadGrids, WarnOfWhatAnOpenCrgFileAsksForInVain) {
  std::vector<Diagnostic> warnings;
  parse_model("mimbre: 1\ntitle: test\n" + body + "roads: {r: {over: grid, file: roads/modified.crg}}\n",
              "test.yaml", std::string(MIMBRE_SOURCE_DIR) + "/tests/data", {}, &warnings);
  std::string all;
  for (const Diagnostic& d : warnings) all += to_string(d) + "\n";
  EXPECT_THAT(all, testing::HasSubstr("'roads/modified.crg': $ROAD_CRG_MODS SCALE_Z_GRID is not used"));
  EXPECT_THAT(all, testing::HasSubstr("'roads/modified.crg': 1 heights between known ones are missing"));
}

TEST(RoadGrids, ARandomRoadLiesAlongX) {
  const auto road = [](const char* road_class, int seed) {
    return read(body +
                fmt::format(
                    "roads: {{r: {{over: grid, iso8608: {{class: {}, length: 100, width: 2, seed: {}}}}}}}\n",
                    road_class, seed))
        .roads.front();
  };
  const spec::Road a = road("A", 1), c = road("C", 1), other = road("A", 2);
  EXPECT_EQ(a.heights.rows(), 9);
  EXPECT_EQ(a.origin, Eigen::Vector2d(0, -1));
  EXPECT_NEAR(a.spacing[0] * static_cast<double>(a.heights.cols() - 1), 100, 0.1);
  // Each class is twice as rough as the one before, the same waves of the same seed.
  EXPECT_LT((c.heights - 4 * a.heights).norm(), 1e-9 * c.heights.norm());
  EXPECT_GT((a.heights - other.heights).norm(), 0.1 * a.heights.norm());
}

/// A mirrored wheel turns forwards about the same axis.
TEST(RollingTyres, KeepTheirAxisInAMirror) {
  const spec::Model model = read(R"yaml(
roads: {track: {over: distance, points: [[0, 0], [1, 0]], friction: 0.5, patches: [{x: [0, 1], friction: 0.1}]}}
subsystems:
  corner:
    bodies: {wheel: {mass: 1, com: [0, 1, 0.3], inertia: [1, 1, 1]}}
    joints: {hub: {type: revolute, between: [ground, wheel], at: [0, 1, 0.3], axis: [0, 1, 0]}}
    tyres: {t: {on: wheel, road: track, axis: [0.1, 1, 0], model: magic_formula, file: tyres/car_205_60R15_61.tir}}
instances:
  left: {of: corner}
  right: {of: corner, mirror: y}
)yaml");
  ASSERT_EQ(model.tyres.size(), 2u);
  const auto global = [&](int k) {
    const spec::Tyre& t = model.tyres[static_cast<std::size_t>(k)];
    const spec::Frame& f = model.frames[static_cast<std::size_t>(t.frame)];
    return Eigen::Vector3d(model.bodies[static_cast<std::size_t>(f.body)].pose.rotation * f.pose.rotation *
                           t.axis);
  };
  EXPECT_LT((global(0) - Eigen::Vector3d(0.1, 1, 0).normalized()).norm(), 1e-12);
  EXPECT_LT((global(1) - Eigen::Vector3d(-0.1, 1, 0).normalized()).norm(), 1e-12);
  EXPECT_EQ(model.tyres[0].law, "magic_tyre");
  EXPECT_EQ(model.tyres[0].radius, 0.3135);
  EXPECT_EQ(model.roads[0].friction, 0.5);
  ASSERT_EQ(model.roads[0].patches.size(), 1u);
  EXPECT_EQ(model.roads[0].patches[0].low[0], 0);
  EXPECT_LT(model.roads[0].patches[0].low[1], -1e100);
}

}  // namespace
}  // namespace mimbre::test::roads_test
