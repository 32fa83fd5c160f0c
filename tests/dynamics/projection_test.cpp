#include "dynamics/projection.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "dynamics/relative/residual.h"
#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"
#include "simulation/step/energy.h"
#include "support/brick_mesh.h"
#include "support/probe.h"

/// Inertia by projection of the mesh's mass matrix: the kernels against dense matrix products, shape
/// integrals against projection, and whole mechanisms.
namespace mimbre::test::projection_test {
namespace {

using Inertia = spec::Simulation::Inertia;
using projection::Base;
using projection::Constants;

/// M*, shapes and node positions as dense matrices, three or six dofs per node.
struct Dense {
  MatrixXd mass, shapes;
  Eigen::Matrix3Xd nodes;
  int width;

  Eigen::Matrix3Xd positions(const VectorXd& y) const {
    Eigen::Matrix3Xd r = nodes;
    for (int k = 0; k < r.cols(); ++k) r.col(k) += shapes.middleRows<3>(width * k) * y;
    return r;
  }
  /// B*: velocities of the dofs per base vector and modal rate.
  MatrixXd B(const VectorXd& y) const {
    const Eigen::Matrix3Xd r = positions(y);
    MatrixXd b = MatrixXd::Zero(shapes.rows(), 12 + shapes.cols());
    for (int k = 0; k < r.cols(); ++k) {
      b.block<3, 3>(width * k, 0).setIdentity();
      for (int i = 0; i < 3; ++i) {
        b.block<3, 3>(width * k, 3 + 3 * i) = r(i, k) * Mat3d::Identity();
        if (width == 6) b.block<3, 3>(6 * k + 3, 3 + 3 * i) = 0.5 * skew<double>(Vec3d::Unit(i));
      }
    }
    b.rightCols(shapes.cols()) = shapes;
    return b;
  }
  /// Inertia forces on the base vectors and modes; all blocks are multiples of the identity.
  VectorXd forces(const VectorXd& y, const VectorXd& x, const Mat3d& spin, const VectorXd& yd) const {
    const MatrixXd b = B(y);
    VectorXd v = shapes * yd, a = b * x;
    for (int k = 0; k < nodes.cols(); ++k) a.segment<3>(3 * k) += 2 * spin * v.segment<3>(3 * k);
    return b.transpose() * (mass * a);
  }
};

Dense dense(const ReducedBody& body) {
  return {MatrixXd(body.mesh_inertia->mass), body.mesh_inertia->shapes, body.nodes,
          body.mesh_inertia->dofs_per_node};
}

/// What projection_translations uses of beams.
Dense dense_translations(const ReducedBody& body) {
  const MatrixXd nodal(body.mesh_inertia->nodal_mass);
  MatrixXd mass = MatrixXd::Zero(3 * nodal.rows(), 3 * nodal.cols());
  for (int r = 0; r < nodal.rows(); ++r)
    for (int c = 0; c < nodal.cols(); ++c) mass.block<3, 3>(3 * r, 3 * c) = nodal(r, c) * Mat3d::Identity();
  return {mass, body.node_shapes, body.nodes, 3};
}

/// Anisotropic blocks without rotations: the tt part of a beam's M*.
ReducedBody with_translational_blocks(ReducedBody body) {
  body.mesh_inertia->nodal_mass.resize(0, 0);
  return body;
}
Dense dense_translational_blocks(const ReducedBody& body) {
  const Dense d = dense(body);
  const auto n = static_cast<Eigen::Index>(body.nodes.cols());
  MatrixXd mass(3 * n, 3 * n);
  for (Eigen::Index r = 0; r < n; ++r)
    for (Eigen::Index c = 0; c < n; ++c) mass.block<3, 3>(3 * r, 3 * c) = d.mass.block<3, 3>(6 * r, 6 * c);
  return {mass, body.node_shapes, body.nodes, 3};
}

VectorXd padded(const VectorXd& y, int stride) {
  VectorXd out = VectorXd::Zero(stride);
  out.head(y.size()) = y;
  return out;
}

struct Motion {
  VectorXd y, yd, ydd;  ///< padded
  Base b;
  Mat3d spin;
  Vec3d omega, alpha;
};

Motion random_motion(Random& random, int modes, double size) {
  const int s = pad(modes);
  Motion m;
  m.y = padded(random.values(modes, size), s);
  m.yd = padded(random.values(modes, 3 * size), s);
  m.ydd = padded(random.values(modes, 10 * size), s);
  for (Vec3d& b : m.b) b = random.vector(3);
  for (int k = 0; k < 3; ++k) m.spin.col(k) = random.vector(2);
  m.omega = random.vector(2);
  m.alpha = random.vector(4);
  return m;
}

VectorXd stacked(const Base& b) {
  VectorXd x(12);
  x << b[0], b[1], b[2], b[3];
  return x;
}

/// (12 + n) × (6 + n): base vectors of rigid motions.
MatrixXd rigid_motions(int n) {
  MatrixXd rigid = MatrixXd::Zero(12 + n, 6 + n);
  rigid.topLeftCorner<3, 3>().setIdentity();
  for (int i = 0; i < 3; ++i) rigid.block<3, 3>(3 + 3 * i, 3) = -skew<double>(Vec3d::Unit(i));
  rigid.bottomRightCorner(n, n).setIdentity();
  return rigid;
}

/// 12 × 12, each value of 4 × 4 times the identity.
MatrixXd spread(const Eigen::Matrix4d& mass) {
  MatrixXd out(12, 12);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) out.block<3, 3>(3 * i, 3 * j) = mass(i, j) * Mat3d::Identity();
  return out;
}

/// The mass matrix of relative coordinates and the kinetic energy of rigid motions against products of dense
/// matrices.
void expect_rigid(const Constants& c, const Dense& d, const VectorXd& y, Random& random) {
  projection::Work w;
  w.fit(c);
  const int n = c.modes, s = c.stride;
  const MatrixXd B = d.B(y.head(n)), projected = B.transpose() * d.mass * B, rigid = rigid_motions(n);
  const MatrixXd M = rigid.transpose() * projected * rigid;
  ASSERT_TRUE(c.plain);
  Vec3d first;
  Mat3d second;
  Rows::Values integrals(9, s);
  projection::rigid_mass(c, w, y.data(), first, second, integrals.data());
  MatrixXd assembled(6 + n, 6 + n);
  assembled.block<3, 3>(0, 0) = c.total_mass * Mat3d::Identity();
  assembled.block<3, 3>(0, 3) = -skew<double>(first);
  assembled.block<3, 3>(3, 3) = second.trace() * Mat3d::Identity() - second;
  assembled.block(0, 6, 3, n) = c.S.matrix().leftCols(n);
  for (int a = 0; a < 3; ++a) {
    const int i = (a + 1) % 3, j = (a + 2) % 3;
    assembled.block(3 + a, 6, 1, n) = (integrals.row(3 * i + j) - integrals.row(3 * j + i)).leftCols(n);
  }
  assembled.bottomRightCorner(n, n) = c.mass.matrix().topLeftCorner(n, n);
  assembled.triangularView<Eigen::StrictlyLower>() = assembled.transpose();
  EXPECT_LT(relative_difference(assembled, M, 0), 1e-12);

  // By way of natural coordinates.
  Rows::Values coupling(12, s);
  MatrixXd natural(12 + n, 12 + n);
  natural.topLeftCorner(12, 12) = spread(projection::base_mass(c, w, y.data(), coupling.data()));
  natural.topRightCorner(12, n) = coupling.leftCols(n);
  natural.bottomLeftCorner(n, 12) = coupling.leftCols(n).transpose();
  natural.bottomRightCorner(n, n) = c.mass.matrix().topLeftCorner(n, n);
  EXPECT_LT(relative_difference(rigid.transpose() * natural * rigid, M, 0), 1e-12);

  const Vec3d velocity = random.vector(3), omega = random.vector(2);
  const VectorXd yd = padded(random.values(n, 0.3), s);
  VectorXd x(6 + n), momenta(s);
  x << velocity, omega, yd.head(n);
  EXPECT_NEAR(projection::kinetic_energy(c, w, projection::rigid_base(velocity, omega), y.data(), yd.data(),
                                         momenta.data()) /
                  (0.5 * x.dot(M * x)),
              1, 1e-13);
}

/// All kernels, where all blocks are multiples of the identity.
void expect_dense(const Constants& c, const Dense& d, Random& random) {
  projection::Work w;
  w.fit(c);
  const int n = c.modes, s = c.stride;
  const Motion m = random_motion(random, n, 0.1);
  expect_rigid(c, d, m.y, random);
  const MatrixXd B = d.B(m.y.head(n)), projected = B.transpose() * d.mass * B;

  Rows::Values coupling(12, s);
  const MatrixXd mass = spread(projection::base_mass(c, w, m.y.data(), coupling.data()));
  EXPECT_LT(relative_difference(mass, projected.topLeftCorner<12, 12>(), 0), 1e-13);
  EXPECT_LT(relative_difference(coupling.leftCols(n), projected.topRightCorner(12, n), 0), 1e-13);
  EXPECT_TRUE(coupling.rightCols(s - n).isZero(0));
  EXPECT_LT(relative_difference(c.mass.matrix().topLeftCorner(n, n), projected.bottomRightCorner(n, n), 0),
            1e-13);

  VectorXd x(12 + n);
  x << stacked(m.b), m.ydd.head(n);
  const VectorXd expected = d.forces(m.y.head(n), x, m.spin, m.yd.head(n));
  Base forces;
  VectorXd elastic = VectorXd::Constant(s, 0.25);
  projection::inertia_forces(c, w, m.b, m.spin, m.y.data(), m.yd.data(), m.ydd.data(), forces,
                             elastic.data());
  EXPECT_LT(relative_difference(stacked(forces), expected.head<12>(), 0), 1e-13);
  EXPECT_LT(relative_difference(elastic.head(n), expected.tail(n) + VectorXd::Constant(n, 0.25), 0), 1e-13);
  EXPECT_TRUE((elastic.tail(s - n).array() == 0.25).all());

  x.tail(n) = m.yd.head(n);
  VectorXd momenta(s);
  EXPECT_NEAR(projection::kinetic_energy(c, w, m.b, m.y.data(), m.yd.data(), momenta.data()) /
                  (0.5 * x.dot(projected * x)),
              1, 1e-13);

  // Relative coordinates: base vectors of a rigid motion.
  const Mat3d spin = skew<double>(m.omega), field = skew<double>(m.alpha) + spin * spin;
  x << m.b[0], field.col(0), field.col(1), field.col(2), m.ydd.head(n);
  const VectorXd wrench = rigid_motions(n).transpose() * d.forces(m.y.head(n), x, spin, m.yd.head(n));
  elastic.setZero();
  const projection::Wrench got = projection::inertia_wrench(c, w, m.b[0], m.omega, m.alpha, m.y.data(),
                                                            m.yd.data(), m.ydd.data(), elastic.data());
  VectorXd all(6 + n);
  all << got.force, got.moment, elastic.head(n);
  EXPECT_LT(relative_difference(all, wrench, 0), 1e-12);
}

TEST(Projection, IsTheProductOfMatrices) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed + 40);
    const ReducedBody beams = *random_flexible_body(static_cast<int>(seed));
    expect_dense(projection::constants(beams, false), dense_translations(beams), random);
    // Where blocks depend on the direction or nodes turn: the undeformed body.
    const VectorXd undeformed = VectorXd::Zero(pad(beams.modes));
    expect_rigid(projection::constants(beams, true), dense(beams), undeformed, random);
    const ReducedBody blocks = with_translational_blocks(beams);
    expect_rigid(projection::constants(blocks, false), dense_translational_blocks(blocks), undeformed,
                 random);
    const ReducedBody bricks = random_brick_body(random, random_bricks(random, 2, 1, 1), 3 + 3 * (seed % 4));
    expect_dense(projection::constants(bricks, true), dense(bricks), random);
  }
}

