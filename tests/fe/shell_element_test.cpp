#include "fe/elements/shell_element.h"

#include <gtest/gtest.h>

#include "fe/elements/shell_membrane.h"
#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"

namespace mimbre::test::shell_element_test {
namespace {

constexpr std::array kShellTypes{ElementType::tri3, ElementType::quad4};
constexpr double kThickness = 0.05;

/// In a plane that no axis lies in; a quadrilateral may be warped.
fe::ShellNodes single_shell(ElementType type, double warp) {
  fe::ShellNodes nodes(3, fe::node_count(type));
  if (type == ElementType::tri3)
    nodes << 0, 1.1, 0.3, 0, 0.2, 0.9, 0, 0, 0;
  else
    nodes << 0, 1.1, 1.3, -0.1, 0, -0.1, 0.9, 0.7, warp, -warp, warp, -warp;
  return (some_rotation() * nodes).colwise() + Eigen::Vector3d(0.2, -0.4, 0.7);
}

Eigen::MatrixXd rigid_shell_motions(const Eigen::Matrix3Xd& nodes) {
  fe::Mesh mesh;
  mesh.nodes = nodes;
  return rigid_motions(mesh);
}

/// A patch with an inner node, turned: corners on the rectangle 0.24 × 0.12, inside distorted (MacNeal,
/// Harder 1985).
fe::SolidMesh patch(ElementType type, const Eigen::Matrix3d& axes) {
  fe::SolidMesh mesh;
  mesh.nodes.resize(3, 8);
  mesh.nodes << 0, 0.24, 0.24, 0, 0.04, 0.18, 0.16, 0.08,  //
      0, 0, 0.12, 0.12, 0.02, 0.03, 0.08, 0.08,            //
      0, 0, 0, 0, 0, 0, 0, 0;
  mesh.nodes = (axes * mesh.nodes).eval();
  mesh.materials = {{"steel", steel()}};
  const std::array<std::array<int, 4>, 5> quads{
      {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}}};
  fe::ElementGroup group{type, "patch", 0, 0.01, {}, {}};
  for (const auto& [a, b, c, d] : quads)
    if (type == ElementType::quad4)
      group.nodes.insert(group.nodes.end(), {a, b, c, d});
    else
      group.nodes.insert(group.nodes.end(), {a, b, c, a, c, d});
  mesh.groups.push_back(group);
  return mesh;
}

/// What K says of a field of displacement and rotation given in the patch's own axes: its energy is the
/// wanted one and the inner nodes are without force.
void expect_passes(ElementType type, double energy,
                   const std::function<Eigen::Matrix<double, 6, 1>(double, double)>& field) {
  const Eigen::Matrix3d axes = some_rotation();
  const fe::SolidMesh mesh = patch(type, axes);
  Eigen::VectorXd u(6 * mesh.nodes.cols());
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n) {
    const Eigen::Vector3d at = axes.transpose() * mesh.nodes.col(n);
    const auto local = field(at.x(), at.y());
    u.segment<3>(6 * n) = axes * local.head<3>();
    u.segment<3>(6 * n + 3) = axes * local.tail<3>();
  }
  const Eigen::VectorXd force = full(fe::assemble(mesh).stiffness) * u;
  EXPECT_NEAR(0.5 * u.dot(force), energy, 1e-9 * energy) << type_name(type);
  EXPECT_LT(force.tail(24).cwiseAbs().maxCoeff(), 1e-9 * force.cwiseAbs().maxCoeff()) << type_name(type);
}

constexpr double kPatchArea = 0.24 * 0.12;

TEST(ShellElement, PatchTestOfTheMembrane) {
  const double E = steel().young, nu = steel().poisson, t = 0.01;
  const double ex = 1e-3, ey = -4e-4, g = 7e-4;
  const double energy = 0.5 * kPatchArea * t * E / (1 - nu * nu) *
                        (ex * ex + ey * ey + 2 * nu * ex * ey + (1 - nu) / 2 * g * g);
  for (ElementType type : kShellTypes)
    expect_passes(type, energy, [&](double x, double y) {
      Eigen::Matrix<double, 6, 1> u;
      u << ex * x + 0.2 * g * y, 0.8 * g * x + ey * y, 0, 0, 0, 0.3 * g;
      return u;
    });
}

