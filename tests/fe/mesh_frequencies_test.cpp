#include <gtest/gtest.h>

#include <numbers>

#include "fe/solid_meshes.h"
#include "fe/solve/lowest_modes.h"
#include "mimbre/fe_mesh.h"

namespace mimbre::test::mesh_frequencies_test {
namespace {

/// Lowest frequencies (Hz) with the dofs where held(position, direction).
Eigen::VectorXd frequencies(const fe::SolidMesh& mesh, int count, double shift,
                            const std::function<bool(const Eigen::Vector3d&, int)>& held) {
  const fe::FeMatrices matrices = fe::assemble(mesh);
  std::vector<Eigen::Triplet<double>> ones;
  int columns = 0;
  for (int r = 0; r < static_cast<int>(matrices.dofs.size()); ++r)
    if (!held(mesh.nodes.col(matrices.dofs[r].node), matrices.dofs[r].direction))
      ones.emplace_back(r, columns++, 1.0);
  Eigen::SparseMatrix<double> free(matrices.stiffness.rows(), columns);
  free.setFromTriplets(ones.begin(), ones.end());
  const Eigen::SparseMatrix<double> K =
      free.transpose() * Eigen::SparseMatrix<double>(matrices.stiffness.selfadjointView<Eigen::Lower>()) *
      free;
  const Eigen::SparseMatrix<double> M =
      free.transpose() * Eigen::SparseMatrix<double>(matrices.mass.selfadjointView<Eigen::Lower>()) * free;
  const fe::SymmetricSolver factor(K - shift * M);
  return fe::lowest_modes(M, count, shift, factor).eigenvalues.cwiseMax(0).cwiseSqrt() /
         (2 * std::numbers::pi);
}

TEST(MeshFrequencies, ThickPlateHasThePublishedFrequencies) {
  // NAFEMS FV52: solid square plate, simply supported along the lower edges; three rigid motions in its
  // plane, then 45.897, 109.44 (twice), 167.89 Hz.
  const fe::Material material{200e9, 0.3, 8000};
  for (ElementType type : {ElementType::hex8, ElementType::hex20, ElementType::wedge15, ElementType::tet10}) {
    const int side = type == ElementType::hex20 ? 4 : type == ElementType::hex8 ? 10 : 5;
    const int layers = type == ElementType::hex8 ? 3 : 1;
    const fe::SolidMesh mesh = block(type, {10, 10, 1}, {side, side, layers}, material);
    const Eigen::VectorXd f = frequencies(mesh, 7, -1e3, [](const Eigen::Vector3d& x, int direction) {
      const bool rim = x.x() < 1e-9 || x.x() > 10 - 1e-9 || x.y() < 1e-9 || x.y() > 10 - 1e-9;
      return rim && direction == 2 && x.z() < 1e-9;
    });
    SCOPED_TRACE(type_name(type));
    EXPECT_LT(f.head<3>().maxCoeff(), 1e-2);
    EXPECT_NEAR(f[3] / 45.897, 1, 0.04);
    EXPECT_NEAR(f[4] / 109.44, 1, 0.05);
    EXPECT_NEAR(f[5] / 109.44, 1, 0.05);
    EXPECT_NEAR(f[6] / 167.89, 1, 0.05);
  }
}

TEST(MeshFrequencies, ThinPlateOfShellsHasKirchhoffsFrequencies) {
  const fe::Material material{200e9, 0.3, 8000};
  const double t = 0.01;
  const double D = material.young * t * t * t / (12 * (1 - 0.09));
  const auto exact = [&](int m, int n) {  // sides 1.5 and 1
    return std::numbers::pi / 2 * (m * m / 2.25 + n * n) * std::sqrt(D / (material.density * t));
  };
  for (ElementType type : {ElementType::tri3, ElementType::quad4}) {
    // In a plane that no axis lies in; simply supported: the rim's deflection and its rotation about the
    // direction across the side are held, which needs axes of the plate. So only the matrices of a plate
    // along the axes are used.
    const fe::SolidMesh mesh = shell_mesh(type, 15, 10, material, t,
                                          [](double x, double y) { return Eigen::Vector3d(1.5 * x, y, 0); });
    const Eigen::VectorXd f = frequencies(mesh, 4, 0, [](const Eigen::Vector3d& x, int direction) {
      const bool side_x = x.x() < 1e-9 || x.x() > 1.5 - 1e-9;
      const bool side_y = x.y() < 1e-9 || x.y() > 1 - 1e-9;
      const bool in_plane = direction == 0 || direction == 1 || direction == 5;
      return in_plane || (direction == 2 && (side_x || side_y)) || (direction == 3 && side_x) ||
             (direction == 4 && side_y);
    });
    SCOPED_TRACE(type_name(type));
    EXPECT_NEAR(f[0] / exact(1, 1), 1, 0.006);
    EXPECT_NEAR(f[1] / exact(2, 1), 1, 0.011);
    EXPECT_NEAR(f[2] / exact(1, 2), 1, 0.011);
    EXPECT_NEAR(f[3] / exact(3, 1), 1, 0.014);
  }
}

TEST(MeshFrequencies, TaperedMembraneHasThePublishedFrequencies) {
  // NAFEMS FV32: cantilever 10 m long, 5 m high at the root and 1 m at the tip, moves in its plane.
  const fe::Material material{200e9, 0.3, 8000};
  const double published[] = {44.623, 130.03, 162.70, 246.05, 379.90, 391.44};
  for (ElementType type : {ElementType::tri3, ElementType::quad4}) {
    const fe::SolidMesh mesh = shell_mesh(type, 24, 12, material, 0.05, [](double x, double y) {
      return Eigen::Vector3d(10 * x, (y - 0.5) * (5 - 4 * x), 0);
    });
    const Eigen::VectorXd f = frequencies(mesh, 6, 0, [](const Eigen::Vector3d& x, int direction) {
      // At the root the material still turns about the normal, as it shears.
      const bool in_plane = direction == 0 || direction == 1 || direction == 5;
      return !in_plane || (x.x() < 1e-9 && direction != 5);
    });
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(f[k] / published[k], 1, 0.015) << type_name(type) << " mode " << k;
  }
}

}  // namespace
}  // namespace mimbre::test::mesh_frequencies_test