/// Isoparametric elements: projection and shape integrals are the same integrals.
class Bricks : public testing::TestWithParam<unsigned> {
 protected:
  Random random{GetParam() + 900};
  BrickMesh mesh = random_bricks(random, 2, 2, 1);
  ReducedBody body = random_brick_body(random, mesh, 2 + static_cast<int>(GetParam() * 3 % 11));
  std::shared_ptr<const Model> model = floating_model(body);
  const FlexibleData& f = model->compiled().flexible[0];
  const BodyData& data = model->compiled().bodies[0];
  Constants c = projection::constants(body, true);
  int n = body.modes, s = f.stride;
  Motion m = random_motion(random, n, 0.2);
  Rows::Values integrals{9, s};

  void SetUp() override {
    ASSERT_EQ(check(body), std::vector<std::string>());
    deformed_integrals<double>(f, m.y.data(), integrals.data());
  }
};

TEST_P(Bricks, RelativeInertiaByIntegralsIsThatByProjection) {
  projection::Work w;
  w.fit(c);
  VectorXd by_integrals = VectorXd::Zero(s), by_projection = by_integrals;
  const auto a = relative::flexible_inertia<double>(data, f, inertia_rows(data, f, integrals.data()),
                                                    m.y.data(), m.yd.data(), m.ydd.data(), m.b[0], m.omega,
                                                    m.alpha, by_integrals.data());
  const auto b = projection::inertia_wrench(c, w, m.b[0], m.omega, m.alpha, m.y.data(), m.yd.data(),
                                            m.ydd.data(), by_projection.data());
  add_elasticity<double>(f, m.y.data(), m.yd.data(), by_projection.data());
  EXPECT_LT(relative_difference(b.force, a.force, 0), 1e-12);
  EXPECT_LT(relative_difference(b.moment, a.moment, 0), 1e-12);
  EXPECT_LT(relative_difference(by_projection, by_integrals, 0), 1e-12);

  Vec3d first;
  Mat3d second;
  Rows::Values rows(9, s);
  projection::rigid_mass(c, w, m.y.data(), first, second, rows.data());
  EXPECT_LT(relative_difference(first, data.first_moment + times(f.S, m.y.data()), 0), 1e-12);
  EXPECT_LT(
      relative_difference(
          second,
          deformed_second_moment<double>(data, f, inertia_rows(data, f, integrals.data()), m.y.data()), 0),
      1e-12);
  EXPECT_LT(relative_difference(rows, integrals, 0), 1e-12);
  EXPECT_LT(relative_difference(c.S.matrix(), f.S.matrix(), 0), 1e-12);
  EXPECT_LT(relative_difference(c.mass.matrix(), f.mass.matrix(), 0), 1e-12);
  EXPECT_NEAR(c.total_mass / body.mass, 1, 1e-13);
}

