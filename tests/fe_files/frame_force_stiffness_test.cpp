#include "fe_files/bodies/frame_force_stiffness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <random>

#include "fe/bar_ends.h"
#include "fe/solid_meshes.h"
#include "fe_files/bodies/sid_file.h"
#include "fe_files/fe_files.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"

/// Geometric stiffness of a steel bar along x in the exchange formats.
namespace mimbre::test::frame_force_stiffness_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::Folder;
using testing::IsEmpty;

const fe::Material steel{2.1e11, 0, 7850};  // without Poisson's ratio a clamped bar is a beam
constexpr double length = 1, width = 0.02;
constexpr double area = width * width, inertia = area * area / 12;

const ReducedBody& bar() {
  static const ReducedBody body = [] {
    const fe::SolidMesh mesh = block(fe::ElementType::hex20, {length, width, width}, {12, 1, 1}, steel);
    fe::ModelReduction o;
    o.interfaces = {end(mesh, "node 7", 0), end(mesh, "node 3", length)};
    o.dynamic_modes = 6;
    o.free_modes = 0;
    o.geometric_stiffness = true;
    return fe::reduce(mesh, fe::assemble(mesh), o).body;
  }();
  return body;
}

/// What acts on a body that is at rest in its frame.
struct Loads {
  Vector3d omega, acceleration, alpha, force, torque;  ///< the last two at the tip
};

Loads some_loads() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double size) {
    return Vector3d(size * uniform(random), size * uniform(random), size * uniform(random));
  };
  return {vector(100), vector(1000), vector(1000), vector(1e4), vector(1e3)};
}

double inertia_load(const Loads& s, int number) {
  const Vector3d& w = s.omega;
  const double values[] = {w.x() * w.x(),      w.y() * w.y(), w.z() * w.z(),      w.x() * w.y(),
                           w.y() * w.z(),      w.x() * w.z(), s.acceleration.x(), s.acceleration.y(),
                           s.acceleration.z(), s.alpha.x(),   s.alpha.y(),        s.alpha.z()};
  return values[number];
}

/// Forces on the modes, from −∫Xᵀ (a + α × r + ω × (ω × r)) dm and from the tip.
VectorXd modal_forces(const ReducedBody& body, const Loads& s) {
  const auto skew = [](const Vector3d& v) {
    return (Eigen::Matrix3d() << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0).finished();
  };
  const Eigen::Matrix3d turning = skew(s.alpha) + skew(s.omega) * skew(s.omega);
  VectorXd f = -body.S.transpose() * s.acceleration;
  for (int i = 0; i < 3; ++i) f -= body.S_position[static_cast<std::size_t>(i)].transpose() * turning.col(i);
  return f + body.frames[1].X.transpose() * s.force + body.frames[1].X_theta.transpose() * s.torque;
}

/// Σ s_l K_l of the body in its static deformation.
MatrixXd stiffening(const ReducedBody& body, const Loads& s) {
  const GeometricStiffness& g = *body.geometric;
  const VectorXd boundary = g.boundary_loads * PivotedCholesky(body.stiffness).solve(modal_forces(body, s));
  MatrixXd sum = MatrixXd::Zero(body.modes, body.modes);
  for (std::size_t l = 0; l < g.loads.size(); ++l) {
    const int row = g.loads[l] - GeometricStiffness::boundary;
    sum += (row < 0 ? inertia_load(s, g.loads[l]) : boundary[row]) * g.stiffness[l];
  }
  return sum;
}

TEST(FrameForceStiffness, IsThatOfTheBodyAtRestUnderItsLoads) {
  const ReducedBody& body = bar();
  ASSERT_GT(body.geometric->boundary_loads.rows(), 0);
  const fe::FrameForceStiffness by_forces = fe::by_frame_forces(body);
  const Loads s = some_loads();
  MatrixXd sum = MatrixXd::Zero(body.modes, body.modes);
  for (int l = 0; l < GeometricStiffness::boundary; ++l)
    if (const MatrixXd& K = by_forces.inertia[static_cast<std::size_t>(l)]; K.size() > 0)
      sum += inertia_load(s, l) * K;
  ASSERT_EQ(by_forces.forces.size(), 12u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(by_forces.forces[i].size(), 0);  // the root does not move
    if (const MatrixXd& K = by_forces.forces[6 + i]; K.size() > 0)
      sum += (i < 3 ? s.force[static_cast<Index>(i)] : s.torque[static_cast<Index>(i) - 3]) * K;
  }
  const MatrixXd expected = stiffening(body, s);
  EXPECT_LT((sum - expected).norm(), 1e-8 * expected.norm());
}

