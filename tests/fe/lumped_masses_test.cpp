#include "fe/lumped_masses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe.h"

/// Masses that are lumped at the nodes of beams and solids.
namespace mimbre::test::lumped_masses_test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::MassMatrix;

const fe::Section kSection = rectangle(0.02, 0.03);
constexpr double kLength = 1.3;

/// ω of a straight bar with some dofs of each node (others vanish), those of node 0 clamped.
VectorXd frequencies(int elements, const std::vector<int>& directions, MassMatrix mass_matrix,
                     fe::BeamTheory theory = fe::BeamTheory::euler_bernoulli) {
  fe::Mesh mesh = straight_beam(kLength, elements, kSection);
  for (fe::BeamElement& element : mesh.elements) {
    element.theory = theory;
    element.section.shear_y = element.section.shear_z = 0.85 * element.section.area;
  }
  const fe::Matrices matrices = fe::assemble(mesh, mass_matrix);
  std::vector<Eigen::Index> kept;
  for (int node = 1; node <= elements; ++node)
    for (const int k : directions) kept.push_back(6 * node + k);
  const MatrixXd K(matrices.stiffness), M(matrices.mass);
  return symmetric_eigenvalues(K(kept, kept), M(kept, kept)).cwiseSqrt();
}

/// Of a clamped and free chain of masses and springs ω = 2c/h sin((2k − 1) π h/(4L)), c the speed of waves:
/// below the bar's (2k − 1) π c/(2L), where consistent masses are above it.
TEST(LumpedMasses, OfStretchAndTwistAreThoseOfAChain) {
  const fe::Material m = steel();
  const double shear = m.young / (2 * (1 + m.poisson));
  const double along = std::sqrt(m.young / m.density),
               twist = std::sqrt(shear * kSection.J / (m.density * (kSection.Iy + kSection.Iz)));
  constexpr int n = 9;
  const double h = kLength / n;
  for (const auto& [direction, speed] : {std::pair{0, along}, std::pair{3, twist}}) {
    const VectorXd lumped = frequencies(n, {direction}, MassMatrix::lumped),
                   consistent = frequencies(n, {direction}, MassMatrix::consistent);
    for (int k = 0; k < n; ++k) {
      const double wave = (2 * k + 1) * std::numbers::pi / (2 * kLength);
      EXPECT_NEAR(lumped[k] / (2 * speed / h * std::sin(wave * h / 2)), 1, 1e-9);
      EXPECT_LT(lumped[k], speed * wave);
      EXPECT_GT(consistent[k], speed * wave);
    }
  }
}

/// From below, with order 2: of a cantilever in bending against the closed form (Blevins 1979, table 8-1).
TEST(LumpedMasses, OfBendingConvergeWithOrderTwoFromBelow) {
  const fe::Material m = steel();
  const double stiffness = std::sqrt(m.young * kSection.Iz / (m.density * kSection.area));
  constexpr double roots[] = {1.87510406871196, 4.69409113297417, 7.85475743823761};
  const VectorXd coarse = frequencies(20, {1, 5}, MassMatrix::lumped),
                 fine = frequencies(40, {1, 5}, MassMatrix::lumped);
  for (int k = 0; k < 3; ++k) {
    const double exact = std::pow(roots[k] / kLength, 2) * stiffness;
    EXPECT_LT(coarse[k], exact);
    EXPECT_LT(fine[k], exact);
    EXPECT_NEAR(std::log2((exact - coarse[k]) / (exact - fine[k])), 2, 0.1) << k;
    EXPECT_LT(1 - fine[k] / exact, 0.01);
  }
}

TEST(LumpedMasses, OfEveryTheoryConvergeToTheConsistentOnes) {
  for (const fe::BeamTheory theory :
       {fe::BeamTheory::euler_bernoulli, fe::BeamTheory::rayleigh, fe::BeamTheory::timoshenko}) {
    const auto difference = [&](int n) {
      const VectorXd lumped = frequencies(n, {1, 5}, MassMatrix::lumped, theory),
                     consistent = frequencies(n, {1, 5}, MassMatrix::consistent, theory);
      return VectorXd((1 - lumped.array() / consistent.array()).head(3));
    };
    const VectorXd coarse = difference(20), fine = difference(40);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::log2(coarse[k] / fine[k]), 2, 0.1) << k;
  }
}

