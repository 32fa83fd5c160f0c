#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "compile/triangle_mesh.h"
#include "forces/surfaces/table.h"
#include "math/dual.h"
#include "support/random_mechanism.h"

/// Distances from surfaces, against closed forms, other kinds of surfaces and every triangle by itself.
namespace mimbre::test::surfaces_test {
namespace {

using Triangle = std::array<int, 3>;

struct Mesh {
  std::vector<Vec3d> vertices;
  std::vector<Triangle> triangles;
};

Mesh box_mesh(const Vec3d& edges) {
  Mesh m;
  for (int k = 0; k < 8; ++k)
    m.vertices.push_back(0.5 * Vec3d(k & 1 ? edges[0] : -edges[0], k & 2 ? edges[1] : -edges[1],
                                     k & 4 ? edges[2] : -edges[2]));
  for (const std::array<int, 4>& face :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    m.triangles.push_back({face[0], face[1], face[2]});
    m.triangles.push_back({face[0], face[2], face[3]});
  }
  return m;
}

/// A torus that is bent, so that it is neither convex nor symmetric.
Mesh torus(int around, int across) {
  Mesh m;
  const auto number = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across,
                   r = 1 + 0.35 * std::cos(v) * (1 + 0.2 * std::sin(3 * u));
      m.vertices.push_back({r * std::cos(u), r * std::sin(u), 0.35 * std::sin(v) + 0.2 * std::sin(2 * u)});
    }
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      m.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
      m.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
    }
  return m;
}

SurfaceData surface(const char* kind, const Vec3d& size = Vec3d::Zero()) {
  return {find_surface(kind), size, {}};
}
SurfaceData surface(const Mesh& mesh) {
  return {find_surface("mesh"), Vec3d::Zero(), triangle_mesh(mesh.vertices, mesh.triangles)};
}

SurfaceData hills() {
  Eigen::MatrixXd heights(7, 9);
  for (int j = 0; j < 7; ++j)
    for (int i = 0; i < 9; ++i) heights(j, i) = 0.3 * std::sin(0.9 * i) * std::cos(0.7 * j) + 0.05 * i;
  return {find_surface("heights"), Vec3d::Zero(), height_mesh(heights, {0.25, 0.3})};
}

std::vector<SurfaceData> all_surfaces() {
  std::vector<SurfaceData> all{surface("half_space"), surface("box", {1, 0.6, 0.3}),
                               surface("cylinder", {0.4, 1.2, 0}), surface("capsule", {0.3, 0.9, 0}),
                               surface("sphere", {0.7, 0, 0})};
  all.push_back(surface(torus(24, 12)));
  all.push_back(hills());
  return all;
}

/// The normal is the distance's gradient, of length 1, and leads to the surface; the distance grows nowhere
/// faster than the way. Derivatives by dual numbers are those of both.
TEST(Surfaces, NormalsAreGradientsOfDistances) {
  Random random(3);
  for (const SurfaceData& s : all_surfaces()) {
    int smooth = 0;
    for (int round = 0; round < 2000; ++round) {
      const Vec3d p = random.values(3, 1.2), way = random.values(3, 1);
      const Touch<double> here = surfaces::touch(s, p);
      EXPECT_NEAR(here.normal.norm(), 1, 1e-12);
      const double h = 1e-6;
      const Touch<double> up = surfaces::touch(s, Vec3d(p + h * way)),
                          down = surfaces::touch(s, Vec3d(p - h * way));
      EXPECT_LE(std::abs(up.distance - down.distance), 2 * h * way.norm() * (1 + 1e-9));
      if (here.distance > 1e-3) {
        EXPECT_NEAR(surfaces::touch(s, Vec3d(p - here.distance * here.normal)).distance, 0, 1e-9) << s.kind;
      }
      // Not across an edge of the inside, from which two faces are as near.
      if ((up.normal - down.normal).norm() > 1e-3) continue;
      ++smooth;
      EXPECT_NEAR((up.distance - down.distance) / (2 * h), here.normal.dot(way), 1e-8) << s.kind;
      Vec3<Dual> dual;
      for (int k = 0; k < 3; ++k) dual[k] = Dual(p[k], way[k]);
      const Touch<Dual> with = surfaces::touch(s, dual);
      EXPECT_NEAR(with.distance.value, here.distance, 1e-15);
      EXPECT_NEAR(with.distance.derivative, here.normal.dot(way), 1e-12);
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(with.normal[k].derivative, (up.normal[k] - down.normal[k]) / (2 * h),
                    1e-5 / std::abs(here.distance))
            << s.kind;
    }
    EXPECT_GT(smooth, 1900) << s.kind;
  }
}