/// Lugrís 2008, 3.13–3.47, with accelerations of the base vectors and any AᵀȦ.
TEST_P(Bricks, NaturalInertiaByIntegralsIsThatByProjection) {
  projection::Work w;
  w.fit(c);
  const Vec3d first = data.first_moment + times(f.S, m.y.data());
  const Mat3d second =
      deformed_second_moment<double>(data, f, inertia_rows(data, f, integrals.data()), m.y.data());
  const auto S = [&](int i) { return integrals.middleRows<3>(3 * i).leftCols(n); };
  const MatrixXd S0 = f.S.matrix().leftCols(n);

  MatrixXd expected(12, 12);
  Rows::Values coupling(12, s);
  const MatrixXd mass = spread(projection::base_mass(c, w, m.y.data(), coupling.data()));
  expected.topLeftCorner<3, 3>() = body.mass * Mat3d::Identity();
  for (int i = 0; i < 3; ++i) {
    expected.block<3, 3>(0, 3 + 3 * i) = expected.block<3, 3>(3 + 3 * i, 0) = first[i] * Mat3d::Identity();
    for (int j = 0; j < 3; ++j) expected.block<3, 3>(3 + 3 * i, 3 + 3 * j) = second(i, j) * Mat3d::Identity();
    EXPECT_LT(relative_difference(coupling.middleRows<3>(3 + 3 * i).leftCols(n), S(i), 0), 1e-12);
  }
  EXPECT_LT(relative_difference(mass, expected, 0), 1e-12);
  EXPECT_LT(relative_difference(coupling.topRows<3>().leftCols(n), S0, 0), 1e-12);

  const VectorXd yd = m.yd.head(n), ydd = m.ydd.head(n);
  Base forces;
  forces[0] = body.mass * m.b[0] + S0 * ydd + 2 * m.spin * S0 * yd;
  VectorXd elastic = S0.transpose() * m.b[0] + body.mass_matrix * ydd;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    forces[0] += first[i] * m.b[k + 1];
    forces[k + 1] = first[i] * m.b[0] + S(i) * ydd + 2 * m.spin * S(i) * yd;
    elastic += S(i).transpose() * m.b[k + 1];
    for (std::size_t j = 0; j < 3; ++j) {
      forces[k + 1] += second(i, static_cast<int>(j)) * m.b[j + 1];
      elastic += 2 * m.spin(i, static_cast<int>(j)) * body.S_modes[k][j] * yd;
    }
  }
  Base got;
  VectorXd got_elastic = VectorXd::Zero(s);
  projection::inertia_forces(c, w, m.b, m.spin, m.y.data(), m.yd.data(), m.ydd.data(), got,
                             got_elastic.data());
  EXPECT_LT(relative_difference(stacked(got), stacked(forces), 0), 1e-12);
  EXPECT_LT(relative_difference(got_elastic.head(n), elastic, 0), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Random, Bricks, testing::Range(0u, 8u));