void expect_same_stiffening(const ReducedBody& read) {
  const ReducedBody& body = bar();
  ASSERT_TRUE(read.geometric.has_value());
  const GeometricStiffness &a = *body.geometric, &b = *read.geometric;
  ASSERT_EQ(b.loads.size(), a.loads.size());
  const double largest = b.boundary_loads.cwiseAbs().maxCoeff();
  EXPECT_LT((a.boundary_loads - b.boundary_loads).cwiseAbs().maxCoeff(), 1e-7 * largest);
  for (std::size_t l = 0; l < a.loads.size(); ++l) {
    EXPECT_EQ(b.loads[l], a.loads[l]);
    EXPECT_LT((a.stiffness[l] - b.stiffness[l]).norm(), 1e-7 * a.stiffness[l].norm()) << a.loads[l];
  }
  const Loads s = some_loads();
  EXPECT_LT((stiffening(body, s) - stiffening(read, s)).norm(), 1e-8 * stiffening(body, s).norm());
  EXPECT_THAT(check(read), IsEmpty());
}

TEST(FrameForceStiffness, IsTheSameInMbdynFem) {
  Folder folder;
  fe::write_mbdyn_fem(bar(), folder.path("a.fem"));
  const fe::ImportedBody read = fe::read_mbdyn_fem(folder.path("a.fem"));
  EXPECT_THAT(read.warnings, IsEmpty());
  expect_same_stiffening(read.body);
}

TEST(FrameForceStiffness, IsTheSameInSid) {
  Folder folder;
  fe::write_sid(bar(), folder.path("a.sid"));
  const fe::ImportedBody read = fe::read_sid(folder.path("a.sid"));
  EXPECT_THAT(read.warnings, IsEmpty());
  expect_same_stiffening(read.body);
}

/// A matrix of record group 19, found by its index.
MatrixXd stiffening_matrix(const std::string& path, int index, int modes) {
  std::ifstream stream(path);
  std::string line;
  while (std::getline(stream, line) && line.find("RECORD GROUP 19") == std::string::npos) {
  }
  int count = 0;
  stream >> count;
  for (int k = 0; k < count; ++k) {
    int here = 0;
    stream >> here;
    MatrixXd matrix(modes, modes);
    for (int i = 0; i < modes; ++i)
      for (int j = 0; j < modes; ++j) stream >> matrix(i, j);
    if (here == index) return matrix;
  }
  ADD_FAILURE() << "no index " << index;
  return MatrixXd::Zero(modes, modes);
}

/// Flapping of a cantilever that turns about z with its tip free, by the third matrix alone: μ = 3.5160,
/// 5.5850, 7.3604 at γ = 0, 4, 6 (A. D. Wright et al., J. Appl. Mech. 49 (1982) 197–202).
TEST(FrameForceStiffness, ATurningBarFlapsAsTheFemFileSays) {
  const ReducedBody& body = bar();
  Folder folder;
  fe::write_mbdyn_fem(body, folder.path("a.fem"));
  const MatrixXd K = stiffening_matrix(folder.path("a.fem"), 3, body.modes);
  const double unit = std::sqrt(steel.young * inertia / (steel.density * area)) / (length * length);
  for (const auto& [speed, frequency] : {std::pair{0.0, 3.5160}, {4.0, 5.5850}, {6.0, 7.3604}}) {
    const double omega = speed * unit;
    const VectorXd flap = symmetric_eigenvalues(body.stiffness + omega * omega * K, body.mass_matrix);
    EXPECT_NEAR(std::sqrt(flap[0]) / unit / frequency, 1, 0.01) << speed;
  }
}