TEST(ShellElement, PatchTestOfThePlate) {
  const double E = steel().young, nu = steel().poisson, t = 0.01;
  const double kx = 0.2, ky = -0.1, kxy = 0.3;  // w = ½ kx x² + ½ ky y² + ½ kxy x y
  const double D = E * t * t * t / (12 * (1 - nu * nu));
  const double energy =
      0.5 * kPatchArea * D * (kx * kx + ky * ky + 2 * nu * kx * ky + (1 - nu) / 2 * kxy * kxy);
  for (ElementType type : kShellTypes)
    expect_passes(type, energy, [&](double x, double y) {
      Eigen::Matrix<double, 6, 1> u;
      u << 0, 0, 0.5 * (kx * x * x + ky * y * y + kxy * x * y), ky * y + 0.5 * kxy * x,
          -(kx * x + 0.5 * kxy * y), 0;
      return u;
    });
}

TEST(ShellElement, OnlyRigidMotionsHaveNoEnergyWarpedOrNot) {
  for (ElementType type : kShellTypes)
    for (double warp : {0.0, 0.08}) {
      const fe::ShellNodes nodes = single_shell(type, warp);
      const Eigen::MatrixXd K = fe::shell_matrices(type, nodes, steel(), kThickness).stiffness;
      EXPECT_EQ((K - K.transpose()).norm(), 0);
      const double scale = K.cwiseAbs().maxCoeff();
      EXPECT_LT((K * rigid_shell_motions(nodes)).cwiseAbs().maxCoeff(), 1e-13 * scale) << type_name(type);
      const Eigen::VectorXd energies = symmetric_eigenvalues(K);
      EXPECT_GT(energies[6], 1e-6 * scale) << type_name(type) << " " << energies.transpose();
    }
}

TEST(ShellElement, MassAndInertiaAreExact) {
  for (ElementType type : kShellTypes) {
    const fe::ShellNodes nodes = single_shell(type, 0);
    const Eigen::MatrixXd motions = rigid_shell_motions(nodes);
    const Eigen::MatrixXd mass = fe::shell_matrices(type, nodes, steel(), kThickness).mass;
    EXPECT_EQ((mass - mass.transpose()).norm(), 0);
    EXPECT_GT(symmetric_eigenvalues(mass)[0], -1e-14 * mass.maxCoeff());
    const Eigen::MatrixXd M = motions.transpose() * mass * motions;

    // Second moments of thin triangles, and ρt³/12 about axes in the plane.
    double total = 0;
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d through = Eigen::Matrix3d::Zero();
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    for (Eigen::Index k = 1; k + 1 < nodes.cols(); ++k) {
      const Eigen::Vector3d a = nodes.col(0), b = nodes.col(k), c = nodes.col(k + 1);
      const Eigen::Vector3d doubled = (b - a).cross(c - a);
      const double m = steel().density * kThickness * doubled.norm() / 2;
      const Eigen::Vector3d sum = a + b + c;
      total += m;
      first += m / 3 * sum;
      second += m / 12 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
      const Eigen::Vector3d n = doubled.normalized();
      through += m * kThickness * kThickness / 12 * (Eigen::Matrix3d::Identity() - n * n.transpose());
    }
    const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second + through;
    EXPECT_LT((M.topLeftCorner<3, 3>() - total * Eigen::Matrix3d::Identity()).norm(), 1e-12 * total);
    for (int k = 0; k < 3; ++k)
      EXPECT_LT((M.block<3, 1>(0, 3 + k) - Eigen::Vector3d::Unit(k).cross(first)).norm(), 1e-12 * total);
    EXPECT_LT((M.bottomRightCorner<3, 3>() - inertia).norm(), 1e-12 * inertia.norm()) << type_name(type);
  }
}

