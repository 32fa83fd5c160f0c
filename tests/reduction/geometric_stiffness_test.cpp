#include "reduction/stiffening/geometric_stiffness.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "fe/elements/beam_element.h"
#include "fe/meshes.h"
#include "math/gauss.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"

namespace mimbre::geometric_stiffness_test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Loads = GeometricStiffness;

constexpr double length = 2.5, width = 0.05, height = 0.03;

double soft_stiffness() { return test::steel().young * width * height * height * height / 12; }
double mass_per_length() { return test::steel().density * width * height; }

struct Cantilever {
  Matrix3d axes = rotation_exp<double>(Vector3d(0.7, -1.1, 0.4));
  Vector3d root{0.3, -0.2, 0.5};
  bool axial = false;      ///< a static mode along the beam at its tip
  bool pinned = false;     ///< the tip moves along the beam only
  double breadth = width;  ///< of the section, along the stiffer direction y
  int modes = 8;

  ReducedBody reduce() const {
    fe::Mesh mesh = test::with_nodes({root, root + length * axes.col(0)});
    test::add_bar(mesh, 0, 1, 8, test::rectangle(breadth, height), axes.col(1));
    fe::ReductionOptions options;
    options.clamped_nodes = {0};
    if (axial) options.boundary.push_back({1, false, axes.col(0), "along"});
    if (pinned) options.fixed_dofs = {7, 8};
    options.dynamic_modes = modes;
    options.stiffening = fe::Stiffening::geometric_stiffness;
    return fe::reduce(mesh, options, {{"tip", 1, Matrix3d::Identity()}});
  }
};

/// The matrix of a load; zero where it stiffens nothing.
MatrixXd matrix_of(const ReducedBody& body, int load) {
  for (std::size_t k = 0; k < body.geometric->loads.size(); ++k)
    if (body.geometric->loads[k] == load) return body.geometric->stiffness[k];
  return MatrixXd::Zero(body.modes, body.modes);
}

/// The least positive p at which K − p G is singular.
double critical_load(const MatrixXd& K, const MatrixXd& G) {
  return 1 / symmetric_eigenvalues(G, K).maxCoeff();
}

/// Coefficients of the products of components of ω, in the order of the loads.
VectorXd products(const Vector3d& w) {
  VectorXd p(6);
  p << w.x() * w.x(), w.y() * w.y(), w.z() * w.z(), w.x() * w.y(), w.y() * w.z(), w.x() * w.z();
  return p;
}

MatrixXd rotating(const ReducedBody& body, const Vector3d& omega) {
  const VectorXd p = products(omega);
  MatrixXd sum = MatrixXd::Zero(body.modes, body.modes);
  for (int k = 0; k < 6; ++k) sum += p[k] * matrix_of(body, Loads::angular_velocity + k);
  return sum;
}

MatrixXd accelerated(const ReducedBody& body, const Vector3d& a) {
  MatrixXd sum = MatrixXd::Zero(body.modes, body.modes);
  for (int k = 0; k < 3; ++k) sum += a[k] * matrix_of(body, Loads::acceleration + k);
  return sum;
}

// N/(30 L) [36, 3L, −36, 3L; 4L², −3L, −L²; …] for a constant force.
TEST(ElementGeometricStiffness, IsThatOfATie) {
  const double L = 1.7, N = 12;
  Eigen::Matrix4d expected;
  expected << 36, 3 * L, -36, 3 * L,     //
      3 * L, 4 * L * L, -3 * L, -L * L,  //
      -36, -3 * L, 36, -3 * L,           //
      3 * L, -L * L, -3 * L, 4 * L * L;
  expected *= N / (30 * L);
  const fe::Matrix12 k = fe::element_geometric_stiffness({.axial = {N}}, L);
  const std::array xy{1, 5, 7, 11}, xz{2, 4, 8, 10};
  const std::array<double, 4> sign{1, -1, 1, -1};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const Eigen::Index a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      EXPECT_NEAR(k(xy[i], xy[j]), expected(a, b), 1e-12);
      EXPECT_NEAR(k(xz[i], xz[j]), sign[i] * sign[j] * expected(a, b), 1e-12);
    }
  EXPECT_NEAR(k.cwiseAbs().sum(), 2 * expected.cwiseAbs().sum(), 1e-10);
}