/// An acceleration along the bar presses it together: what hangs buckles (Greenhill: q L³ = 7.837 EI).
TEST(FrameForceStiffness, AStandingBarBucklesUnderItsWeight) {
  const ReducedBody& body = bar();
  Folder folder;
  fe::write_mbdyn_fem(body, folder.path("a.fem"));
  const MatrixXd K = stiffening_matrix(folder.path("a.fem"), 10, body.modes);
  const VectorXd buckling = symmetric_eigenvalues(-K, body.stiffness);
  const double weight = steel.density * area / buckling.maxCoeff();
  EXPECT_NEAR(weight * std::pow(length, 3) / (7.837 * steel.young * inertia), 1, 0.02);
}

/// The linear part of the tip's phi: a force on it that buckles the bar, π² EI / 4 L².
TEST(FrameForceStiffness, AColumnBucklesAsTheSidFileSays) {
  const ReducedBody& body = bar();
  Folder folder;
  fe::write_sid(body, folder.path("a.sid"));
  fe::TextFile file(folder.path("a.sid"));
  const fe::SidFile sid = fe::parse_sid_file(file);
  ASSERT_EQ(sid.nodes[1].label, "3");
  const std::vector<MatrixXd> phi = fe::linear_parts(sid.nodes[1].blocks.at("phi"), sid);
  MatrixXd on_modes(body.modes, body.modes);  // force on the modes by amplitudes, of a unit force along x
  for (int m = 0; m < body.modes; ++m) on_modes.col(m) = phi[static_cast<std::size_t>(m)].row(0);
  // Pressed by P: K y = −P (phi1 y).
  const VectorXd buckling = symmetric_eigenvalues(-0.5 * (on_modes + on_modes.transpose()), body.stiffness);
  const double euler = std::numbers::pi * std::numbers::pi * steel.young * inertia / (4 * length * length);
  EXPECT_NEAR(1 / buckling.maxCoeff() / euler, 1, 0.02);
}

/// More forces than amplitudes: the body of a file may have many nodes. Here each of the tip's forces is
/// there twice, at two nodes that move as one, and both take half.
TEST(FrameForceStiffness, TakesForcesAtFramesThatDependOnEachOther) {
  ReducedBody body = bar();
  const Loads s = some_loads();
  const MatrixXd expected = stiffening(body, s);
  const fe::FrameForceStiffness once = fe::by_frame_forces(body);
  for (const int copies : {1, 5}) {
    fe::FrameForceStiffness given = once;
    for (int k = 0; k < copies; ++k) {
      body.frames.push_back(body.frames[1]);
      body.frames.back().name += "'" + std::to_string(k);
      if (body.stretching) body.stretching->place_of_frame.push_back(body.stretching->place_of_frame[1]);
      for (std::size_t i = 6; i < 12; ++i) given.forces.push_back(given.forces[i]);
    }
    EXPECT_EQ(fe::take_frame_forces(given, body), "");
    EXPECT_LE(body.geometric->boundary_loads.rows(), body.modes);
    EXPECT_THAT(check(body), IsEmpty());
    EXPECT_LT((stiffening(body, s) - expected).norm(), 1e-7 * expected.norm()) << copies;
    body = bar();
  }
}

TEST(FrameForceStiffness, NeedsAStiffnessForForcesByAmplitudes) {
  ReducedBody body = bar();
  Folder folder;
  fe::write_mbdyn_fem(body, folder.path("a.fem"));
  body.stiffness.setZero();
  EXPECT_THROW(fe::by_frame_forces(body), std::invalid_argument);
  EXPECT_THROW(fe::write_sid(body, folder.path("b.sid")), std::invalid_argument);
  fe::FrameForceStiffness given;
  given.forces.resize(12);
  given.forces[6] = MatrixXd::Identity(body.modes, body.modes);
  given.inertia[2] = MatrixXd::Identity(body.modes, body.modes);
  EXPECT_NE(fe::take_frame_forces(given, body), "");
  EXPECT_EQ(body.geometric->loads, std::vector<int>{2});
}

}  // namespace
}  // namespace mimbre::test::frame_force_stiffness_test