TEST(ShellElement, OfFibresIsTheSameWhereverItsNumberingBegins) {
  // The energy belongs to the sheet: neither the corner that is named first nor the axes matter.
  const fe::NamedMaterial fibres{
      "fibres", {0, 0, 1600}, fe::elastic_matrix({1.4e11, 1e10, 1e10, 0.3, 0.3, 0.4, 5e9, 5e9, 4e9})};
  for (const ElementType type : kShellTypes)
    for (const double angle : {0.0, 0.6, 1.1}) {
      const fe::Orientation along{
          fe::Orientation::Kind::rectangular,
          some_rotation() * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
          Eigen::Vector3d::Zero()};
      const fe::ElementMaterial material(fibres, &along);
      const fe::ShellNodes nodes = single_shell(type, 0);
      const Eigen::Index count = nodes.cols();
      const Eigen::MatrixXd K = fe::shell_matrices({type, nodes, kThickness}, material).stiffness;
      for (Eigen::Index first = 1; first < count; ++first) {
        Eigen::VectorXi dofs(6 * count);
        fe::ShellNodes renumbered(3, count);
        for (Eigen::Index k = 0; k < count; ++k) {
          renumbered.col(k) = nodes.col((k + first) % count);
          for (int j = 0; j < 6; ++j) dofs[6 * k + j] = static_cast<int>(6 * ((k + first) % count)) + j;
        }
        const Eigen::MatrixXd same = fe::shell_matrices({type, renumbered, kThickness}, material).stiffness;
        EXPECT_LT((same - K(dofs, dofs)).norm(), 1e-11 * K.norm()) << type_name(type) << ' ' << angle;
      }
    }
}

TEST(ShellElement, BendsInItsPlaneByFelippasShare) {
  // His rule gives ½ (1 − 4 ν²) for any isotropic sheet; a sheet that is nearly isotropic has nearly that.
  fe::PlaneNodes quad(2, 4);
  quad << -1, 1.2, 0.8, -1, -0.5, -0.6, 0.5, 0.4;
  for (const double nu : {0.0, 0.3, 0.45}) {
    Eigen::Matrix3d elastic;
    elastic << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
    elastic /= 1 - nu * nu;
    const Eigen::MatrixXd K = fe::membrane_stiffness(quad, 1, nu, 1);
    EXPECT_LT((fe::membrane_stiffness(quad, elastic, 1) - K).norm(), 1e-15 * K.norm()) << nu;
    elastic(0, 0) *= 1 + 1e-9;
    EXPECT_LT((fe::membrane_stiffness(quad, elastic, 1) - K).norm(), 1e-7 * K.norm()) << nu;
  }
}

/// Displacements under forces, all but the free dofs held.
Eigen::VectorXd solve(const fe::FeMatrices& matrices, const std::vector<int>& free,
                      const Eigen::VectorXd& force) {
  const Eigen::MatrixXd K = full(matrices.stiffness);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(K.rows());
  u(free) = Cholesky(K(free, free)).solve(force(free));
  return u;
}

TEST(ShellElement, RectanglesOfAnyAspectRatioHaveTheEnergyOfBendingInTheirPlane) {
  // u = −k x y, v = ½ k (x² + ν y²), θ = k x: energy ½ E I k² per length.
  const double nu = 0.3;
  for (double length : {1.0, 4.0, 16.0}) {
    const auto energy = [&](const fe::PlaneNodes& nodes) {
      Eigen::VectorXd u(3 * nodes.cols());
      for (Eigen::Index n = 0; n < nodes.cols(); ++n) {
        const double x = nodes(0, n), y = nodes(1, n);
        u.segment<3>(3 * n) << -x * y, 0.5 * (x * x + nu * y * y), x;
      }
      return 0.5 * u.dot(fe::membrane_stiffness(nodes, 1, nu, 1) * u);
    };
    fe::PlaneNodes quad(2, 4);
    quad << -length / 2, length / 2, length / 2, -length / 2, -0.5, -0.5, 0.5, 0.5;
    const double exact = 0.5 * length / 12;
    EXPECT_NEAR(energy(quad), exact, 1e-10 * exact);
    const fe::PlaneNodes lower = quad.leftCols(3);
    const fe::PlaneNodes upper = quad(Eigen::all, std::array{0, 2, 3});
    EXPECT_NEAR(energy(lower) + energy(upper), exact, 1e-10 * exact);
  }
}

