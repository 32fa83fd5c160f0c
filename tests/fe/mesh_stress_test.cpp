#include <gtest/gtest.h>

#include "fe/elements/solid_stress.h"
#include "fe/meshes.h"
#include "fe/skin.h"
#include "fe/solid_meshes.h"
#include "fe/surface.h"

/// Stress at both sides of shells, and what is seen of a mesh.
namespace mimbre::test::mesh_stress_test {
namespace {

using Eigen::Vector3d;

constexpr double thickness = 0.004;

/// Two by two distorted elements in a plane that no axis lies in; the last one turned upside down.
fe::SolidMesh plate(ElementType type, const Eigen::Matrix3d& axes) {
  fe::SolidMesh mesh;
  mesh.nodes.resize(3, 9);
  for (int k = 0; k < 9; ++k) mesh.nodes.col(k) << 0.1 * (k % 3), 0.08 * (k / 3), 0;
  mesh.nodes.col(4) += Vector3d(0.02, -0.01, 0);
  mesh.nodes = (axes * mesh.nodes).eval();
  mesh.materials = {{"steel", steel()}};
  fe::ElementGroup group{type, "plate", 0, thickness, {}, {}};
  for (const auto& q :
       {std::array{0, 1, 4, 3}, std::array{1, 2, 5, 4}, std::array{3, 4, 7, 6}, std::array{4, 7, 8, 5}})
    if (type == ElementType::quad4)
      group.nodes.insert(group.nodes.end(), q.begin(), q.end());
    else
      group.nodes.insert(group.nodes.end(), {q[0], q[1], q[2], q[0], q[2], q[3]});
  mesh.groups.push_back(group);
  return mesh;
}

TEST(MeshStress, BothSidesOfStretchedAndBentPlatesHaveTheirExactStress) {
  const double E = steel().young, nu = steel().poisson;
  const Eigen::Vector3d stretch(1e-4, -4e-5, 7e-5), bend(0.2, -0.1, 0.3);  // xx, yy, engineering xy
  const Eigen::Matrix3d axes = some_rotation();
  Eigen::Matrix3d elastic;
  elastic << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  elastic *= E / (1 - nu * nu);
  for (ElementType type : {ElementType::tri3, ElementType::quad4}) {
    const fe::SolidMesh mesh = plate(type, axes);
    Eigen::VectorXd u(6 * mesh.nodes.cols());
    for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n) {
      const Vector3d p = axes.transpose() * mesh.nodes.col(n);
      const double x = p.x(), y = p.y();
      // κ = −∂²w: the side at +z is compressed where w curves upwards
      const Vector3d displacement(stretch[0] * x + 0.2 * stretch[2] * y,
                                  0.8 * stretch[2] * x + stretch[1] * y,
                                  0.5 * (bend[0] * x * x + bend[1] * y * y + bend[2] * x * y));
      const Vector3d rotation(bend[1] * y + 0.5 * bend[2] * x, -(bend[0] * x + 0.5 * bend[2] * y),
                              0.3 * stretch[2]);
      u.segment<3>(6 * n) = axes * displacement;
      u.segment<3>(6 * n + 3) = axes * rotation;
    }
    const fe::Surface seen = fe::surface(mesh);
    ASSERT_EQ(seen.points.size(), 18u);
    const fe::Recovery r = fe::recover(mesh, seen.points, fe::assemble(mesh).dofs, u);
    for (std::size_t k = 0; k < seen.points.size(); ++k) {
      const double z = seen.points[k].offset.dot(axes.col(2));
      EXPECT_NEAR(std::abs(z), thickness / 2, 1e-15);
      const Vector3d strain = stretch - z * bend;
      const Vector3d s = elastic * strain;
      Eigen::Matrix3d stress = Eigen::Matrix3d::Zero(), tensor = Eigen::Matrix3d::Zero();
      stress.topLeftCorner<2, 2>() << s[0], s[2], s[2], s[1];
      tensor.topLeftCorner<2, 2>() << strain[0], strain[2] / 2, strain[2] / 2, strain[1];
      tensor(2, 2) = -nu / E * (s[0] + s[1]);
      stress = (axes * stress * axes.transpose()).eval();
      tensor = (axes * tensor * axes.transpose()).eval();
      fe::Vector6 exact, exact_strain;
      exact << stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(2, 0);
      exact_strain << tensor(0, 0), tensor(1, 1), tensor(2, 2), 2 * tensor(0, 1), 2 * tensor(1, 2),
          2 * tensor(2, 0);
      EXPECT_LT((r.stress.col(0).segment<6>(6 * k) - exact).norm(), 1e-9 * exact.norm()) << type_name(type);
      EXPECT_LT((r.strain.col(0).segment<6>(6 * k) - exact_strain).norm(), 1e-9 * exact_strain.norm());
    }
  }
}

/// Signed volume of what the triangles enclose.
double volume(const fe::SolidMesh& mesh, const fe::Surface& seen) {
  double sum = 0;
  const auto at = [&](int k) -> Vector3d {
    const fe::SurfacePoint& p = seen.points[static_cast<std::size_t>(k)];
    return mesh.nodes.col(p.node) + p.offset;
  };
  for (const auto& [a, b, c] : seen.triangles) sum += at(a).dot(at(b).cross(at(c))) / 6;
  return sum;
}

TEST(Surface, FacesOutwardsWithSharpEdges) {
  for (ElementType type : {ElementType::tet10, ElementType::hex8, ElementType::wedge15}) {
    const fe::SolidMesh mesh = block(type, {1, 0.5, 0.25}, {4, 3, 2}, steel());
    const fe::Surface seen = fe::surface(mesh);
    EXPECT_NEAR(volume(mesh, seen), 0.125, 1e-12) << type_name(type);
    EXPECT_EQ(seen.lines.size(), 4u * (4 + 3 + 2)) << type_name(type);
    for (const fe::SurfacePoint& p : seen.points) EXPECT_TRUE(p.offset.isZero(0));
  }
}

TEST(Surface, OfAShellIsItsTwoSidesWhateverTheWayItsElementsFace) {
  const fe::SolidMesh mesh = plate(ElementType::quad4, some_rotation());
  const fe::Surface seen = fe::surface(mesh);
  EXPECT_EQ(seen.triangles.size(), 16u);
  // Seen from a point of the middle plane: two cones of half the thickness over the whole area.
  EXPECT_NEAR(volume(mesh, seen), 0.2 * 0.16 * thickness / 3, 1e-12);
  EXPECT_EQ(seen.lines.size(), 16u);  // the rims
}

TEST(Surface, OfShellsThatLieOnEachOtherHasTwoSidesToo) {
  fe::SolidMesh mesh = plate(ElementType::tri3, some_rotation());
  mesh.groups.push_back(mesh.groups[0]);
  for (const fe::SurfacePoint& p : fe::surface(mesh).points)
    EXPECT_NEAR(p.offset.norm(), thickness / 2, 1e-15);
}

}  // namespace
}  // namespace mimbre::test::mesh_stress_test
