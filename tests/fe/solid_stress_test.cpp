#include "fe/elements/solid_stress.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"

namespace mimbre::test::solid_stress_test {
namespace {

using fe::Matrix6;
using fe::Vector6;
using Stresses = Eigen::Matrix<double, 6, Eigen::Dynamic>;

Eigen::Matrix3d some_gradient() {
  Eigen::Matrix3d G;
  G << 1, 0.4, -0.3, 0.2, -0.7, 0.5, 0.6, -0.1, 0.8;
  return 1e-3 * G;
}

Eigen::Matrix3d hooke(const Eigen::Matrix3d& gradient) {
  const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
  const double shear = steel().young / (2 * (1 + steel().poisson));
  const double lame = 2 * shear * steel().poisson / (1 - 2 * steel().poisson);
  return lame * strain.trace() * Eigen::Matrix3d::Identity() + 2 * shear * strain;
}

TEST(SolidStress, ConstantStrainGivesHookesStressAtTheNodes) {
  const Eigen::Matrix3d stress = hooke(some_gradient());
  Vector6 exact;
  exact << stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(2, 0);
  for (ElementType type : kSolidTypes) {
    const fe::NodePositions nodes = single_element(type, 0.06);
    const Eigen::Matrix3Xd u = some_gradient() * nodes;
    const Eigen::VectorXd strain =
        fe::nodal_strain_operator(fe::solid_geometry(type, nodes), steel()) * Eigen::VectorXd(u.reshaped());
    for (Eigen::Index n = 0; n < nodes.cols(); ++n)
      EXPECT_LT((fe::elasticity(steel()) * strain.segment<6>(6 * n) - exact).norm(), 1e-12 * exact.norm())
          << type_name(type);
  }
}

/// At all nodes, of displacements of all dofs.
Stresses nodal_stresses(const fe::SolidMesh& mesh, const Eigen::VectorXd& u) {
  std::vector<fe::SurfacePoint> points;
  for (int n = 0; n < mesh.nodes.cols(); ++n) points.push_back({n, Eigen::Vector3d::Zero()});
  return fe::recover(mesh, points, fe::assemble(mesh).dofs, u).stress.reshaped(6, mesh.nodes.cols());
}

/// Saint-Venant's bending of a bar along x about z with curvature k: σxx = −E k y, all others zero.
Eigen::Vector3d bent(const Eigen::Vector3d& x, double k) {
  const double nu = steel().poisson;
  return k * Eigen::Vector3d(-x.x() * x.y(), 0.5 * (x.x() * x.x() + nu * (x.y() * x.y() - x.z() * x.z())),
                             nu * x.y() * x.z());
}

TEST(SolidStress, PureBendingIsExactForQuadraticElements) {
  constexpr double k = 1e-3;
  for (ElementType type : {ElementType::tet10, ElementType::hex20, ElementType::wedge15}) {
    const fe::SolidMesh mesh = block(type, {1, 0.4, 0.3}, {2, 1, 1}, steel());
    Eigen::VectorXd u(3 * mesh.nodes.cols());
    for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n) u.segment<3>(3 * n) = bent(mesh.nodes.col(n), k);
    const Stresses s = nodal_stresses(mesh, u);
    for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n) {
      Vector6 exact = Vector6::Zero();
      exact[0] = -steel().young * k * mesh.nodes(1, n);
      EXPECT_LT((s.col(n) - exact).norm(), 1e-11 * steel().young * k) << type_name(type);
    }
  }
}

TEST(SolidStress, BrickWithEightNodesBendsExactlyToo) {
  // The corners' displacements of pure bending; what bulges between them is left to the incompatible modes.
  constexpr double k = 1e-3;
  const Eigen::Vector3d size(0.5, 0.4, 0.3);
  const fe::SolidMesh mesh = block(ElementType::hex8, size, {1, 1, 1}, steel());
  Eigen::VectorXd u(24);
  for (Eigen::Index n = 0; n < 8; ++n) u.segment<3>(3 * n) = bent(mesh.nodes.col(n) - 0.5 * size, k);
  const Stresses s = nodal_stresses(mesh, u);
  for (Eigen::Index n = 0; n < 8; ++n) {
    Vector6 exact = Vector6::Zero();
    exact[0] = -steel().young * k * (mesh.nodes(1, n) - 0.5 * size.y());
    EXPECT_LT((s.col(n) - exact).norm(), 1e-11 * steel().young * k);
  }
}

TEST(GeometricStiffness, LinearFieldsHaveTheWorkOfTheStressOnTheirQuadraticStrain) {
  // vᵀ KG v = ∫ σ : (∇vᵀ ∇v) dV
  Eigen::Matrix3d V;
  V << 0.3, -1, 0.2, 0.8, 0.1, 0.5, -0.6, 0.4, -0.7;
  const Eigen::Matrix3d stress = hooke(some_gradient());
  for (ElementType type : kSolidTypes) {
    const fe::SolidMesh mesh = block(type, {1.1, 0.7, 0.5}, {2, 2, 1}, steel());
    const Eigen::Matrix3Xd displacement = some_gradient() * mesh.nodes;
    const Eigen::MatrixXd KG = full(fe::geometric_stiffness(mesh, displacement.reshaped()));
    const Eigen::Matrix3Xd field = (V * mesh.nodes).colwise() + Eigen::Vector3d(1, 2, 3);
    const Eigen::VectorXd v = field.reshaped();
    // ∇v here is V with rows of v: σij ∂k vk… = trace(V σ Vᵀ)
    const double exact = 1.1 * 0.7 * 0.5 * (V * stress * V.transpose()).trace();
    EXPECT_NEAR(v.dot(KG * v), exact, 1e-11 * std::abs(exact)) << type_name(type);
  }
}