TEST(ShellElement, StripOfFlatElementsBendsInItsPlane) {
  // Six elements 4 times as long as high under an end moment: plane triangles and quadrilaterals without
  // rotations lock here. The triangles are soft where their diagonals all run one way.
  const double L = 1.2, h = 0.05, t = 0.01;
  const double I = t * h * h * h / 12;
  for (ElementType type : kShellTypes) {
    const fe::SolidMesh mesh = shell_mesh(
        type, 6, 1, steel(), t, [&](double x, double y) { return Eigen::Vector3d(L * x, h * (y - 0.5), 0); });
    const fe::FeMatrices matrices = fe::assemble(mesh);
    std::vector<int> free;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(matrices.stiffness.rows());
    double* tip = nullptr;
    for (int r = 0; r < static_cast<int>(matrices.dofs.size()); ++r) {
      const auto [node, direction] = matrices.dofs[r];
      const Eigen::Vector3d x = mesh.nodes.col(node);
      const bool root = x.x() < 1e-9 && (direction == 0 || (direction == 1 && x.y() < 0));
      const bool in_plane = direction == 0 || direction == 1 || direction == 5;
      if (in_plane && !root) free.push_back(r);
      if (x.x() > L - 1e-9 && direction == 0) force[r] = (x.y() < 0 ? 1 : -1) / h;
      if (x.x() > L - 1e-9 && direction == 1) tip = &force[r];
    }
    const Eigen::VectorXd u = solve(matrices, free, force);
    EXPECT_NEAR(u[tip - force.data()] / (L * L / (2 * steel().young * I)), 1,
                type == ElementType::quad4 ? 0.005 : 0.08)
        << type_name(type);
  }
}

TEST(ShellElement, ThickStripShearsAsTimoshenkosBeam) {
  const double L = 0.5, b = 0.2, t = 0.2;
  const fe::Material material{2.1e11, 0, 7850};
  const double exact =
      L * L * L / (3 * material.young * b * t * t * t / 12) + L / (5.0 / 6 * material.young / 2 * b * t);
  for (ElementType type : kShellTypes) {
    const fe::SolidMesh mesh = shell_mesh(
        type, 10, 4, material, t, [&](double x, double y) { return Eigen::Vector3d(L * x, b * y, 0); });
    const fe::FeMatrices matrices = fe::assemble(mesh);
    std::vector<int> free;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(matrices.stiffness.rows());
    for (int r = 0; r < static_cast<int>(matrices.dofs.size()); ++r) {
      const auto [node, direction] = matrices.dofs[r];
      const Eigen::Vector3d x = mesh.nodes.col(node);
      if (x.x() > 1e-9) free.push_back(r);
      if (x.x() > L - 1e-9 && direction == 2) force[r] = (x.y() < 1e-9 || x.y() > b - 1e-9 ? 0.5 : 1.0) / 4;
    }
    EXPECT_NEAR(force.dot(solve(matrices, free, force)) / exact, 1, 0.01) << type_name(type);
  }
}

TEST(ShellElement, ScordelisLoRoofSagsAsPublished) {
  // A quarter of the barrel vault under its weight: the middle of the free edge sinks by 0.3024 (MacNeal,
  // Harder 1985).
  const fe::Material material{4.32e8, 0, 1};
  const double R = 25, half_length = 25, load = 90;
  constexpr int n = 10;
  for (ElementType type : kShellTypes) {
    const auto angle = [](double y) { return 40 * y * std::numbers::pi / 180; };
    const fe::SolidMesh mesh = shell_mesh(type, n, n, material, 0.25, [&](double x, double y) {
      return Eigen::Vector3d(half_length * x, R * std::sin(angle(y)), R * std::cos(angle(y)));
    });
    const fe::FeMatrices matrices = fe::assemble(mesh);
    std::vector<int> free;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(matrices.stiffness.rows());
    int edge = -1;
    const double share = load * half_length * R * angle(1) / (n * n);
    for (int r = 0; r < static_cast<int>(matrices.dofs.size()); ++r) {
      const auto [node, d] = matrices.dofs[r];
      const int i = node % (n + 1), j = node / (n + 1);
      const bool diaphragm = i == n && (d == 1 || d == 2);
      const bool middle = i == 0 && (d == 0 || d == 4 || d == 5);
      const bool crown = j == 0 && (d == 1 || d == 3 || d == 5);
      if (!diaphragm && !middle && !crown) free.push_back(r);
      if (d == 2) force[r] = -share * (i == 0 || i == n ? 0.5 : 1) * (j == 0 || j == n ? 0.5 : 1);
      if (d == 2 && i == 0 && j == n) edge = r;
    }
    const Eigen::VectorXd u = solve(matrices, free, force);
    EXPECT_NEAR(-u[edge] / 0.3024, 1, 0.03) << type_name(type);
  }
}

}  // namespace
}  // namespace mimbre::test::shell_element_test
