#include "results/thin_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "fe/skin.h"
#include "mimbre/fe_mesh.h"

namespace mimbre::results::thin_surface_test {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::IsEmpty;

struct Surface {
  Eigen::Matrix3Xd points;
  std::vector<std::array<int, 3>> triangles;
};

/// The skin of a box of bricks, axes-parallel, one corner at the origin.
Surface box(const Vector3d& size, int x, int y, int z) {
  fe::SolidMesh mesh;
  const auto node = [&](int i, int j, int k) { return i + (x + 1) * (j + (y + 1) * k); };
  mesh.nodes.resize(3, (x + 1) * (y + 1) * (z + 1));
  fe::ElementGroup group;
  group.type = fe::ElementType::hex8;
  for (int k = 0; k <= z; ++k)
    for (int j = 0; j <= y; ++j)
      for (int i = 0; i <= x; ++i) {
        mesh.nodes.col(node(i, j, k)) = size.cwiseProduct(
            Vector3d(i / static_cast<double>(x), j / static_cast<double>(y), k / static_cast<double>(z)));
        if (i == x || j == y || k == z) continue;
        for (const int n :
             {node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k), node(i, j, k + 1),
              node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)})
          group.nodes.push_back(n);
      }
  mesh.groups.push_back(group);
  return {mesh.nodes, fe::skin(mesh).triangles};
}

double volume(const Eigen::Matrix3Xd& points, const std::vector<std::array<int, 3>>& triangles) {
  double sum = 0;
  for (const auto& t : triangles)
    sum += points.col(t[0]).dot(points.col(t[1]).cross(Vector3d(points.col(t[2])))) / 6;
  return sum;
}

Eigen::Matrix3Xd kept(const Eigen::Matrix3Xd& points, const ThinSurface& thin) {
  Eigen::Matrix3Xd out(3, static_cast<Eigen::Index>(thin.points.size()));
  for (std::size_t k = 0; k < thin.points.size(); ++k)
    out.col(static_cast<Eigen::Index>(k)) = points.col(thin.points[k]);
  return out;
}

TEST(FeatureEdges, AreTheTwelveOfABox) {
  const Surface surface = box({1, 2, 3}, 2, 3, 4);
  const auto edges = feature_edges(surface.points, surface.triangles);
  EXPECT_EQ(edges.size(), 4u * (2 + 3 + 4));
  for (const auto& [a, b] : edges) {
    EXPECT_LT(a, b);
    int on_planes = 0;  // both ends in two of the six faces
    for (int axis = 0; axis < 3; ++axis)
      for (const double plane : {0.0, axis + 1.0})
        on_planes += std::abs(surface.points(axis, a) - plane) < 1e-12 &&
                     std::abs(surface.points(axis, b) - plane) < 1e-12;
    EXPECT_EQ(on_planes, 2);
  }
}

TEST(FeatureEdges, BordersFoldsAndBranchesCount) {
  Eigen::Matrix3Xd points(3, 5);
  points << 0, 1, 0, 1, 0.5,  //
      0, 0, 1, 1, 0,          //
      0, 0, 0, 0, 1;
  const std::array<int, 2> shared{1, 2};
  const auto has = [&](std::vector<std::array<int, 3>> triangles) {
    const auto edges = feature_edges(points, triangles);
    return std::find(edges.begin(), edges.end(), shared) != edges.end();
  };
  EXPECT_TRUE(has({{0, 1, 2}}));
  EXPECT_FALSE(has({{0, 1, 2}, {1, 3, 2}}));
  EXPECT_FALSE(has({{0, 1, 2}, {1, 2, 3}}));  // a shell's triangles need not agree on their sides
  EXPECT_TRUE(has({{0, 1, 2}, {1, 3, 2}, {1, 4, 2}}));
  points(2, 3) = 0.9;
  EXPECT_TRUE(has({{0, 1, 2}, {1, 3, 2}}));
}

TEST(FreeLines, AreThoseOfNoTriangle) {
  EXPECT_THAT(free_lines({{1, 0}, {2, 3}, {0, 2}}, {{0, 1, 2}}), ElementsAre(std::array<int, 2>{2, 3}));
  EXPECT_THAT(free_lines({{1, 0}}, {}), ElementsAre(std::array<int, 2>{1, 0}));
}

TEST(ThinSurface, FewPointsStayAsTheyAre) {
  const Surface surface = box({1, 1, 1}, 3, 3, 3);
  const ThinSurface thin = thin_surface(surface.points, surface.triangles, {{0, 63}}, 64);
  EXPECT_EQ(thin.points.size(), 64u);  // the eight within the box too
  EXPECT_EQ(thin.triangles, surface.triangles);
  EXPECT_THAT(thin.lines, ElementsAre(std::array<int, 2>{0, 63}));
  EXPECT_EQ(thin.edges.size(), 36u);
}