/// Mass and moments of rigid motions: exact, but for the inertia across, 1 + (2 + 24/78)/n² times as large.
TEST(LumpedMasses, OfABarHaveItsMassAndNearlyItsInertia) {
  for (const int n : {1, 2, 4, 8}) {
    const fe::Mesh mesh = straight_beam(kLength, n, kSection);
    fe::Mesh centred = mesh;
    centred.nodes.row(0).array() -= kLength / 2;
    const MatrixXd R = rigid_motions(centred);
    const MatrixXd lumped = R.transpose() * fe::assemble(mesh, MassMatrix::lumped).mass * R,
                   exact = R.transpose() * fe::assemble(mesh).mass * R;
    EXPECT_LT((lumped.topLeftCorner(3, 6) - exact.topLeftCorner(3, 6)).norm(), 1e-12 * exact(0, 0));
    EXPECT_NEAR(lumped(3, 3) / exact(3, 3), 1, 1e-12);
    const double across = steel().density * kSection.area * std::pow(kLength, 3) / 12;
    EXPECT_NEAR(lumped(4, 4) / across, 1 + (2 + 24.0 / 78) / (n * n), 1e-9);
    EXPECT_NEAR(lumped(5, 5) / across, 1 + (2 + 24.0 / 78) / (n * n), 1e-9);
  }
}

TEST(LumpedMasses, OfAFrameWithOffsetsHaveItsMassAndCentre) {
  const fe::Mesh mesh = bent_frame();
  const MatrixXd R = rigid_motions(mesh);
  const MatrixXd lumped = R.transpose() * fe::assemble(mesh, MassMatrix::lumped).mass * R,
                 exact = R.transpose() * fe::assemble(mesh).mass * R;
  EXPECT_LT((lumped.topRows(3) - exact.topRows(3)).norm(), 1e-10 * exact.topRows(3).norm());
  EXPECT_GT((lumped - exact).norm(), 1e-4 * exact.norm());
}

/// Six rigid motions of solids.
MatrixXd inertia(const fe::SolidMesh& mesh, const fe::FeMatrices& matrices) {
  const MatrixXd R = rigid_motions(mesh.nodes);
  return R.transpose() * full(matrices.mass) * R;
}

/// Every node of every kind of element has a positive mass. Mass and centre are exact, the inertia converges
/// with order 2.
TEST(LumpedMasses, OfSolidsHaveTheirMassAndNearlyTheirInertia) {
  const Vector3d size(1.1, 0.7, 0.5);
  for (const fe::ElementType type : kSolidTypes) {
    std::vector<double> errors;
    for (const int n : {2, 4}) {
      const fe::SolidMesh mesh = block(type, size, {n, n, n}, steel());
      const fe::FeMatrices consistent = fe::assemble(mesh), lumped = fe::lump_masses(mesh, consistent);
      EXPECT_EQ((full(lumped.stiffness) - full(consistent.stiffness)).norm(), 0);
      const MatrixXd M = full(lumped.mass);
      EXPECT_GT(M.diagonal().minCoeff(), 0) << type_name(type);
      EXPECT_EQ((M - MatrixXd(M.diagonal().asDiagonal())).norm(), 0);
      const MatrixXd a = inertia(mesh, lumped), b = inertia(mesh, consistent);
      EXPECT_LT((a.topRows(3) - b.topRows(3)).norm(), 1e-10 * b.topRows(3).norm()) << type_name(type);
      errors.push_back((a - b).norm() / b.norm());
    }
    EXPECT_LT(errors[1], 0.1) << type_name(type);
    EXPECT_GT(std::log2(errors[0] / errors[1]), 1.8) << type_name(type);
  }
}

/// Of single elements too, pyramids and curved edges among them.
TEST(LumpedMasses, OfADistortedElementHaveItsMassAndCentre) {
  for (const fe::ElementType type : kSolidTypes) {
    fe::SolidMesh mesh;
    mesh.nodes = single_element(type, 0.1);
    mesh.materials = {{"steel", steel()}};
    fe::ElementGroup group;
    group.type = type;
    group.material = 0;
    for (int k = 0; k < fe::node_count(type); ++k) group.nodes.push_back(k);
    mesh.groups = {group};
    const fe::FeMatrices consistent = fe::assemble(mesh), lumped = fe::lump_masses(mesh, consistent);
    EXPECT_GT(full(lumped.mass).diagonal().minCoeff(), 0) << type_name(type);
    const MatrixXd a = inertia(mesh, lumped), b = inertia(mesh, consistent);
    EXPECT_LT((a.topRows(3) - b.topRows(3)).norm(), 1e-10 * b.topRows(3).norm()) << type_name(type);
  }
}

TEST(LumpedMasses, NameWhatCannotBeLumped) {
  const auto message = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  const fe::SolidMesh shell = shell_mesh(fe::ElementType::quad4, 2, 2, steel(), 0.01,
                                         [](double x, double y) { return Vector3d(x, y, 0); });
  EXPECT_THAT(message([&] { fe::lump_masses(shell, fe::assemble(shell)); }),
              testing::HasSubstr("masses of shells are not lumped"));
  const fe::SolidMesh solid = block(fe::ElementType::hex8, {1, 1, 1}, {1, 1, 1}, steel());
  fe::FeMatrices foreign = fe::assemble(solid);
  foreign.of_mesh = false;
  EXPECT_THAT(message([&] { fe::lump_masses(solid, foreign); }),
              testing::HasSubstr("another program's: take its lumped mass matrix"));
}

}  // namespace
}  // namespace mimbre::test::lumped_masses_test
