#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <functional>
#include <random>

#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/reduced_body.h"
#include "reduction/bases/craig_bampton.h"

namespace mimbre::test::reduction_test {
namespace {

fe::BoundaryDof boundary(int node, const Eigen::Vector3d& direction, bool rotation = false,
                         const std::string& name = "") {
  return {node, rotation, direction, name};
}

/// Bent frame, clamped at one end: an oblique displacement and rotation of the far end, one displacement of
/// the knee, one dof each freed.
fe::ReductionOptions some_options(int dynamic_modes) {
  const Eigen::Matrix3d axes = some_rotation();
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary = {boundary(2, axes.col(0), false, "tip.a"), boundary(2, axes.col(2), false, "tip.c"),
                      boundary(2, axes.col(1), true, "tip.b"), boundary(1, {0, 0, 2}, false, "knee")};
  options.dynamic_modes = dynamic_modes;
  options.stiffness_damping = 0.01;
  return options;
}

std::vector<fe::NodeFrame> some_frames() {
  return {{"tip", 2, some_rotation()}, {"knee", 1, Eigen::Matrix3d::Identity()}};
}

Eigen::VectorXd random_vector(int size, int seed) {
  std::mt19937 generator(seed);
  Eigen::VectorXd v(size);
  for (double& x : v) x = generator() / 2147483648.0 - 1.0;
  return v;
}

/// Amplitudes y for user amplitudes u.
Eigen::VectorXd modal(const ReducedBody& body, const Eigen::VectorXd& user) {
  return mimbre::solve(body.user_from_modal, user);
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(CraigBampton, ReducedBodyIsSound) {
  const ReducedBody body = fe::reduce(bent_frame(), some_options(5), some_frames());
  EXPECT_THAT(check(body), testing::IsEmpty());
  EXPECT_EQ(body.modes, 9);
  EXPECT_THAT(body.mode_names,
              testing::ElementsAre("static tip.a", "static tip.c", "static tip.b", "static knee", "dynamic 1",
                                   "dynamic 2", "dynamic 3", "dynamic 4", "dynamic 5"));
  EXPECT_EQ(body.find_frame("knee"), 1);
  EXPECT_EQ(body.find_frame("elbow"), -1);
}

TEST(CraigBampton, WithAllDynamicModesHasTheFrequenciesOfTheFullModel) {
  const fe::Mesh mesh = bent_frame();
  const int dofs = 6 * static_cast<int>(mesh.nodes.cols() - 1);
  const ReducedBody body = fe::reduce(mesh, some_options(dofs - 4), {});
  const Eigen::VectorXd full = fe::eigenfrequencies(mesh, {0}, dofs);
  for (int k = 0; k < dofs; ++k) EXPECT_NEAR(body.eigenfrequencies[k] / full[k], 1, 1e-7);
}

TEST(CraigBampton, WithFewModesHasTheFirstFrequenciesSlightlyAboveTheFullModels) {
  const fe::Mesh mesh = bent_frame();
  const Eigen::VectorXd full = fe::eigenfrequencies(mesh, {0}, 6);
  Eigen::VectorXd previous = Eigen::VectorXd::Constant(3, 1e30);
  for (int dynamic : {4, 8, 16}) {
    const ReducedBody body = fe::reduce(mesh, some_options(dynamic), {});
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(body.eigenfrequencies[k], full[k] * (1 - 1e-9));
      EXPECT_LT(body.eigenfrequencies[k], full[k] * 1.01);
      EXPECT_LT(body.eigenfrequencies[k], previous[k] * (1 + 1e-9));
    }
    previous = body.eigenfrequencies.head(3);
  }
}

TEST(CraigBampton, StaticAmplitudesAreTheBoundarysDisplacements) {
  const fe::ReductionOptions options = some_options(5);
  const ReducedBody body = fe::reduce(bent_frame(), options, some_frames());
  const Eigen::VectorXd user = random_vector(body.modes, 1);
  const Eigen::VectorXd y = modal(body, user);
  const BodyFrame& tip = body.frames[0];
  const BodyFrame& knee = body.frames[1];
  EXPECT_NEAR(options.boundary[0].direction.dot(tip.X * y), user[0], 1e-9);
  EXPECT_NEAR(options.boundary[1].direction.dot(tip.X * y), user[1], 1e-9);
  EXPECT_NEAR(options.boundary[2].direction.dot(tip.X_theta * y), user[2], 1e-9);
  EXPECT_NEAR(knee.X.row(2).dot(y), user[3], 1e-9);
  EXPECT_LT((body.node_shapes.middleRows<3>(6) - tip.X).norm(), 1e-15);
  EXPECT_LT(body.node_shapes.topRows<3>().norm(), 1e-15);
}

TEST(CraigBampton, StaticModesNeedForcesAtTheBoundaryOnly) {
  const fe::Mesh mesh = bent_frame();
  const fe::ReductionOptions options = some_options(0);
  const fe::Matrices matrices = fe::assemble(mesh);
  const fe::Basis basis = fe::craig_bampton(mesh, matrices, options);
  Eigen::MatrixXd forces = matrices.stiffness * basis.shapes;
  forces.topRows<6>().setZero();  // the clamp
  const double scale = forces.cwiseAbs().maxCoeff();
  for (const fe::BoundaryDof& dof : options.boundary) {
    const Eigen::Vector3d n = dof.direction.normalized();
    auto rows = forces.middleRows<3>(6 * dof.node + (dof.rotation ? 3 : 0));
    rows = (rows - n * (n.transpose() * rows)).eval();  // what is left would act on freed dofs
  }
  EXPECT_LT(forces.cwiseAbs().maxCoeff(), 1e-9 * scale);
}

TEST(CraigBampton, ReducedCantileverHasTheClosedFormStiffnessOfItsTip) {
  const fe::Section s = rectangle(0.02, 0.03);
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary = {boundary(1, {0, 0, 1})};  // rotation free
  const ReducedBody body = fe::reduce(straight_beam(1.2, 100, s), options, {});
  const double user = body.user_from_modal(0, 0);
  const double exact = 3 * steel().young * s.Iy / std::pow(1.2, 3);
  EXPECT_NEAR(body.stiffness(0, 0) / (user * user) / exact, 1, 1e-6);
}

TEST(CraigBampton, TurningTheMeshTurnsTheResult) {
  const Eigen::Matrix3d R = some_rotation();
  const fe::ReductionOptions options = some_options(4);
  fe::ReductionOptions turned_options = options;
  for (auto& dof : turned_options.boundary) dof.direction = R * dof.direction;
  const ReducedBody body = fe::reduce(bent_frame(), options, some_frames());
  const ReducedBody turned =
      fe::reduce(moved(bent_frame(), R, Eigen::Vector3d::Zero()), turned_options, some_frames());
  const Eigen::VectorXd user =
      random_vector(body.modes, 3).cwiseProduct((Eigen::VectorXd(8) << 1, 1, 1, 1, 0, 0, 0, 0).finished());
  const Eigen::VectorXd y = modal(body, user);
  const Eigen::VectorXd yt = modal(turned, user);
  EXPECT_LT((body.eigenfrequencies - turned.eigenfrequencies).norm(), 1e-8 * body.eigenfrequencies.norm());
  EXPECT_LT((R * body.S * y - turned.S * yt).norm(), 1e-8 * (body.S * y).norm());
  EXPECT_LT((R * body.frames[0].X * y - turned.frames[0].X * yt).norm(), 1e-8);
  EXPECT_LT((R * body.second_moment * R.transpose() - turned.second_moment).norm(),
            1e-10 * body.second_moment.norm());
}

TEST(CraigBampton, SaysWhatIsWrong) {
  using testing::AllOf;
  using testing::HasSubstr;
  const fe::Mesh mesh = bent_frame();
  const auto error = [&](const std::function<void(fe::ReductionOptions&)>& change, const fe::Mesh& on) {
    fe::ReductionOptions options = some_options(2);
    change(options);
    return message_of([&] { fe::reduce(on, options, {}); });
  };
  EXPECT_THAT(error([](auto& o) { o.clamped_nodes.clear(); }, mesh), HasSubstr("no node is clamped"));
  EXPECT_THAT(error([](auto& o) { o.clamped_nodes = {99}; }, mesh),
              HasSubstr("clamped node 99 does not exist"));
  EXPECT_THAT(error(
                  [](auto& o) {
                    o.boundary.push_back(boundary(1, {1, 0, 1}, false, "other"));
                  },
                  mesh),
              AllOf(HasSubstr("'knee'"), HasSubstr("'other'"), HasSubstr("dependent")));
  EXPECT_THAT(error(
                  [](auto& o) {
                    o.boundary.push_back(boundary(0, {1, 0, 1}, false, "root"));
                  },
                  mesh),
              HasSubstr("'root': node 0 is clamped"));
  EXPECT_THAT(error([](auto& o) { o.boundary[3].direction.setZero(); }, mesh),
              HasSubstr("'knee': its direction has no length"));
  EXPECT_THAT(error([](auto& o) { o.dynamic_modes = 39; }, mesh),
              HasSubstr("39 dynamic modes asked of a mesh with 38"));
  EXPECT_THAT(error([](auto& o) { o.stiffness_damping = -1; }, mesh),
              HasSubstr("damping must not be negative"));
  fe::Mesh loose = mesh;
  loose.nodes.conservativeResize(3, mesh.nodes.cols() + 2);
  loose.nodes.rightCols<2>() << 5, 6, 0, 0, 0, 0;
  add_bar(loose, static_cast<int>(mesh.nodes.cols()), static_cast<int>(mesh.nodes.cols()) + 1, 2,
          round_bar(0.01));
  EXPECT_THAT(error([](auto&) {}, loose),
              HasSubstr("singular: the part of the mesh with node 8 is not held"));
  EXPECT_THAT(message_of([&] {
                fe::reduce(mesh, some_options(1), {{"far", 77, Eigen::Matrix3d::Identity()}});
              }),
              HasSubstr("frame 'far': node 77 does not exist"));
}

// ------------------------------------------------------------------------------------------- shape integrals

/// Mass, first and second moment of the deformed bars: cubic centre lines cut into many small lumps.
struct DeformedMoments {
  double mass = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d polar =
      Eigen::Matrix3d::Zero();  // what the sections' polar inertia adds to the second moment
};

DeformedMoments integrate_deformed(const fe::Mesh& mesh, const Eigen::VectorXd& dofs) {
  constexpr int kLumps = 2000;
  DeformedMoments sum;
  for (const fe::BeamElement& e : mesh.elements) {
    // Ends and slopes in body axes; the Hermite cubic of the transverse and the line of the axial
    // displacement.
    std::array<Eigen::Vector3d, 2> u;
    std::array<Eigen::Vector3d, 2> theta;
    std::array<Eigen::Vector3d, 2> r;
    for (int end = 0; end < 2; ++end) {
      theta[end] = dofs.segment<3>(6 * e.nodes[end] + 3);
      u[end] = dofs.segment<3>(6 * e.nodes[end]) + theta[end].cross(e.offsets[end]);
      r[end] = mesh.nodes.col(e.nodes[end]) + e.offsets[end];
    }
    const double L = (r[1] - r[0]).norm();
    const Eigen::Vector3d a = (r[1] - r[0]) / L;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - a * a.transpose();
    const double lump = e.material.density * e.section.area * L / kLumps;
    for (int k = 0; k < kLumps; ++k) {
      const double s = (k + 0.5) / kLumps;
      const Eigen::Vector3d transverse =
          across * ((1 - 3 * s * s + 2 * s * s * s) * u[0] + (3 * s * s - 2 * s * s * s) * u[1]) +
          L * (s - 2 * s * s + s * s * s) * theta[0].cross(a) + L * (s * s * s - s * s) * theta[1].cross(a);
      const Eigen::Vector3d x = r[0] + s * L * a + a * a.dot((1 - s) * u[0] + s * u[1]) + transverse;
      sum.mass += lump;
      sum.first += lump * x;
      sum.second += lump * x * x.transpose();
    }
    const double polar = e.material.density * (e.section.Iy + e.section.Iz) * L;
    sum.polar += polar * (0.5 * Eigen::Matrix3d::Identity() - a * a.transpose());
  }
  return sum;
}

TEST(ShapeIntegrals, GiveMassAndMomentsOfTheDeformedBars) {
  const fe::Mesh mesh = bent_frame();
  std::vector<fe::NodeFrame> every_node;
  for (int node = 0; node < mesh.nodes.cols(); ++node)
    every_node.push_back({std::to_string(node), node, Eigen::Matrix3d::Identity()});
  const ReducedBody body = fe::reduce(mesh, some_options(4), every_node);
  const Eigen::VectorXd y = 0.1 * modal(body, random_vector(body.modes, 2));
  Eigen::VectorXd dofs(6 * mesh.nodes.cols());
  for (int node = 0; node < mesh.nodes.cols(); ++node) {
    dofs.segment<3>(6 * node) = body.frames[node].X * y;
    dofs.segment<3>(6 * node + 3) = body.frames[node].X_theta * y;
  }
  const DeformedMoments expected = integrate_deformed(mesh, dofs);

  const Eigen::Vector3d first = body.first_moment + body.S * y;
  Eigen::Matrix3d second = body.second_moment;  // (3.27)
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      second(i, j) +=
          body.S_position[i].row(j).dot(y) + body.S_position[j].row(i).dot(y) + y.dot(body.S_modes[i][j] * y);
  EXPECT_NEAR(body.mass / expected.mass, 1, 1e-12);
  EXPECT_LT((first - expected.first).norm(), 1e-6 * expected.first.norm());
  EXPECT_LT((second - expected.polar - expected.second).norm(), 1e-6 * expected.second.norm());
}

TEST(ShapeIntegrals, AreTransposesOfEachOtherAndSumUpToTheMassMatrixButForThePolarInertia) {
  const fe::Mesh mesh = bent_frame();
  const ReducedBody body = fe::reduce(mesh, some_options(4), {});
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_EQ((body.S_modes[i][j] - body.S_modes[j][i].transpose()).norm(), 0);

  // What is missing is the sections' polar inertia, turning by the linearly interpolated twist.
  const fe::Basis basis = fe::craig_bampton(mesh, fe::assemble(mesh), some_options(4));
  const Eigen::MatrixXd shapes = basis.shapes * body.user_from_modal;
  Eigen::MatrixXd expected = body.S_modes[0][0] + body.S_modes[1][1] + body.S_modes[2][2];
  for (const fe::BeamElement& e : mesh.elements) {
    const Eigen::Vector3d axis =
        mesh.nodes.col(e.nodes[1]) + e.offsets[1] - mesh.nodes.col(e.nodes[0]) - e.offsets[0];
    const double polar = e.material.density * (e.section.Iy + e.section.Iz) * axis.norm();
    Eigen::MatrixXd twist(2, body.modes);
    for (int end = 0; end < 2; ++end)
      twist.row(end) = axis.normalized().transpose() * shapes.middleRows<3>(6 * e.nodes[end] + 3);
    expected += polar / 6 * twist.transpose() * (Eigen::Matrix2d() << 2, 1, 1, 2).finished() * twist;
  }
  EXPECT_LT((body.mass_matrix - expected).norm(), 1e-8);
}

TEST(ShapeIntegrals, GiveTheKineticEnergyOfTheFiniteElementModelForRigidMotionAndModesTogether) {
  const fe::Mesh mesh = bent_frame();
  const fe::Matrices matrices = fe::assemble(mesh);
  const ReducedBody body = fe::reduce(mesh, some_options(4), {});
  const fe::Basis basis = fe::craig_bampton(mesh, matrices, some_options(4));
  Eigen::MatrixXd all(basis.shapes.rows(), 6 + body.modes);
  all << rigid_motions(mesh), basis.shapes * body.user_from_modal;
  const Eigen::MatrixXd expected = all.transpose() * (matrices.mass * all);

  for (int seed = 0; seed < 3; ++seed) {
    const Eigen::VectorXd velocity = random_vector(6 + body.modes, seed);
    const Eigen::Vector3d v = velocity.head<3>();
    const Eigen::Vector3d w = velocity.segment<3>(3);
    const Eigen::VectorXd y = velocity.tail(body.modes);
    Eigen::Vector3d angular;  // ∫ r̄ × X ẏ dm
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3;
      const int j = (k + 2) % 3;
      angular[k] = (body.S_position[i].row(j) - body.S_position[j].row(i)).dot(y);
    }
    const double twice_energy = body.mass * v.squaredNorm() + 2 * v.dot(w.cross(body.first_moment)) +
                                body.second_moment.trace() * w.squaredNorm() - w.dot(body.second_moment * w) +
                                2 * v.dot(body.S * y) + 2 * w.dot(angular) + y.dot(body.mass_matrix * y);
    EXPECT_NEAR(twice_energy / velocity.dot(expected * velocity), 1, 1e-9);
  }
}

// --------------------------------------------------------------------------------------------
// make_orthogonal

TEST(MakeOrthogonal, ChangesCoordinatesAndNothingElse) {
  const ReducedBody orthogonal = fe::reduce(bent_frame(), some_options(4), some_frames());
  const int n = orthogonal.modes;

  // The same body in other, not orthogonal coordinates z, y = T z.
  const Eigen::MatrixXd T = random_vector(n * n, 5).reshaped(n, n);
  ReducedBody skew = orthogonal;
  for (Eigen::MatrixXd* m : {&skew.mass_matrix, &skew.stiffness, &skew.damping})
    *m = (T.transpose() * *m * T).eval();
  skew.S = orthogonal.S * T;
  skew.node_shapes = orthogonal.node_shapes * T;
  skew.mesh_inertia->shapes = orthogonal.mesh_inertia->shapes * T;
  skew.user_from_modal = orthogonal.user_from_modal * T;
  for (int i = 0; i < 3; ++i) {
    skew.S_position[i] = orthogonal.S_position[i] * T;
    for (int j = 0; j < 3; ++j) skew.S_modes[i][j] = T.transpose() * orthogonal.S_modes[i][j] * T;
  }
  for (int f = 0; f < 2; ++f) {
    skew.frames[f].X = orthogonal.frames[f].X * T;
    skew.frames[f].X_theta = orthogonal.frames[f].X_theta * T;
  }
  make_orthogonal(skew);

  EXPECT_THAT(check(skew), testing::IsEmpty());
  EXPECT_TRUE(skew.mass_matrix.isIdentity(0));
  EXPECT_LT((skew.eigenfrequencies - orthogonal.eigenfrequencies).norm(),
            1e-6 * orthogonal.eigenfrequencies.norm());
  for (int seed = 0; seed < 3; ++seed) {
    const Eigen::VectorXd user = random_vector(n, seed);
    const Eigen::VectorXd a = modal(orthogonal, user);
    const Eigen::VectorXd b = modal(skew, user);
    EXPECT_NEAR(b.squaredNorm() / a.squaredNorm(), 1, 1e-6);
    EXPECT_NEAR(b.dot(skew.stiffness * b) / a.dot(orthogonal.stiffness * a), 1, 1e-6);
    EXPECT_NEAR(b.dot(skew.damping * b) / a.dot(orthogonal.damping * a), 1, 1e-6);
    const auto same = [](const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
      EXPECT_LT((x - y).norm(), 1e-6 * (1e-3 + y.norm()));
    };
    same(skew.S * b, orthogonal.S * a);
    same(skew.node_shapes * b, orthogonal.node_shapes * a);
    same(skew.mesh_inertia->shapes * b, orthogonal.mesh_inertia->shapes * a);
    for (int i = 0; i < 3; ++i) {
      same(skew.S_position[i] * b, orthogonal.S_position[i] * a);
      for (int j = 0; j < 3; ++j)
        same(b.transpose() * skew.S_modes[i][j] * b, a.transpose() * orthogonal.S_modes[i][j] * a);
    }
    for (int f = 0; f < 2; ++f) {
      same(skew.frames[f].X * b, orthogonal.frames[f].X * a);
      same(skew.frames[f].X_theta * b, orthogonal.frames[f].X_theta * a);
    }
  }
}

TEST(MakeOrthogonal, RefusesDependentModes) {
  ReducedBody body = fe::reduce(bent_frame(), some_options(0), {});
  body.mass_matrix.setOnes();
  EXPECT_THAT(message_of([&] { make_orthogonal(body); }), testing::HasSubstr("not positive definite"));
}

// ------------------------------------------------------------------------------------------------------
// check

TEST(CheckReducedBody, NamesEveryViolation) {
  const ReducedBody sound = fe::reduce(bent_frame(), some_options(2), some_frames());
  const auto messages = [&](const std::function<void(ReducedBody&)>& change) {
    ReducedBody body = sound;
    change(body);
    return check(body);
  };
  using testing::Contains;
  using testing::HasSubstr;
  const double nan = std::nan("");
  EXPECT_THAT(messages([](auto& b) { b.S.resize(3, 2); }), Contains(HasSubstr("S must be 3 x 6, is 3 x 2")));
  EXPECT_THAT(messages([&](auto& b) { b.S_modes[1][2](0, 0) = nan; }),
              Contains("S_modes[1][2] must be finite"));
  EXPECT_THAT(messages([&](auto& b) { b.mass = nan; }), Contains("mass must be finite"));
  EXPECT_THAT(messages([](auto& b) { b.mass = -1; }), Contains(HasSubstr("mass must be positive")));
  EXPECT_THAT(messages([](auto& b) { b.stiffness(0, 1) += 1e6; }), Contains("stiffness must be symmetric"));
  EXPECT_THAT(messages([](auto& b) { b.S_modes[0][1](0, 1) += 1; }),
              Contains(HasSubstr("S_modes[1][0] must be the transpose")));
  EXPECT_THAT(messages([](auto& b) { b.mass_matrix(0, 0) = -1; }),
              Contains("mass_matrix must be positive definite"));
  EXPECT_THAT(messages([](auto& b) { b.stiffness(0, 0) *= -1; }),
              Contains("stiffness must not be indefinite"));
  EXPECT_THAT(messages([](auto& b) { b.S *= 10; }), Contains(HasSubstr("rigid motion and modes together")));
  EXPECT_THAT(messages([](auto& b) { b.second_moment(0, 0) *= 0.1; }),
              Contains(HasSubstr("triangle inequality")));
  EXPECT_THAT(messages([](auto& b) { b.frames[1].name = "tip"; }),
              Contains(HasSubstr("frame name 'tip' is used twice")));
  EXPECT_THAT(messages([](auto& b) { b.frames[0].rotation *= 2; }),
              Contains(HasSubstr("frame 'tip': rotation")));
  EXPECT_THAT(messages([](auto& b) { b.lines[0][1] = 100; }), Contains(HasSubstr("line end 100 is no node")));
  EXPECT_THAT(messages([](auto& b) {
                b.mass = std::nan("");
                b.mode_names.clear();
              }),
              testing::SizeIs(2));
}

}  // namespace
}  // namespace mimbre::test::reduction_test
