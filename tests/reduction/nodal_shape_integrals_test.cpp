#include "reduction/nodal_shape_integrals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fe/meshes.h"
#include "support/brick_mesh.h"
#include "support/probe.h"

namespace mimbre::test::nodal_shape_integrals_test {
namespace {

TEST(NodalShapeIntegrals, AreTheQuadratureOfTheElements) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    Random random(seed);
    const BrickMesh mesh = random_bricks(random, 3, 2, 1);
    const ReducedBody expected = random_brick_body(random, mesh, 4);
    ReducedBody body;
    fe::add_shape_integrals(mesh.nodes, fe::nodal_mass(expected.mesh_inertia->mass), expected.node_shapes,
                            body);
    EXPECT_NEAR(body.mass / expected.mass, 1, 1e-13);
    EXPECT_LT(relative_difference(body.first_moment, expected.first_moment, 0), 1e-12);
    EXPECT_LT(relative_difference(body.second_moment, expected.second_moment, 0), 1e-12);
    EXPECT_LT(relative_difference(body.S, expected.S, 0), 1e-12);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LT(relative_difference(body.S_position[i], expected.S_position[i], 0), 1e-12);
      for (std::size_t j = 0; j < 3; ++j)
        EXPECT_LT(relative_difference(body.S_modes[i][j], expected.S_modes[i][j], 0), 1e-12);
    }
  }
}

TEST(NodalShapeIntegrals, RefuseMassThatDependsOnTheDirection) {
  Random random(1);
  const BrickMesh mesh = random_bricks(random, 1, 1, 1);
  Eigen::SparseMatrix<double> mass = translational_mass(nodal_mass(mesh));
  EXPECT_LT(relative_difference(MatrixXd(fe::nodal_mass(mass)), MatrixXd(nodal_mass(mesh)), 0), 1e-14);
  mass.coeffRef(3, 3) *= 1.01;
  EXPECT_THROW(fe::nodal_mass(mass), std::invalid_argument);
  mass.resize(7, 7);
  EXPECT_THROW(fe::nodal_mass(mass), std::invalid_argument);
  ReducedBody body;
  EXPECT_THROW(fe::add_shape_integrals(mesh.nodes, nodal_mass(mesh), MatrixXd::Zero(6, 2), body),
               std::invalid_argument);
}

TEST(MeshInertia, OfBeamsHasTheBodysMassAndModes) {
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary = {{2, false, Eigen::Vector3d::UnitZ(), "tip.z"}};
  options.dynamic_modes = 3;
  const fe::Mesh mesh = bent_frame();
  ReducedBody body = fe::reduce(mesh, options, {});
  ASSERT_TRUE(body.mesh_inertia);
  EXPECT_THAT(check(body), testing::IsEmpty());
  const MeshInertia& inertia = *body.mesh_inertia;
  EXPECT_EQ(inertia.dofs_per_node, 6);
  EXPECT_LT(relative_difference(inertia.shapes.transpose() * (inertia.mass * inertia.shapes),
                                MatrixXd::Identity(4, 4)),
            1e-10);
  for (int k = 0; k < body.nodes.cols(); ++k)
    EXPECT_LT((inertia.shapes.middleRows<3>(6 * k) - body.node_shapes.middleRows<3>(3 * k)).norm(), 1e-14);
  EXPECT_NEAR(inertia.nodal_mass.sum() / body.mass, 1, 1e-13);
}

TEST(MeshInertia, ThatIsUnsoundIsNamed) {
  Random random(2);
  const ReducedBody sound = random_brick_body(random, random_bricks(random, 1, 1, 1), 3);
  ASSERT_THAT(check(sound), testing::IsEmpty());
  const auto complaint = [&](auto&& spoil) {
    ReducedBody body = sound;
    spoil(*body.mesh_inertia);
    return testing::PrintToString(check(body));
  };
  using testing::HasSubstr;
  EXPECT_THAT(complaint([](MeshInertia& m) { m.dofs_per_node = 4; }),
              HasSubstr("dofs_per_node must be 3 or 6"));
  EXPECT_THAT(complaint([](MeshInertia& m) { m.mass.resize(5, 5); }), HasSubstr("mass must be 24 x 24"));
  EXPECT_THAT(complaint([](MeshInertia& m) { m.shapes.resize(3, 3); }), HasSubstr("shapes must be 24 x 3"));
  EXPECT_THAT(complaint([](MeshInertia& m) { m.mass.coeffRef(0, 3) *= 2; }),
              HasSubstr("mass must be symmetric"));
  EXPECT_THAT(complaint([](MeshInertia& m) { m.mass *= 1.01; }), HasSubstr("mass has a mass of"));
  EXPECT_THAT(complaint([](MeshInertia& m) { m.shapes *= 1.01; }), HasSubstr("do not give mass_matrix"));
  EXPECT_THAT(complaint([](MeshInertia& m) { m.mass.coeffRef(0, 0) = NAN; }), HasSubstr("must be finite"));
}

}  // namespace
}  // namespace mimbre::test::nodal_shape_integrals_test