TEST(ThinSurface, ManyBecomeFewOfTheSameShape) {
  const Surface surface = box({1, 0.6, 0.4}, 50, 30, 20);
  const ThinSurface thin = thin_surface(surface.points, surface.triangles, {}, 600);
  EXPECT_LE(thin.points.size(), 600u);
  EXPECT_GT(thin.points.size(), 250u);
  EXPECT_TRUE(std::is_sorted(thin.points.begin(), thin.points.end()));
  const Eigen::Matrix3Xd points = kept(surface.points, thin);
  EXPECT_NEAR(volume(points, thin.triangles), 0.24, 0.01 * 0.24);
  // All corners of the box are there.
  for (const double x : {0.0, 1.0})
    for (const double y : {0.0, 0.6})
      for (const double z : {0.0, 0.4})
        EXPECT_LT((points.colwise() - Vector3d(x, y, z)).colwise().norm().minCoeff(), 1e-12);
  std::set<std::array<int, 3>> seen;
  for (auto t : thin.triangles) {
    for (const int point : t) ASSERT_LT(point, static_cast<int>(thin.points.size()));
    std::sort(t.begin(), t.end());
    EXPECT_TRUE(t[0] < t[1] && t[1] < t[2]);
    EXPECT_TRUE(seen.insert(t).second);
  }
  for (const auto& [a, b] : thin.edges) {
    EXPECT_LT(a, b);
    for (const int point : {a, b}) {
      int faces = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double r = points(axis, point),
                     high = std::array{1.0, 0.6, 0.4}[static_cast<std::size_t>(axis)];
        faces += r < 1e-12 || r > high - 1e-12;
      }
      EXPECT_GE(faces, 2);
    }
  }
}

/// A sheet much thinner than a cell keeps both of its sides.
TEST(ThinSurface, ThinWallsKeepTheirThickness) {
  const Surface surface = box({1, 1, 0.002}, 60, 60, 1);
  const ThinSurface thin = thin_surface(surface.points, surface.triangles, {}, 500);
  EXPECT_LE(thin.points.size(), 500u);
  EXPECT_NEAR(volume(kept(surface.points, thin), thin.triangles), 0.002, 0.1 * 0.002);
}

TEST(ThinSurface, KeepsTheHeaviestOfEachCell) {
  const Surface surface = box({1, 1, 1}, 30, 30, 30);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(surface.points.cols());
  std::vector<int> heavy;  // on three faces
  for (const Vector3d& place : {Vector3d(0.4, 0.5, 0), Vector3d(0, 0.3, 0.7), Vector3d(1, 0.9, 0.1)}) {
    Eigen::Index nearest = 0;
    (surface.points.colwise() - place).colwise().norm().minCoeff(&nearest);
    heavy.push_back(static_cast<int>(nearest));
    weights(nearest) = 1;
  }
  const ThinSurface thin = thin_surface(surface.points, surface.triangles, {}, 300, weights);
  EXPECT_LE(thin.points.size(), 300u);
  for (const int point : heavy)
    EXPECT_TRUE(std::binary_search(thin.points.begin(), thin.points.end(), point));
}

TEST(ThinSurface, LinesAreThinnedAndUnusedPointsDropped) {
  const int count = 5000;
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, count + 10);
  std::vector<std::array<int, 2>> lines;
  for (int k = 0; k < count; ++k) {
    points(0, k) = k;
    if (k > 0) lines.push_back({k - 1, k});
  }
  points.rightCols(10).setConstant(1e9);
  const ThinSurface thin = thin_surface(points, {}, lines, 100);
  EXPECT_LE(thin.points.size(), 100u);
  EXPECT_LT(thin.points.back(), count);
  EXPECT_EQ(thin.lines.size(), thin.points.size() - 1);
  EXPECT_THAT(thin.triangles, IsEmpty());
}

TEST(ThinSurface, SurvivesWhatHasNoExtentAndWhatIsNotFinite) {
  const Eigen::Matrix3Xd same = Eigen::Matrix3Xd::Ones(3, 200);
  std::vector<std::array<int, 3>> triangles;
  for (int k = 2; k < 200; ++k) triangles.push_back({k - 2, k - 1, k});
  EXPECT_EQ(thin_surface(same, triangles, {}, 100).points.size(), 1u);
  Surface surface = box({1, 1, 1}, 10, 10, 10);
  surface.points(1, 17) = NAN;
  EXPECT_LE(thin_surface(surface.points, surface.triangles, {}, 200).points.size(), 200u);
  EXPECT_THAT(thin_surface(same, {}, {}, 100).points, IsEmpty());
}

}  // namespace
}  // namespace mimbre::results::thin_surface_test
