#include "fe/elements/turning_cell.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <utility>
#include <vector>

#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "support/random_mechanism.h"

/// Displacements of second order in the axes of an element that turns with its nodes, against finite
/// rotations.
namespace mimbre::test::turning_cell_test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

MatrixXd random_fields(Random& random, const fe::TurningCell& cell, int count) {
  MatrixXd u(cell.dofs(), count);
  for (int k = 0; k < count; ++k) u.col(k) = random.values(static_cast<int>(cell.dofs()), 1);
  return u;
}

Matrix3d rotation_by(const Vector3d& v) {
  return v.norm() > 0 ? Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix() : Matrix3d::Identity();
}

Vector3d vector_of(const Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

/// A cell's dofs in axes that are turned by its mean rotation, by `size` times the field u.
VectorXd in_turned_axes(const fe::TurningCell& cell, const VectorXd& u, double size) {
  VectorXd out(u.size());
  const Matrix3d back = rotation_by(size * (cell.turn * u)).transpose();
  for (Eigen::Index k = 0; k < cell.arms.cols(); ++k) {
    const Eigen::Index at = cell.node_dofs * k;
    const Vector3d arm = cell.arms.col(k);
    out.segment<3>(at) = back * (arm + size * u.segment<3>(at)) - arm;
    if (cell.node_dofs == 6)
      out.segment<3>(at + 3) = vector_of(back * rotation_by(size * u.segment<3>(at + 3)));
  }
  return out;
}

/// What a bar of slopes φ at its ends, against its chord, is longer along its bow than along the chord:
/// ½ ∫ v'² dx by Simpson's rule in many parts.
double bow(double length, const Vector3d& turn, const VectorXd& u) {
  double sum = 0;
  constexpr int parts = 100;
  for (int k = 0; k <= parts; ++k) {
    const double s = static_cast<double>(k) / parts, first = 1 - 4 * s + 3 * s * s,
                 second = 3 * s * s - 2 * s;
    const double weight = k == 0 || k == parts ? 1 : k % 2 == 1 ? 4 : 2;
    for (const Eigen::Index d : {1, 2}) {
      const double slope = first * (u[3 + d] - turn[d]) + second * (u[9 + d] - turn[d]);
      sum += weight / 3 * slope * slope / 2;
    }
  }
  return length * sum / parts;
}

std::vector<std::pair<std::string, fe::TurningCell>> cells() {
  std::vector<std::pair<std::string, fe::TurningCell>> out;
  const auto add = [&](const char* name, const fe::SolidMesh& mesh) {
    out.emplace_back(name, turning_cell(mesh, mesh_cells(mesh), {mesh.nodes, mesh.beams}, 0));
  };
  const auto skewed = [](const Vector3d& p) {
    return Vector3d(p.x() + 0.2 * p.y(), p.y(), p.z() - 0.1 * p.x());
  };
  add("brick", block(ElementType::hex8, {1, 0.7, 0.4}, {1, 1, 1}, steel(), skewed));
  add("tetrahedron", block(ElementType::tet10, {1, 0.7, 0.4}, {1, 1, 1}, steel(), skewed));
  add("shell", shell_mesh(ElementType::quad4, 1, 1, steel(), 0.02,
                          [](double x, double y) { return Vector3d(x, 0.6 * y + 0.1 * x, 0.3 * x); }));
  const fe::Mesh beam = moved(straight_beam(0.8, 1, rectangle(0.03, 0.02)), some_rotation(), {1, 2, 3});
  fe::SolidMesh bars;
  bars.nodes = beam.nodes;
  bars.beams = beam.elements;
  add("bar", bars);
  return out;
}

TEST(TurningCell, SecondOrderIsThatOfFiniteRotations) {
  Random random(11);
  for (const auto& [name, cell] : cells()) {
    const VectorXd u = random_fields(random, cell, 1);
    const MatrixXd m = motions(cell, u);
    VectorXd second = second_order(cell, u, m, 0, 0);
    if (cell.bar > 0) {
      const double longer = bow(cell.bar, cell.turn * u, u);
      EXPECT_GT(longer, 1e-3);
      second[0] += 0.5 * longer;
      second[6] -= 0.5 * longer;
    }
    constexpr double size = 1e-3;  // the even part is size² × second, and of fourth order
    const VectorXd even = 0.5 * (in_turned_axes(cell, u, size) + in_turned_axes(cell, u, -size));
    EXPECT_LT((even / (size * size) - second).norm(), 1e-4 * second.norm()) << name;
    EXPECT_GT(second.norm(), 0.1) << name;
  }
}

TEST(TurningCell, ThatOfTwoFieldsIsHalfOfWhatBothHaveBeyondEach) {
  Random random(12);
  for (const auto& [name, cell] : cells()) {
    MatrixXd u = random_fields(random, cell, 3);
    u.col(2) = u.col(0) + u.col(1);
    const MatrixXd m = motions(cell, u);
    const auto of = [&](int a, int b) { return second_order(cell, u, m, a, b); };
    EXPECT_LT((of(0, 1) - 0.5 * (of(2, 2) - of(0, 0) - of(1, 1))).norm(), 1e-12 * of(0, 1).norm()) << name;
  }
}

TEST(TurningCell, TheWorkOfForcesIsThatOnTheSecondOrder) {
  Random random(13);
  for (const auto& [name, cell] : cells()) {
    const auto dofs = static_cast<int>(cell.dofs());
    const MatrixXd u = random_fields(random, cell, 3), m = motions(cell, u);
    const VectorXd forces = random.values(dofs, 1);
    const MatrixXd P = work_partner(cell, forces, u, m);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const double work = forces.dot(second_order(cell, u, m, a, b));
        EXPECT_NEAR(0.5 * (m.col(a).dot(P.col(b)) + P.col(a).dot(m.col(b))), work, 1e-12 * forces.norm())
            << name;
      }
  }
}

}  // namespace
}  // namespace mimbre::test::turning_cell_test
