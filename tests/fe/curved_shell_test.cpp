#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "fe/elements/shell_element.h"
#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"
#include "support/dense.h"

namespace mimbre::test::curved_shell_test {
namespace {

using Eigen::Vector3d;
using fe::ElementType;

/// nx × ny quadrilaterals of eight nodes, or twice as many triangles of six, over a place of two coordinates.
fe::SolidMesh quadratic_shells(ElementType type, int nx, int ny, double thickness, bool reduced,
                               const std::function<Vector3d(double, double)>& place) {
  fe::SolidMesh mesh;
  std::map<std::pair<int, int>, int> number;
  std::vector<Vector3d> places;
  const auto node = [&](int i, int j) {
    const auto [found, fresh] = number.emplace(std::pair(i, j), static_cast<int>(places.size()));
    if (fresh) places.push_back(place(i / (2.0 * nx), j / (2.0 * ny)));
    return found->second;
  };
  fe::ElementGroup group;
  group.type = type;
  group.name = "shell";
  group.material = 0;
  group.thickness = thickness;
  group.reduced_integration = reduced;
  for (int a = 0; a < 2 * nx; a += 2)
    for (int b = 0; b < 2 * ny; b += 2) {
      const auto add = [&](std::initializer_list<std::pair<int, int>> list) {
        for (const auto& [i, j] : list) group.nodes.push_back(node(a + i, b + j));
      };
      if (type == ElementType::quad8) {
        add({{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}});
      } else {
        add({{0, 0}, {2, 0}, {2, 2}, {1, 0}, {2, 1}, {1, 1}});
        add({{0, 0}, {2, 2}, {0, 2}, {1, 1}, {1, 2}, {0, 1}});
      }
    }
  mesh.nodes.resize(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) mesh.nodes.col(static_cast<Eigen::Index>(k)) = places[k];
  mesh.groups.push_back(group);
  mesh.materials = {{"steel", steel()}};
  return mesh;
}

struct Kind {
  ElementType type;
  bool reduced;
};
constexpr std::array kKinds{Kind{ElementType::tri6, false}, Kind{ElementType::quad8, false},
                            Kind{ElementType::quad8, true}};

Vector3d cylinder(double u, double v) { return {0.5 * std::cos(1.5 * u), 0.5 * std::sin(1.5 * u), v}; }

Eigen::MatrixXd six_motions(const Eigen::Matrix3Xd& nodes) {
  fe::Mesh mesh;
  mesh.nodes = nodes;
  return rigid_motions(mesh);
}

TEST(CurvedShell, OnlyRigidMotionsHaveNoEnergyAndEveryMotionHasMass) {
  for (const auto& [type, reduced] : kKinds)
    for (const double offset : {0.0, 0.03}) {
      fe::SolidMesh mesh = quadratic_shells(type, 1, 1, 0.02, reduced, cylinder);
      mesh.groups[0].nodes.resize(static_cast<std::size_t>(fe::node_count(type)));
      mesh.groups[0].offset = offset;
      mesh.nodes = (some_rotation() * mesh.nodes).colwise() + Vector3d(0.1, -0.3, 0.2);
      const fe::FeMatrices matrices = fe::assemble(mesh);
      const Eigen::MatrixXd K = full(matrices.stiffness), M = full(matrices.mass);
      const double scale = K.cwiseAbs().maxCoeff();
      Eigen::MatrixXd R(K.rows(), 6);
      const Eigen::MatrixXd all = six_motions(mesh.nodes);
      for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
        R.row(static_cast<Eigen::Index>(r)) = all.row(6 * matrices.dofs[r].node + matrices.dofs[r].direction);
      EXPECT_LT((K * R).cwiseAbs().maxCoeff(), 1e-12 * scale);
      const Eigen::VectorXd squares = symmetric_eigenvalues(K, M);
      EXPECT_LT(std::abs(squares[5]), 1e-7 * squares[6]);
      EXPECT_GT(squares[6], 0) << "a motion without energy, reduced " << reduced;
      EXPECT_GT(symmetric_eigenvalues(M)[0], 0);
    }
}

/// Energy of a field given in the shell's plane, exact for constant strains and curvatures.
void expect_energy(const Kind& kind, double wanted,
                   const std::function<Eigen::Matrix<double, 6, 1>(double, double)>& field) {
  const Eigen::Matrix3d axes = some_rotation();
  const fe::SolidMesh mesh = quadratic_shells(kind.type, 3, 2, 0.01, kind.reduced, [&](double u, double v) {
    return Vector3d(axes * Vector3d(0.3 * u + 0.05 * v, 0.2 * v, 0));
  });
  const fe::FeMatrices matrices = fe::assemble(mesh);
  Eigen::VectorXd u(6 * mesh.nodes.cols());
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n) {
    const Vector3d at = axes.transpose() * mesh.nodes.col(n);
    const auto local = field(at.x(), at.y());
    u.segment<3>(6 * n) = axes * local.head<3>();
    u.segment<3>(6 * n + 3) = axes * local.tail<3>();
  }
  EXPECT_NEAR(0.5 * u.dot(full(matrices.stiffness) * u), wanted, 1e-9 * wanted)
      << (kind.type == ElementType::tri6 ? "tri6"
          : kind.reduced                 ? "quad8 reduced"
                                         : "quad8");
}

TEST(CurvedShell, PatchTests) {
  const double E = steel().young, nu = steel().poisson, t = 0.01, area = 0.3 * 0.2;
  const auto quadratic = [&](double x, double y, double xy) {
    return x * x + y * y + 2 * nu * x * y + (1 - nu) / 2 * xy * xy;
  };
  const double ex = 1e-3, ey = -4e-4, g = 7e-4, kx = 0.2, ky = -0.1, kxy = 0.15;
  for (const Kind& kind : kKinds) {
    expect_energy(kind, 0.5 * area * t * E / (1 - nu * nu) * quadratic(ex, ey, g), [&](double x, double y) {
      Eigen::Matrix<double, 6, 1> u;
      u << ex * x + 0.5 * g * y, ey * y + 0.5 * g * x, 0, 0, 0, 0;
      return u;
    });
    expect_energy(kind, 0.5 * area * E * t * t * t / (12 * (1 - nu * nu)) * quadratic(kx, ky, kxy),
                  [&](double x, double y) {
                    Eigen::Matrix<double, 6, 1> u;
                    u << 0, 0, 0.5 * (kx * x * x + ky * y * y + kxy * x * y), ky * y + 0.5 * kxy * x,
                        -(kx * x + 0.5 * kxy * y), 0;
                    return u;
                  });
  }
}

/// Lowest free elastic frequencies, Hz.
Eigen::VectorXd free_frequencies(const fe::SolidMesh& mesh, int count) {
  fe::ModelReduction options;
  fe::Interface interface;
  interface.name = "a";
  interface.nodes = {0};
  interface.point = mesh.nodes.col(0);
  options.interfaces = {interface};
  options.dynamic_modes = 2;
  options.free_modes = count;
  return fe::reduce(mesh, fe::assemble(mesh), options).free_frequencies;
}

/// CalculiX 2.20 expands these shells into one layer of solids.
TEST(CurvedShell, FreeFrequenciesAreThoseOfCalculix) {
  const auto expect = [](const Eigen::VectorXd& own, const std::array<double, 5>& calculix) {
    for (Eigen::Index k = 0; k < 5; ++k)
      EXPECT_NEAR(own[k], calculix[static_cast<std::size_t>(k)], 0.01 * own[k]) << k;
  };
  const auto mesh = [](ElementType type, int n, double t, bool reduced) {
    fe::SolidMesh shells = quadratic_shells(type, n, n, t, reduced, cylinder);
    shells.materials[0].material = {2.1e11, 0.3, 7850};
    return shells;
  };
  expect(free_frequencies(mesh(ElementType::quad8, 4, 0.02, true), 5),
         {91.235, 183.972, 245.644, 292.804, 357.307});
  expect(free_frequencies(mesh(ElementType::tri6, 6, 0.05, false), 5),
         {223.768, 450.454, 550.915, 596.192, 602.518});
}

TEST(CurvedShell, ThinCantileverPlateVibratesAsInTheBooks) {
  fe::SolidMesh mesh = quadratic_shells(ElementType::quad8, 6, 6, 0.01, true,
                                        [](double u, double v) { return Vector3d(u, v, 0); });
  const fe::Material m = steel();
  mesh.materials[0].material = {m.young, 0.3, m.density};
  fe::Interface edge;
  edge.name = "edge";
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n)
    if (mesh.nodes(0, n) == 0) edge.nodes.push_back(static_cast<int>(n));
  fe::ModelReduction options;
  options.interfaces = {edge};
  options.dynamic_modes = 3;
  options.free_modes = 0;
  const Eigen::VectorXd held = fe::reduce(mesh, fe::assemble(mesh), options).fixed_frequencies;
  const double unit = std::sqrt(m.young * 1e-4 / (12 * (1 - 0.09) * m.density)) / (2 * std::numbers::pi);
  // Leissa, Vibration of Plates (1969): 3.49, 8.55, 21.44 by Ritz's method, upper bounds.
  EXPECT_NEAR(held[0] / unit, 3.472, 0.01);
  EXPECT_NEAR(held[1] / unit, 8.51, 0.05);
  EXPECT_NEAR(held[2] / unit, 21.3, 0.2);
}

}  // namespace
}  // namespace mimbre::test::curved_shell_test