/// Strain energy of Green–Lagrange strains with Hooke's law at the points of the stiffness.
double nonlinear_energy(ElementType type, const fe::NodePositions& nodes, const Eigen::VectorXd& u) {
  const fe::SolidGeometry geometry = fe::solid_geometry(type, nodes);
  const Eigen::Matrix3Xd displacement = Eigen::Matrix3Xd::Map(u.data(), 3, nodes.cols());
  double energy = 0;
  fe::ShapeGradients g;
  for (const fe::ShapeSample& sample : fe::stiffness_samples(type)) {
    const double dV = sample.weight * fe::body_gradients(geometry, sample, g);
    const Eigen::Matrix3d H = displacement * g.transpose();
    const Eigen::Matrix3d E = 0.5 * (H + H.transpose() + H.transpose() * H);
    energy += 0.5 * dV * hooke(E).cwiseProduct(E).sum();
  }
  return energy;
}

TEST(GeometricStiffness, IsThePartOfTheStrainEnergyThatStressAddsToRotations) {
  // For a rotation v, whose linear strain is zero: U(a u + b v) = … + ½ a b² vᵀ KG(u) v + terms of higher
  // order in a. The brick of eight nodes has its strains of incompatible modes beside.
  for (ElementType type : {ElementType::tet4, ElementType::tet10, ElementType::hex20, ElementType::wedge6,
                           ElementType::wedge15}) {
    const fe::NodePositions nodes = single_element(type, 0.05);
    std::mt19937 generator(3);
    Eigen::VectorXd u(3 * nodes.cols());
    for (double& x : u) x = generator() / 2147483648.0 - 1;
    const Eigen::VectorXd v =
        rigid_motions(nodes) * (Eigen::VectorXd(6) << 0, 0, 0, 0.4, -0.7, 0.5).finished();
    fe::NodalMatrix nodal;
    fe::solid_geometric_stiffness(fe::solid_geometry(type, nodes), steel(),
                                  fe::NodePositions::Map(u.data(), 3, nodes.cols()), nodal);
    const Eigen::Matrix3Xd V = Eigen::Matrix3Xd::Map(v.data(), 3, nodes.cols());
    const double ours = (V * nodal * V.transpose()).trace();
    // Odd in a, second difference in b.
    const auto energy = [&](double a, double b) { return nonlinear_energy(type, nodes, a * u + b * v); };
    constexpr double a = 1e-4, b = 1e-2;
    const auto bend = [&](double at) { return energy(at, b) - 2 * energy(at, 0) + energy(at, -b); };
    const double exact = (bend(a) - bend(-a)) / (2 * a * b * b);
    EXPECT_NEAR(ours / exact, 1, 1e-4) << type_name(type);
  }
}

/// Lowest load factor of K + λ KG with the root held.
double buckling_factor(const fe::SolidMesh& mesh, double compression) {
  const fe::FeMatrices matrices = fe::assemble(mesh);
  std::vector<int> free;
  for (int r = 0; r < static_cast<int>(matrices.dofs.size()); ++r)
    if (mesh.nodes(0, matrices.dofs[r].node) > 1e-9) free.push_back(r);
  // Uniform stress: the root would rather not bulge, and is far from mattering.
  Eigen::VectorXd u = Eigen::VectorXd::Zero(matrices.stiffness.rows());
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n)
    u.segment<3>(3 * n) =
        compression / steel().young *
        Eigen::Vector3d(-1, steel().poisson, steel().poisson).cwiseProduct(mesh.nodes.col(n));
  const Eigen::MatrixXd K = full(matrices.stiffness);
  const Eigen::MatrixXd KG = full(fe::geometric_stiffness(mesh, u));
  // −KG x = μ K x, λ = 1/μ
  return 1 / symmetric_eigenvalues(-KG(free, free), K(free, free)).maxCoeff();
}

TEST(GeometricStiffness, ColumnBucklesAtEulersLoad) {
  const Eigen::Vector3d size(1, 0.06, 0.04);
  const double area = size.y() * size.z();
  const double I = size.y() * std::pow(size.z(), 3) / 12;
  const double euler = std::numbers::pi * std::numbers::pi * steel().young * I / 4;
  for (ElementType type : {ElementType::hex8, ElementType::hex20, ElementType::tet10, ElementType::wedge15}) {
    const fe::SolidMesh mesh = block(type, size, {12, 1, 1}, steel());
    const double load = buckling_factor(mesh, 1e6) * 1e6 * area;
    EXPECT_NEAR(load / euler, 1, 0.02) << type_name(type);
  }
}

TEST(GeometricStiffness, RefusesShellsAndWrongSizes) {
  fe::SolidMesh mesh = block(ElementType::hex8, {1, 1, 1}, {1, 1, 1}, steel());
  EXPECT_THROW(fe::geometric_stiffness(mesh, Eigen::VectorXd::Zero(23)), std::invalid_argument);
  EXPECT_THROW(nodal_stresses(mesh, Eigen::VectorXd::Zero(25)), std::invalid_argument);
  mesh.groups.push_back({ElementType::quad4, "skin", 0, 0.01, {0, 1, 3, 2}, {}});
  EXPECT_THROW(fe::geometric_stiffness(mesh, Eigen::VectorXd::Zero(36)), std::invalid_argument);
}

}  // namespace
}  // namespace mimbre::test::solid_stress_test