/// A cantilever frame, deformed and moving: how far integrals and projection are apart.
struct Differences {
  double inertia, coupling, force, moment, elastic;
};
Differences beam_differences(int elements, double section_size, bool rotations) {
  fe::Mesh mesh = with_nodes({Vec3d(0.1, 0.05, -0.1), Vec3d(0.9, 0.2, 0.1), Vec3d(0.8, 0.8, 0.4)});
  const double h = 0.03 * section_size;
  add_bar(mesh, 0, 1, elements, rectangle(2 * h, h), {0.1, 0.3, 1});
  add_bar(mesh, 1, 2, elements, rectangle(1.5 * h, h), {0.1, 0.3, 1});
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  for (int k = 0; k < 3; ++k) {
    options.boundary.push_back({2, false, Vec3d::Unit(k), "move"});
    options.boundary.push_back({2, true, Vec3d::Unit(k), "turn"});
  }
  const ReducedBody body = fe::reduce(mesh, options, {});
  const auto model = floating_model([&] {
    ReducedBody b = body;
    BodyFrame frame;
    frame.X.setZero(3, b.modes);
    frame.X_theta.setZero(3, b.modes);
    b.frames.push_back(frame);
    return b;
  }());
  const FlexibleData& f = model->compiled().flexible[0];
  const BodyData& data = model->compiled().bodies[0];
  const int s = f.stride;
  Random random(7);
  Motion m = random_motion(random, body.modes, 0.1);
  // The same physical motion on every mesh.
  const auto modal = [&](VectorXd& y) {
    y.head(body.modes) = mimbre::solve(body.user_from_modal, y.head(body.modes));
  };
  modal(m.y);
  modal(m.yd);
  modal(m.ydd);
  Rows::Values integrals(9, s), rows(9, s);
  deformed_integrals<double>(f, m.y.data(), integrals.data());
  const Constants c = projection::constants(body, rotations);
  projection::Work w;
  w.fit(c);
  Vec3d first;
  Mat3d second;
  projection::rigid_mass(c, w, m.y.data(), first, second, rows.data());
  VectorXd e = VectorXd::Zero(s), p = e;
  const auto a =
      relative::flexible_inertia<double>(data, f, inertia_rows(data, f, integrals.data()), m.y.data(),
                                         m.yd.data(), m.ydd.data(), m.b[0], m.omega, m.alpha, e.data());
  const auto b = projection::inertia_wrench(c, w, m.b[0], m.omega, m.alpha, m.y.data(), m.yd.data(),
                                            m.ydd.data(), p.data());
  VectorXd elasticity = VectorXd::Zero(s);
  add_elasticity<double>(f, m.y.data(), m.yd.data(), elasticity.data());
  e -= elasticity;
  const Mat3d by_integrals =
      deformed_second_moment<double>(data, f, inertia_rows(data, f, integrals.data()), m.y.data());
  const auto user = [&](const VectorXd& x) {  // generalised forces of the user's amplitudes
    return VectorXd(mimbre::solve(body.user_from_modal.transpose(), x.head(body.modes)));
  };
  return {relative_difference(second, by_integrals, 0), relative_difference(rows, integrals, 0),
          relative_difference(b.force, a.force, 0), relative_difference(b.moment, a.moment, 0),
          relative_difference(user(p), user(e), 0)};
}

