#include "reduction/bases/project_modes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>

#include "math/once/decompositions.h"
#include "support/brick_mesh.h"

/// Bodies on fewer modes than they had.
namespace mimbre::test::project_modes_test {
namespace {

using testing::HasSubstr;

/// A body with all that modes can have.
ReducedBody rich_body(Random& random, int modes) {
  ReducedBody b = random_brick_body(random, random_bricks(random, 2, 1, 1), modes);
  const auto matrix = [&](int rows) {
    MatrixXd m(rows, modes);
    for (int k = 0; k < modes; ++k) m.col(k) = random.values(rows, 1);
    return m;
  };
  b.frames[0].X = matrix(3);
  b.frames[0].X_theta = matrix(3);
  b.stress = matrix(6 * static_cast<int>(b.nodes.cols()));
  b.strain = matrix(6 * static_cast<int>(b.nodes.cols()));
  const MatrixXd root = matrix(modes);
  b.geometric = GeometricStiffness{{2}, {root + root.transpose()}, matrix(6)};
  MatrixXd form(modes + 3, modes + 3);
  for (int k = 0; k < modes + 3; ++k) form.col(k) = random.values(modes + 3, 1);
  b.stretching = Stretching{{form + form.transpose()}, MatrixXd::Zero(1, 6), MatrixXd::Zero(6, 6), {}};
  b.stretching->place_of_frame.assign(b.frames.size(), 0);
  return b;
}

TEST(ProjectModes, TheSameSpaceIsTheSameBody) {
  Random random(3);
  ReducedBody body = rich_body(random, 5);
  MatrixXd T(5, 5);
  for (int k = 0; k < 5; ++k) T.col(k) = random.values(5, 1);
  ReducedBody turned = project_modes(body, T);
  EXPECT_EQ(turned.mode_names[4], "combination 5");
  make_orthogonal(body);
  make_orthogonal(turned);
  EXPECT_TRUE(check(turned).empty());
  EXPECT_TRUE(turned.eigenfrequencies.isApprox(body.eigenfrequencies, 1e-9));
  // What does not depend on the choice of coordinates.
  const auto seen = [](const ReducedBody& b, const MatrixXd& rows) {
    return MatrixXd(rows * mimbre::inverse(b.stiffness) * rows.transpose());
  };
  const auto same = [&](const auto& rows) {
    EXPECT_TRUE(seen(turned, rows(turned)).isApprox(seen(body, rows(body)), 1e-9));
  };
  same([](const ReducedBody& b) -> MatrixXd { return b.frames[0].X; });
  same([](const ReducedBody& b) -> MatrixXd { return b.frames[0].X_theta; });
  same([](const ReducedBody& b) -> MatrixXd { return b.S; });
  same([](const ReducedBody& b) -> MatrixXd { return b.S_position[1]; });
  same([](const ReducedBody& b) -> MatrixXd { return b.node_shapes; });
  same([](const ReducedBody& b) -> MatrixXd { return b.stress; });
  same([](const ReducedBody& b) -> MatrixXd { return b.strain; });
  same([](const ReducedBody& b) -> MatrixXd { return b.mesh_inertia->shapes; });
  same([](const ReducedBody& b) -> MatrixXd { return b.geometric->boundary_loads; });
  same([](const ReducedBody& b) -> MatrixXd { return b.node_shapes * b.S_modes[0][1]; });
  same([](const ReducedBody& b) -> MatrixXd { return b.node_shapes * b.geometric->stiffness[0]; });
  same([](const ReducedBody& b) -> MatrixXd { return b.node_shapes * b.damping; });
  same([](const ReducedBody& b) -> MatrixXd {
    return b.node_shapes * b.stretching->forms[0].topLeftCorner(b.modes, b.modes);
  });
  same([](const ReducedBody& b) -> MatrixXd { return b.stretching->forms[0].bottomLeftCorner(3, b.modes); });
}

TEST(ProjectModes, OfAColumnOfTheUnitMatrixIsTheModeItself) {
  Random random(4);
  const ReducedBody body = rich_body(random, 4);
  MatrixXd T = MatrixXd::Zero(4, 2);
  T(1, 0) = T(3, 1) = 1;
  const ReducedBody some = project_modes(body, T);
  const std::vector<int> kept{1, 3};
  EXPECT_EQ(some.modes, 2);
  EXPECT_TRUE(check(some).empty());
  EXPECT_EQ(some.mass_matrix, MatrixXd(body.mass_matrix(kept, kept)));
  EXPECT_EQ(some.S_modes[2][0], MatrixXd(body.S_modes[2][0](kept, kept)));
  EXPECT_EQ(some.stress, MatrixXd(body.stress(Eigen::all, kept)));
  EXPECT_EQ(some.user_from_modal, MatrixXd::Identity(2, 2));
  EXPECT_EQ(some.mass, body.mass);
}

TEST(ProjectModes, WhatCannotBeIsRefused) {
  Random random(5);
  ReducedBody body = rich_body(random, 3);
  EXPECT_THROW(project_modes(body, MatrixXd::Identity(4, 2)), std::invalid_argument);
  EXPECT_THROW(project_modes(body, MatrixXd(3, 0)), std::invalid_argument);
  EXPECT_THROW(project_modes(body, MatrixXd::Ones(3, 2)), std::invalid_argument);
  EXPECT_THROW(project_modes(body, MatrixXd::Constant(3, 1, NAN)), std::invalid_argument);
  body.second_order.emplace();
  try {
    project_modes(body, MatrixXd::Identity(3, 2));
    ADD_FAILURE() << "a body of second order is projected";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("not linear"));
  }
}

}  // namespace
}  // namespace mimbre::test::project_modes_test
