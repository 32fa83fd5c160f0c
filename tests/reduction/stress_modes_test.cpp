#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "fe/bar_ends.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"

/// Stress of reduced bodies.
namespace mimbre::test::stress_modes_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::Interface;

const fe::Material steel_bar{2.1e11, 0.3, 7850};
constexpr double length = 1, width = 0.1, height = 0.05;

ReducedBody reduced(const fe::SolidMesh& mesh, fe::ModelReduction::Basis basis, int modes) {
  fe::ModelReduction o;
  o.interfaces = {end(mesh, "root", 0), end(mesh, "tip", length)};
  o.basis = basis;
  o.dynamic_modes = modes;
  o.free_modes = 0;
  return fe::reduce(mesh, fe::assemble(mesh), o).body;
}

Index nearest(const ReducedBody& body, const Vector3d& at) {
  Index found = 0;
  (body.nodes.colwise() - at).colwise().squaredNorm().minCoeff(&found);
  return found;
}

/// Amplitudes under a force and a moment at the tip, the root clamped.
VectorXd under(const ReducedBody& body, const Vector3d& force, const Vector3d& moment) {
  const BodyFrame& tip = body.frames[1];
  return PivotedCholesky(body.stiffness).solve(tip.X.transpose() * force + tip.X_theta.transpose() * moment);
}

fe::SolidMesh shell_bar() {
  fe::SolidMesh mesh;
  constexpr int n = 20, m = 4;
  mesh.nodes.resize(3, (n + 1) * (m + 1));
  fe::ElementGroup group{fe::ElementType::quad4, "strip", 0, height, {}, {}};
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= n; ++i) {
      mesh.nodes.col(i + (n + 1) * j) << length * i / n, width * j / m, height / 2;
      if (i < n && j < m)
        for (const int k :
             {i + (n + 1) * j, i + 1 + (n + 1) * j, i + 1 + (n + 1) * (j + 1), i + (n + 1) * (j + 1)})
          group.nodes.push_back(k);
    }
  mesh.groups.push_back(group);
  mesh.materials = {{"steel", steel_bar}};
  return mesh;
}

TEST(StressModes, CantileverHasTheStressOfBeamTheoryInItsMiddle) {
  const double F = -1000, I = width * std::pow(height, 3) / 12;
  const double bending = -F * (length / 2) * (height / 2) / I;  // on top, pulled when the tip goes down
  using Basis = fe::ModelReduction::Basis;
  const auto solid = [](fe::ElementType type) {
    return block(type, {length, width, height}, {20, 2, 2}, steel_bar);
  };
  for (const fe::SolidMesh& mesh : {solid(fe::ElementType::hex20), solid(fe::ElementType::tet10),
                                    solid(fe::ElementType::hex8), shell_bar()})
    for (const Basis basis : {Basis::craig_bampton, Basis::krylov, Basis::free_interface}) {
      const ReducedBody body = reduced(mesh, basis, 4);
      ASSERT_EQ(body.stress.rows(), 6 * body.nodes.cols());
      const VectorXd y = under(body, {0, 0, F}, Vector3d::Zero());
      const Index top = nearest(body, {length / 2, width / 2, height}),
                  bottom = nearest(body, {length / 2, width / 2, 0});
      EXPECT_NEAR(body.stress.row(6 * top).dot(y), bending, 0.02 * bending);
      EXPECT_NEAR(body.stress.row(6 * bottom).dot(y), -bending, 0.02 * bending);
      EXPECT_NEAR(body.strain.row(6 * top).dot(y), bending / steel_bar.young,
                  0.03 * bending / steel_bar.young);
      // A pull: the same everywhere but near the ends.
      const VectorXd pulled = under(body, {F, 0, 0}, Vector3d::Zero());
      EXPECT_NEAR(body.stress.row(6 * top).dot(pulled), F / (width * height), 0.01 * -F / (width * height));
    }
}

TEST(StressModes, AreThoseOfTheFullModelUnderForcesAtTheInterfaces) {
  const fe::SolidMesh mesh = block(fe::ElementType::tet10, {length, width, height}, {6, 1, 1}, steel_bar);
  const fe::FeMatrices m = fe::assemble(mesh);
  // Both interfaces rigid: the tip's nodes follow its point, so its motion makes the full model's a problem
  // with given displacements.
  const ReducedBody body = reduced(mesh, fe::ModelReduction::Basis::craig_bampton, 2);
  const VectorXd y = under(body, {300, -200, 100}, {5, 20, -10});
  const Vector3d move = body.frames[1].X * y, turn = body.frames[1].X_theta * y;
  const Interface tip = end(mesh, "tip", length), root = end(mesh, "root", 0);
  const MatrixXd K = MatrixXd(m.stiffness).selfadjointView<Eigen::Lower>();
  VectorXd u = VectorXd::Zero(K.rows());
  std::vector<bool> given(static_cast<std::size_t>(K.rows()), false);
  for (const Interface* i : {&root, &tip})
    for (const int node : i->nodes)
      for (int d = 0; d < 3; ++d) {
        given[static_cast<std::size_t>(3 * node + d)] = true;
        if (i == &tip) u[3 * node + d] = (move + turn.cross(mesh.nodes.col(node) - i->point))[d];
      }
  std::vector<int> inner;
  for (int r = 0; r < K.rows(); ++r)
    if (!given[static_cast<std::size_t>(r)]) inner.push_back(r);
  const VectorXd load = K * u;
  u(inner) = -PivotedCholesky(K(inner, inner)).solve(load(inner));
  std::vector<fe::SurfacePoint> points;
  for (Index k = 0; k < body.nodes.cols(); ++k) {
    Index node = 0;
    (mesh.nodes.colwise() - body.nodes.col(k)).colwise().norm().minCoeff(&node);
    points.push_back({static_cast<int>(node), Vector3d::Zero()});
  }
  const fe::Recovery exact = fe::recover(mesh, points, m.dofs, u);
  EXPECT_LT((body.stress * y - exact.stress.col(0)).norm(), 1e-8 * exact.stress.norm());
  EXPECT_LT((body.strain * y - exact.strain.col(0)).norm(), 1e-8 * exact.strain.norm());
}

}  // namespace
}  // namespace mimbre::test::stress_modes_test