TEST(Projection, OfBeamsConvergesToTheIntegralsWithTheSquareOfTheElementLength) {
  for (const bool rotations : {true, false}) {
    SCOPED_TRACE(rotations);
    // Translations have no polar inertia of the sections: thin bars.
    const double size = rotations ? 1 : 1e-3;
    const Differences coarse = beam_differences(16, size, rotations),
                      fine = beam_differences(32, size, rotations);
    EXPECT_LT(fine.inertia, 1e-4);
    EXPECT_LT(fine.coupling, 5e-3);
    EXPECT_LT(fine.force, rotations ? 1e-13 : 5e-5);  // with them S is that of the integrals
    EXPECT_LT(fine.moment, 5e-5);
    EXPECT_LT(fine.elastic, 5e-5);
    for (const auto member :
         {&Differences::inertia, &Differences::coupling, &Differences::moment, &Differences::elastic})
      EXPECT_NEAR(std::log2(coarse.*member / fine.*member), 2, 0.05);
    if (!rotations) {
      EXPECT_NEAR(std::log2(coarse.force / fine.force), 2, 0.05);
    }
  }
}

/// Whole mechanisms.
class ProjectedSystem : public testing::TestWithParam<unsigned> {
 protected:
  unsigned seed() const { return GetParam(); }
  Random random{GetParam() + 700};
  RandomMechanism mechanism(RandomOptions options = {}) {
    options.bodies = 2 + static_cast<int>(seed() % 5);
    options.flexible_share = 0.5 + 0.25 * (seed() % 3);
    return random_mechanism(seed(), options);
  }
};