// ∫ N w'² ds for the rigid turn w = θ s is θ² ∫ N ds.
TEST(ElementGeometricStiffness, TakesForcesThatVaryAlongIt) {
  const double L = 0.8;
  fe::Matrix12 k = fe::element_geometric_stiffness({.axial = {2, -3, 5}}, L);
  Eigen::Matrix<double, 12, 1> turn = Eigen::Matrix<double, 12, 1>::Zero();
  turn[5] = turn[11] = 1;
  turn[7] = L;
  EXPECT_NEAR(turn.dot(k * turn), L * (2 - 3. / 2 + 5. / 3), 1e-12);
}

// Euler's loads of a force at the end: π² EI / 4 L² free, 20.19 EI / L² pinned.
TEST(GeometricStiffness, BucklesUnderAForceAtItsEnd) {
  for (const bool pinned : {false, true}) {
    Cantilever beam;
    beam.axial = true;
    if (pinned) beam.axes.setIdentity();
    beam.pinned = pinned;
    const ReducedBody body = beam.reduce();
    ASSERT_TRUE(check(body).empty());
    ASSERT_EQ(body.geometric->boundary_loads.rows(), 1);
    const double load = critical_load(body.stiffness, matrix_of(body, Loads::boundary));
    const double factor = pinned ? 20.1907 : std::numbers::pi * std::numbers::pi / 4;
    EXPECT_NEAR(load * length * length / soft_stiffness(), factor, 1e-3 * factor) << pinned;
  }
}

// q L³ = 7.8373 EI (Greenhill 1881): a standing column, whose frame is accelerated upwards minus gravity.
TEST(GeometricStiffness, BucklesUnderItsWeight) {
  const Cantilever beam;
  const ReducedBody body = beam.reduce();
  const double weight = critical_load(body.stiffness, -accelerated(body, beam.axes.col(0))) *
                        mass_per_length() * std::pow(length, 3) / soft_stiffness();
  EXPECT_NEAR(weight, 7.8373, 1e-3 * 7.8373);
}

/// Frequencies of a turning cantilever over those at rest with ρA L⁴/EI = 1 (Wright et al. 1982, zero hub
/// radius): out of the plane of rotation; in it, μ² is less by γ².
struct Turning {
  double speed, flap;
};
constexpr std::array turning{
    Turning{0, 3.5160}, Turning{1, 3.6816}, Turning{2, 4.1373}, Turning{3, 4.7973},   Turning{4, 5.5850},
    Turning{5, 6.4495}, Turning{6, 7.3604}, Turning{8, 9.2568}, Turning{10, 11.2023}, Turning{12, 13.1702}};

TEST(GeometricStiffness, StiffensATurningCantilever) {
  Cantilever beam;
  beam.root.setZero();
  beam.breadth = 10 * height;  // so that the lowest frequency is of the soft direction in any case
  beam.modes = 16;
  const ReducedBody body = beam.reduce();
  const double unit = std::sqrt(soft_stiffness() / mass_per_length()) / (length * length);
  for (const auto& [speed, flap] : turning)
    for (const bool in_plane : {false, true}) {
      // The soft direction is z of the beam.
      const Vector3d omega = speed * unit * beam.axes.col(in_plane ? 1 : 2);
      MatrixXd K = body.stiffness + rotating(body, omega);
      const Matrix3d field = omega * omega.transpose() - omega.squaredNorm() * Matrix3d::Identity();
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) K += field(i, j) * body.S_modes[i][j];
      const double lowest = symmetric_eigenvalues(K)[0];
      const double found = lowest / (unit * unit) + (in_plane ? speed * speed : 0);
      EXPECT_NEAR(std::sqrt(found), flap, 5e-4 * flap) << speed << ' ' << in_plane;
    }
}

/// A frame of bars in space that form a tree; all of its nodes are frames.
struct Tree {
  fe::Mesh mesh = test::with_nodes({Vector3d(0.2, -0.1, 0.3), Vector3d(0.9, 0.3, 0.1),
                                    Vector3d(1.1, 1.2, 0.4), Vector3d(1.4, -0.5, -0.3)});
  Tree() {
    const Vector3d y(0.1, 0.3, 1);
    test::add_bar(mesh, 0, 1, 3, test::rectangle(width, height), y);
    test::add_bar(mesh, 1, 2, 2, test::rectangle(width, height), y);
    test::add_bar(mesh, 1, 3, 3, test::rectangle(width, height), y);
  }