TEST(Surfaces, ABoxOfTrianglesIsABox) {
  const Vec3d edges(1, 0.6, 0.3);
  const SurfaceData box = surface("box", edges), mesh = surface(box_mesh(edges));
  Random random(4);
  for (int round = 0; round < 5000; ++round) {
    const Vec3d p = random.values(3, 1);
    const Touch<double> a = surfaces::touch(box, p), b = surfaces::touch(mesh, p);
    ASSERT_NEAR(a.distance, b.distance, 1e-12);
    if (a.distance > 0) {
      ASSERT_NEAR((a.normal - b.normal).norm(), 0, 1e-9);
    }
  }
}

/// The tree finds what looking at every triangle finds; inside is where the triangles turn round the point
/// once (Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 1983: solid angles).
TEST(Surfaces, ATreeFindsTheNearestOfAllTriangles) {
  const Mesh mesh = torus(24, 12);
  ASSERT_EQ(why_not_closed(mesh.vertices, mesh.triangles), "");
  const SurfaceData s = surface(mesh);
  Random random(5);
  int inside = 0;
  for (int round = 0; round < 2000; ++round) {
    const Vec3d p = random.values(3, 1.3);
    double least = 1e9, turns = 0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3d &a = mesh.vertices[static_cast<std::size_t>(t[0])],
                  &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                  &c = mesh.vertices[static_cast<std::size_t>(t[2])];
      int where = 0;
      least = std::min(least, (p - surfaces::nearest_in_triangle(a, b, c, p, where)).norm());
      const Vec3d x = a - p, y = b - p, z = c - p;
      turns += 2 * std::atan2(x.dot(y.cross(z)), x.norm() * y.norm() * z.norm() + x.dot(y) * z.norm() +
                                                     y.dot(z) * x.norm() + z.dot(x) * y.norm());
    }
    const bool in = turns > 2 * std::numbers::pi;
    inside += in;
    ASSERT_NEAR(surfaces::touch(s, p).distance, in ? -least : least, 1e-12);
  }
  EXPECT_GT(inside, 100);
}

TEST(Surfaces, LevelHeightsAreAHalfSpaceBeyondTheirBorderToo) {
  const SurfaceData level{find_surface("heights"), Vec3d::Zero(),
                          height_mesh(Eigen::MatrixXd::Constant(4, 5, 0.2), {0.1, 0.2})};
  Random random(6);
  for (int round = 0; round < 500; ++round) {
    const Vec3d p = random.values(3, 5);
    const Touch<double> t = surfaces::touch(level, p);
    ASSERT_NEAR(t.distance, p[2] - 0.2, 1e-11);
    ASSERT_NEAR(t.normal[2], 1, 1e-12);
  }
}

TEST(Surfaces, CentresAndAxesHaveSomeNormal) {
  for (const SurfaceData& s : all_surfaces()) {
    const Touch<double> t = surfaces::touch(s, Vec3d(Vec3d::Zero()));
    EXPECT_TRUE(std::isfinite(t.distance)) << s.kind;
    EXPECT_NEAR(t.normal.norm(), 1, 1e-12) << s.kind;
    Vec3<Dual> p;
    for (int k = 0; k < 3; ++k) p[k] = Dual(0, 1);
    EXPECT_TRUE(std::isfinite(surfaces::touch(s, p).distance.derivative)) << s.kind;
  }
}

TEST(Surfaces, OpenMeshesAreRefused) {
  Mesh box = box_mesh({1, 1, 1});
  EXPECT_EQ(why_not_closed(box.vertices, box.triangles), "");
  Mesh open = box;
  open.triangles.pop_back();
  EXPECT_NE(why_not_closed(open.vertices, open.triangles).find("not closed"), std::string::npos);
  Mesh turned = box;
  for (Triangle& t : turned.triangles) std::swap(t[0], t[1]);
  EXPECT_NE(why_not_closed(turned.vertices, turned.triangles).find("inside out"), std::string::npos);
  Mesh one = box;
  std::swap(one.triangles[3][0], one.triangles[3][1]);
  EXPECT_NE(why_not_closed(one.vertices, one.triangles).find("counterclockwise"), std::string::npos);
  Mesh beyond = box;
  beyond.triangles[0][0] = 8;
  EXPECT_NE(why_not_closed(beyond.vertices, beyond.triangles).find("vertex 8"), std::string::npos);
}

}  // namespace
}  // namespace mimbre::test::surfaces_test
