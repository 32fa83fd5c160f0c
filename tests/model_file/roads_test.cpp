#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/model_file.h"
#include "mimbre/road_file.h"
#include "roads/grid.h"

/// Roads over grids, and tyres that roll, as model files say them.
namespace mimbre::test {
namespace {

spec::Model read(const std::string& text) {
  return parse_model("mimbre: 1\ntitle: test\n" + text, "test.yaml",
                     std::string(MIMBRE_SOURCE_DIR) + "/tests/data");
}

const std::string body = R"yaml(bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {free: {type: floating, between: [ground, b]}}
)yaml";

/// The straight grid has the heights of the file's curved one, at its own points.
TEST(RoadGrids, AnOpenCrgRoadIsSampled) {
  const spec::Model model =
      read(body + "roads: {bend: {over: grid, file: roads/bend.crg, spacing: [0.25, 0.2]}}\n");
  const spec::Road& road = model.roads.front();
  const RoadGrid file = read_road_grid(std::string(MIMBRE_SOURCE_DIR) + "/tests/data/roads/bend.crg");
  const roads::GridArrays arrays = roads::arrays_of(file);
  const roads::GridData grid = roads::view_of(arrays);
  EXPECT_EQ(road.spacing, Eigen::Vector2d(0.25, 0.2));
  for (Eigen::Index j = 0; j < road.heights.rows(); j += 3)
    for (Eigen::Index i = 0; i < road.heights.cols(); i += 4)
      EXPECT_EQ(road.heights(j, i),
                roads::road_grid_height(grid, road.origin[0] + 0.25 * static_cast<double>(i),
                                        road.origin[1] + 0.2 * static_cast<double>(j))
                    .height);
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

/// Other increments across than along: a straight road keeps its own points, and so its heights between them.
TEST(RoadGrids, AStraightOpenCrgRoadKeepsItsOwnGrid) {
  const spec::Model model = read(body + "roads: {straight: {over: grid, file: roads/straight.crg}}\n");
  const spec::Road& road = model.roads.front();
  EXPECT_EQ(road.origin, Eigen::Vector2d(0, -0.5));
  EXPECT_EQ(road.spacing, Eigen::Vector2d(2, 0.5));
  const Eigen::MatrixXd expected{{0, 0.2, 0.4}, {0, -0.1, 0.5}, {0.1, 0.3, 0.6}};
  EXPECT_TRUE(road.heights.isApprox(expected, 1e-12)) << road.heights;
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
}  // namespace mimbre::test