  ReducedBody reduce(fe::Stiffening stiffening) const {
    fe::ReductionOptions options;
    options.clamped_nodes = {0};
    options.dynamic_modes = 7;
    options.stiffening = stiffening;
    std::vector<fe::NodeFrame> frames;
    for (int node = 0; node < mesh.nodes.cols(); ++node)
      frames.push_back({std::to_string(node), node, Matrix3d::Identity()});
    return fe::reduce(mesh, options, frames);
  }

  /// The element and all that hangs on its end.
  std::vector<int> from(int element) const {
    std::vector<int> beyond{element};
    for (std::size_t k = 0; k < beyond.size(); ++k)
      for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e)
        if (mesh.elements[e].nodes[0] == mesh.elements[beyond[k]].nodes[1]) beyond.push_back(e);
    return beyond;
  }

  /// Force and moment (body axes) at ξ of an element: the inertia forces of all beyond it.
  Eigen::Matrix<double, 6, 1> resultant(int element, double xi, const Vector3d& constant,
                                        const Matrix3d& gradient) const {
    const auto point = [&](const fe::ElementGeometry& g, double x) -> Vector3d {
      return g.start + x * g.length * g.axes.col(0);
    };
    const Vector3d turn = 0.5 * Vector3d(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0),
                                         gradient(1, 0) - gradient(0, 1));
    const Vector3d at = point(fe::element_geometry(mesh, element), xi);
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (const int e : from(element)) {
      const fe::ElementGeometry g = fe::element_geometry(mesh, e);
      const fe::BeamElement& beam = mesh.elements[e];
      const double first = e == element ? xi : 0;
      for (const fe::GaussPoint& p : fe::gauss4) {
        const Vector3d r = point(g, first + (1 - first) * p.xi), x = g.axes.col(0);
        const double part = p.weight * (1 - first) * g.length;
        const Vector3d f = -part * beam.material.density * beam.section.area * (constant + gradient * r);
        sum.head<3>() += f;
        sum.tail<3>() += (r - at).cross(f) - part * fe::polar_inertia(beam) * x.dot(turn) * x;
      }
    }
    return sum;
  }

  /// What shear forces and moments add to the stiffness, by equilibrium with the inertia forces.
  MatrixXd by_moments(const ReducedBody& body, const Vector3d& constant, const Matrix3d& gradient) const {
    MatrixXd K = MatrixXd::Zero(body.modes, body.modes);
    for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
      const fe::ElementGeometry g = fe::element_geometry(mesh, e);
      Eigen::Matrix4d powers;
      Eigen::Matrix<double, 4, 6> values;
      for (int k = 0; k < 4; ++k) {
        const double xi = k / 3.;
        powers.row(k) << 1, xi, xi * xi, xi * xi * xi;
        const Eigen::Matrix<double, 6, 1> f = resultant(e, xi, constant, gradient);
        values.row(k) << f.head<3>().transpose() * g.axes, f.tail<3>().transpose() * g.axes;
      }
      const MatrixXd c = solve(MatrixXd(powers), MatrixXd(values));
      const auto polynomial = [&](int k) {
        return fe::SectionForces::Polynomial{c(0, k), c(1, k), c(2, k), c(3, k)};
      };
      const fe::SectionForces forces{.shear_y = polynomial(1),
                                     .shear_z = polynomial(2),
                                     .torque = polynomial(3),
                                     .moment_y = polynomial(4),
                                     .moment_z = polynomial(5)};
      MatrixXd dofs(12, body.modes);
      for (int end = 0; end < 2; ++end) {
        const BodyFrame& frame = body.frames[static_cast<std::size_t>(mesh.elements[e].nodes[end])];
        dofs.middleRows<3>(6 * end) = g.axes.transpose() * frame.X;
        dofs.middleRows<3>(6 * end + 3) = g.axes.transpose() * frame.X_theta;
      }
      K += dofs.transpose() * fe::element_geometric_stiffness(forces, g.length) * dofs;
    }
    return K;
  }
};

