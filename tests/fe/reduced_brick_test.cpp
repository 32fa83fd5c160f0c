#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "fe/elements/elastic_matrix.h"
#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"
#include "support/dense.h"

/// 20-node bricks with reduced integration and anisotropic materials, against CalculiX 2.20 (C3D20R, lowest
/// free frequencies of its *FREQUENCY).
namespace mimbre::test::reduced_brick_test {
namespace {

using Eigen::Vector3d;
using Frequencies = std::array<double, 5>;

fe::SolidMesh bricks(const std::array<int, 3>& counts, const Place& place) {
  fe::SolidMesh mesh = block(ElementType::hex20, Vector3d::Ones(), counts, {2.1e11, 0.3, 7850});
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n) mesh.nodes.col(n) = place(mesh.nodes.col(n));
  for (fe::ElementGroup& group : mesh.groups) group.reduced_integration = true;
  return mesh;
}

Place pipe(double wall) {
  return [wall](const Vector3d& u) {
    const double r = 0.5 + wall * u.z(), angle = 1.5 * u.x();
    return Vector3d(r * std::cos(angle), r * std::sin(angle), u.y());
  };
}

void make_orthotropic(fe::SolidMesh& mesh, const fe::Orientation& orientation) {
  mesh.materials[0].material = {1.4e11, 0.3, 1600};
  mesh.materials[0].elastic =
      fe::elastic_matrix(fe::EngineeringConstants{1.4e11, 1e10, 1e10, 0.3, 0.3, 0.4, 5e9, 5e9, 3.5e9});
  mesh.orientations = {orientation};
  for (fe::ElementGroup& group : mesh.groups)
    group.orientations.assign(static_cast<std::size_t>(group.size()), 0);
}

void expect_free(const fe::SolidMesh& mesh, const Frequencies& calculix) {
  fe::Interface end;
  end.name = "end";
  const double least = mesh.nodes.row(2).minCoeff();
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n)
    if (mesh.nodes(2, n) < least + 1e-9) end.nodes.push_back(static_cast<int>(n));
  end.point = fe::centre_of(mesh, end.nodes);
  fe::ModelReduction options;
  options.interfaces = {end};
  options.dynamic_modes = 2;
  options.free_modes = 5;
  const Eigen::VectorXd own = fe::reduce(mesh, fe::assemble(mesh), options).free_frequencies;
  for (Eigen::Index k = 0; k < 5; ++k)
    EXPECT_NEAR(own[k], calculix[static_cast<std::size_t>(k)], 1e-3 * own[k]) << k;
}

TEST(ReducedBrick, FrequenciesAreThoseOfCalculix) {
  expect_free(bricks({3, 3, 1}, pipe(0.02)), {90.0315, 179.368, 240.865, 298.214, 374.744});
}

TEST(ReducedBrick, OneElementHasOnlyRigidMotionsWithoutEnergyAndNoneWithoutMass) {
  const fe::SolidMesh mesh = bricks({1, 1, 1}, [](const Vector3d& u) {
    return Vector3d(u.x() + 0.1 * u.y() * u.y(), 0.7 * u.y() + 0.1 * u.z(),
                    0.4 * u.z() - 0.1 * u.x() * u.y());
  });
  const fe::FeMatrices matrices = fe::assemble(mesh);
  const Eigen::MatrixXd K = full(matrices.stiffness), M = full(matrices.mass);
  EXPECT_LT((K * rigid_motions(mesh.nodes)).cwiseAbs().maxCoeff(), 1e-12 * K.cwiseAbs().maxCoeff());
  EXPECT_GT(symmetric_eigenvalues(M)[0], 0);
  const Eigen::VectorXd squares = symmetric_eigenvalues(K, M);
  EXPECT_LT(std::abs(squares[5]), 1e-6 * squares[6]);
  EXPECT_GT(squares[6], 0);
}

TEST(Anisotropy, FrequenciesAreThoseOfCalculix) {
  fe::SolidMesh plate =
      bricks({4, 4, 2}, [](const Vector3d& u) { return Vector3d(u.x(), u.y(), 0.2 * u.z()); });
  fe::Orientation turned;
  turned.axes = Eigen::AngleAxisd(std::atan(0.5), Vector3d::UnitZ()).toRotationMatrix();
  make_orthotropic(plate, turned);
  expect_free(plate, {348.935, 467.821, 725.56, 1016.99, 1022.88});

  fe::SolidMesh wall = bricks({6, 4, 1}, pipe(0.05));
  fe::Orientation round;
  round.kind = fe::Orientation::Kind::cylindrical;
  make_orthotropic(wall, round);
  expect_free(wall, {98.0227, 202.204, 251.525, 265.523, 286.24});
}

TEST(Anisotropy, ConstantsOfAnIsotropicMaterialGiveItsMatrixInAnyDirections) {
  const double E = 2.1e11, nu = 0.3, G = E / (2 * (1 + nu));
  const fe::ElasticMatrix given = fe::elastic_matrix(fe::EngineeringConstants{E, E, E, nu, nu, nu, G, G, G});
  const fe::ElasticMatrix right = fe::elasticity({E, nu, 1});
  EXPECT_LT((given - right).norm(), 1e-12 * right.norm());
  EXPECT_LT((fe::turned(given, some_rotation()) - right).norm(), 1e-12 * right.norm());
  EXPECT_THROW(fe::elastic_matrix(fe::EngineeringConstants{E, E, E, 0.9, 0.9, 0.9, G, G, G}),
               std::invalid_argument);
}

}  // namespace
}  // namespace mimbre::test::reduced_brick_test