TEST_P(ProjectedSystem, MassMatrixIsThatOfTheResidualAndOfTheEnergy) {
  const RandomMechanism r = mechanism();
  for (const Inertia inertia : {Inertia::projection, Inertia::projection_translations}) {
    Probe p(r.compiled(), inertia);
    p.system.begin_step(r.q.data());
    const VectorXd v = random_increment(p.m, random, 2);
    const VectorXd without = p.residual(r.q, v, p.zero);
    MatrixXd from_residual(p.n, p.n);
    for (int k = 0; k < p.n; ++k) from_residual.col(k) = p.residual(r.q, v, p.unit(k)) - without;
    const MatrixXd assembled = p.matrix(r.q, v, {0, 0, 0});
    EXPECT_LT(relative_difference(assembled, from_residual), 1e-10);
    p.kinematics(r.q, v, p.zero);
    const double energy = kinetic_energy(p.m, p.system.workspace(), r.q.data(), v.data());
    EXPECT_NEAR(energy, 0.5 * v.dot(assembled * v), 1e-12 * std::max(1.0, energy));
    // Near the integrals, whose mesh here is a coarse one, and not the same.
    Probe by_integrals(r.compiled());
    const double difference = relative_difference(assembled, by_integrals.matrix(r.q, v, {0, 0, 0}));
    EXPECT_LT(difference, 0.5);
  }
}