/// The forces of a tree follow from equilibrium alone, and what its axial forces do as bending shortens the
/// bars is the same by another way.
TEST(GeometricStiffness, OfATreeIsWhatForeshorteningDoesAndMoments) {
  const Tree tree;
  const ReducedBody stressed = tree.reduce(fe::Stiffening::geometric_stiffness),
                    shortened = tree.reduce(fe::Stiffening::foreshortening);
  const SecondOrder& second = *shortened.second_order;
  ASSERT_LT((stressed.node_shapes - shortened.node_shapes).norm(), 1e-9 * shortened.node_shapes.norm());
  const auto expected = [&](const Vector3d& constant, const Matrix3d& gradient) {
    Eigen::RowVectorXd force = constant.transpose() * second.S;
    for (int i = 0; i < 3; ++i) force += gradient.col(i).transpose() * second.S_position[i];
    MatrixXd K = MatrixXd::Zero(stressed.modes, stressed.modes);
    for (std::size_t p = 0; p < second.products.size(); ++p) {
      const auto [a, b] = second.products[p];
      K(a, b) += force[stressed.modes + static_cast<Eigen::Index>(p)];
      K(b, a) += force[stressed.modes + static_cast<Eigen::Index>(p)];
    }
    EXPECT_GT(K.norm(), 0.01);
    const MatrixXd moments = tree.by_moments(stressed, constant, gradient);
    EXPECT_GT(moments.norm(), 0.01 * K.norm());
    return MatrixXd(K + moments);
  };
  const auto compare = [&](int load, const MatrixXd& K) {
    EXPECT_LT((matrix_of(stressed, load) - K).norm(), 1e-7 * K.norm()) << load;
  };
  for (int k = 0; k < 3; ++k) {
    const Vector3d e = Vector3d::Unit(k), next = Vector3d::Unit((k + 1) % 3);
    compare(Loads::acceleration + k, expected(e, Matrix3d::Zero()));
    compare(Loads::angular_acceleration + k, expected(Vector3d::Zero(), skew<double>(e)));
    compare(Loads::angular_velocity + k,
            expected(Vector3d::Zero(), e * e.transpose() - Matrix3d::Identity()));
    compare(Loads::angular_velocity + 3 + k,
            expected(Vector3d::Zero(), e * next.transpose() + next * e.transpose()));
  }
}

/// Whether the beam has a mode that stretches it or not: the stress of inertia is counted once.
TEST(GeometricStiffness, CountsStressOnce) {
  Cantilever beam;
  const ReducedBody without = beam.reduce();
  beam.axial = true;
  const ReducedBody with = beam.reduce();
  const Vector3d a = beam.axes.col(0);
  const MatrixXd held = accelerated(with, a);
  // The modes bear the rest: K y = −Sᵀ a.
  const VectorXd y = PivotedCholesky(with.stiffness).solve(-with.S.transpose() * a);
  ASSERT_EQ(with.geometric->loads.back(), Loads::boundary);
  const double tip = with.geometric->boundary_loads.row(0).dot(y);
  const MatrixXd K = held + tip * with.geometric->stiffness.back();
  // Half of the weight is borne from either end; of the tip's share the free tip has nothing.
  EXPECT_NEAR(tip, -0.5 * mass_per_length() * length, 1e-6 * mass_per_length() * length);
  const double once = critical_load(without.stiffness, -accelerated(without, a)),
               parts = critical_load(with.stiffness, -K);
  EXPECT_NEAR(parts, once, 1e-4 * once);
  EXPECT_GT(std::abs(critical_load(with.stiffness, -held) - once), 0.1 * once);
}

/// Loads that stress no bar of a straight beam have no matrix: ωx², and ωyωz, whose forces vanish on the
/// axis.
TEST(GeometricStiffness, LeavesOutWhatStressesNoBar) {
  Cantilever beam;
  beam.axes.setIdentity();
  beam.root.setZero();
  const ReducedBody body = beam.reduce();
  EXPECT_EQ(body.geometric->loads,
            (std::vector<int>{1, 2, Loads::acceleration, Loads::angular_acceleration}));
  beam.modes = 16;
  EXPECT_EQ(beam.reduce().geometric->loads, (std::vector<int>{1, 2, 3, 5, 6, 7, 8, 9, 10, 11}));
  EXPECT_EQ(body.geometric->boundary_loads.rows(), 0);
}

}  // namespace
}  // namespace mimbre::geometric_stiffness_test