/// d/dt ∂T/∂v − ∂T/∂z of the kinetic energy (see the test of the same name for shape integrals).
class LagrangeOfProjection : public testing::TestWithParam<std::tuple<unsigned, Inertia>> {};

TEST_P(LagrangeOfProjection, InertiaForcesAreLagranges) {
  const auto [seed, kind] = GetParam();
  Random random{seed + 700};
  RandomOptions options;
  options.gravity = false;
  options.bodies = 2 + static_cast<int>(seed % 5);
  options.flexible_share = 0.5 + 0.25 * (seed % 3);
  const RandomMechanism r = random_mechanism(seed, options);
  Probe p(r.compiled(), kind);
  const VectorXd v = random_increment(p.m, random, 2), a = random_increment(p.m, random, 3);
  const VectorXd inertia = p.residual(r.q, v, a) - p.residual(r.q, p.zero, p.zero);
  const auto kinetic = [&](const VectorXd& q, const VectorXd& u) {
    p.kinematics(q, u, p.zero);
    return kinetic_energy(p.m, p.system.workspace(), q.data(), u.data());
  };
  const auto momentum = [&](const VectorXd& q, const VectorXd& u) {
    VectorXd out(p.n);
    for (int k = 0; k < p.n; ++k) out[k] = 0.5 * (kinetic(q, u + p.unit(k)) - kinetic(q, u - p.unit(k)));
    return out;
  };
  VectorXd lagrange =
      p.rate(r.q, v, a, [&](const VectorXd& q, const VectorXd& u, double) { return momentum(q, u); });
  lagrange -= p.gradient(
                   r.q, [&](const VectorXd& q) { return VectorXd::Constant(1, kinetic(q, v)); }, 1e-4)
                  .transpose();
  const VectorXd at = momentum(r.q, v);
  for (const BodyData& b : p.m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    if (info.quaternion < 0) continue;
    const int k = b.v + info.rotation;
    lagrange.segment<3>(k) += Vec3d(v.segment<3>(k)).cross(Vec3d(at.segment<3>(k)));
  }
  EXPECT_LT(relative_difference(inertia, lagrange), 2e-8);
}

INSTANTIATE_TEST_SUITE_P(Random, LagrangeOfProjection,
                         testing::Combine(testing::Range(0u, 18u),
                                          testing::Values(Inertia::projection,
                                                          Inertia::projection_translations)));

INSTANTIATE_TEST_SUITE_P(Random, ProjectedSystem, testing::Range(0u, 18u));

TEST(Projection, WithoutAMeshIsRefused) {
  Random random(3);
  ReducedBody body = random_brick_body(random, random_bricks(random, 1, 1, 1), 3);
  body.mesh_inertia.reset();
  const auto model = floating_model(body);
  EXPECT_NO_THROW(relative::RelativeSystem(model->compiled()));
  try {
    relative::RelativeSystem system(model->compiled(), Inertia::projection);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("flexible body 'body'"), std::string::npos) << error.what();
  }
}

TEST(Projection, OfMassThatDependsOnTheDirectionIsRefused) {
  Random random(3);
  ReducedBody body = random_brick_body(random, random_bricks(random, 1, 1, 1), 3);
  body.mesh_inertia->mass.coeffRef(0, 0) *= 1.1;
  const auto model = floating_model(body);
  EXPECT_THROW(relative::RelativeSystem(model->compiled(), Inertia::projection), InputError);
}

}  // namespace
}  // namespace mimbre::test::projection_test
