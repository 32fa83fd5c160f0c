#include "reduction/stiffening/stretching.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "math/once/decompositions.h"
#include "mimbre/fe_mesh.h"
#include "mimbre/fe_reduce.h"
#include "reduction/file/mirror.h"

/// What bending does to lengths and areas, against plates and strips of von Kármán's theory.
namespace mimbre::fe::stretching_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double young = 2.1e11, density = 7850;

/// A rectangle of shells (z = 0) or of one layer of bricks.
struct Sheet {
  double length = 1, width = 1, thickness = 0.01, poisson = 0.3;
  int nx = 12, ny = 12;
  bool solid = false;

  int node(int i, int j, int k = 0) const { return (k * (ny + 1) + j) * (nx + 1) + i; }
  SolidMesh mesh() const {
    SolidMesh m;
    const int layers = solid ? 2 : 1;
    m.nodes.resize(3, layers * (nx + 1) * (ny + 1));
    for (int k = 0; k < layers; ++k)
      for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i)
          m.nodes.col(node(i, j, k)) =
              Vector3d(i * length / nx, j * width / ny, solid ? (k - 0.5) * thickness : 0);
    ElementGroup group;
    group.type = solid ? ElementType::hex8 : ElementType::quad4;
    group.name = "sheet";
    group.material = 0;
    group.thickness = solid ? 0 : thickness;
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (int k = 0; k < layers; ++k)
          for (const int n : {node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)})
            group.nodes.push_back(n);
    m.groups.push_back(group);
    m.materials.push_back({"steel", {young, poisson, density}});
    return m;
  }
  template <class Test>
  Interface where(const char* name, const Vector3d& point, const Test& test) const {
    Interface interface;
    interface.name = name;
    interface.point = point;
    for (int k = 0; k < (solid ? 2 : 1); ++k)
      for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i)
          if (test(i, j)) interface.nodes.push_back(node(i, j, k));
    return interface;
  }
};

ReducedBody reduced(const SolidMesh& mesh, std::vector<Interface> interfaces, int modes = 20) {
  ModelReduction options;
  options.interfaces = std::move(interfaces);
  options.dynamic_modes = modes;
  options.free_modes = 0;
  return reduce(mesh, assemble(mesh), options).body;
}

/// Under an acceleration, by linear theory with everything held that is not a mode.
VectorXd bent(const ReducedBody& body, const Vector3d& acceleration) {
  return mimbre::solve(body.stiffness, body.S.transpose() * acceleration);
}

double largest(const ReducedBody& body, const VectorXd& y) {
  const VectorXd u = body.node_shapes * y;
  double most = 0;
  for (Index k = 0; k < body.nodes.cols(); ++k) most = std::max(most, u.segment<3>(3 * k).norm());
  return most;
}

VectorXd stretches(const Stretching& s, const VectorXd& y, const Vector3d& turn = Vector3d::Zero()) {
  VectorXd z(y.size() + 3), e(s.forms.size());
  z << y, turn;
  for (std::size_t k = 0; k < s.forms.size(); ++k) e[static_cast<Index>(k)] = 0.5 * z.dot(s.forms[k] * z);
  return e;
}

/// Twice the energy of the stretch over that of the bending, the places held, or free to move.
double ratio(const ReducedBody& body, const VectorXd& y, bool places_held) {
  const Stretching& s = *body.stretching;
  const VectorXd e = stretches(s, y);
  double energy = e.squaredNorm();
  if (!places_held) {
    const VectorXd force = s.places.transpose() * e;
    energy -= force.dot(VectorXd(mimbre::shortest_solution(s.stiffness, force, 1e-12)));
  }
  return energy / (0.5 * y.dot(body.stiffness * y));
}

/// S. Levy, Square plate with clamped edges under normal pressure producing large deflections, NACA Report
/// 740 (1942): ν = 0.316, edges that do not move; w/h = 0.471 and 0.912 under p b⁴/(E h⁴) = 38.3 and 95,
/// where linear theory has 0.521 and 1.293: with α + ρα³ = 1 ρ = 0.48 and 0.50 (w/h)² of linear theory.
TEST(Stretching, OfAClampedSquarePlateIsLevys) {
  Sheet sheet;
  sheet.poisson = 0.316;
  sheet.nx = sheet.ny = 24;
  const ReducedBody body = reduced(sheet.mesh(), {sheet.where("edge", Vector3d::Zero(), [&](int i, int j) {
                                     return i == 0 || j == 0 || i == sheet.nx || j == sheet.ny;
                                   })});
  ASSERT_TRUE(body.stretching);
  const VectorXd y = bent(body, Vector3d(0, 0, 100));
  const double w = largest(body, y) / sheet.thickness;
  EXPECT_NEAR(ratio(body, y, true), 0.49 * w * w, 0.05 * w * w);
}

/// A strip between held ends: ½∫v'² and the energy of v = q/(24 EI) x² (L − x)²; wide strips bend as plates,
/// and their tension is that of a plane strain in the middle: between 1 and 1/(1 − ν²) of the beam's.
TEST(Stretching, OfAStripBetweenHeldEndsIsThatOfABeam) {
  for (const bool solid : {false, true}) {
    Sheet sheet;
    sheet.width = 0.05;
    sheet.thickness = 0.005;
    sheet.poisson = 0;
    sheet.nx = 40;
    sheet.ny = 2;
    sheet.solid = solid;
    const ReducedBody body = reduced(
        sheet.mesh(), {sheet.where("start", Vector3d(0, 0.025, 0), [](int i, int) { return i == 0; }),
                       sheet.where("end", Vector3d(1, 0.025, 0), [](int i, int) { return i == 40; })});
    ASSERT_TRUE(body.stretching);
    // Both ends held: dynamic modes alone.
    const MatrixXd user = mimbre::inverse(body.user_from_modal);
    MatrixXd dynamic(body.modes, 0);
    for (Index k = 0; k < body.modes; ++k)
      if (body.mode_names[static_cast<std::size_t>(k)].starts_with("dynamic")) {
        dynamic.conservativeResize(Eigen::NoChange, dynamic.cols() + 1);
        dynamic.rightCols<1>() = user.col(k);
      }
    const VectorXd y = dynamic * mimbre::solve(dynamic.transpose() * body.stiffness * dynamic,
                                               dynamic.transpose() * body.S.transpose() * Vector3d(0, 0, 10));
    const double w = largest(body, y), t = sheet.thickness;
    // w = qL⁴/(384 EI): ½∫v'² = 128 w²/(105 · ½ L), U = ½ q ∫v = 384·8/30/2 EI w²/L³.
    const double stretch = 0.5 * 256.0 / 105 * 2 * w * w, energy = 0.5 * 384 * 8.0 / 15 * t * t / 12 * w * w;
    const double exact = stretch * stretch / energy;
    EXPECT_NEAR(ratio(body, y, true), exact, 0.05 * exact) << solid;
    EXPECT_LT(ratio(body, y, false), 1e-3 * exact) << solid;
  }
}

/// Turned as a whole, and bent by it no more, it stretches as its rotation is linear: ½ φ² in every direction
/// across the axis, all of which its places take up.
TEST(Stretching, OfAFreeBodyThatTurnsIsNone) {
  Sheet sheet;
  sheet.nx = sheet.ny = 6;
  const ReducedBody body =
      reduced(sheet.mesh(), {sheet.where("start", Vector3d(0, 0.5, 0), [](int i, int) { return i == 0; }),
                             sheet.where("end", Vector3d(1, 0.5, 0), [](int i, int) { return i == 6; })});
  ASSERT_TRUE(body.stretching);
  const Stretching& s = *body.stretching;
  const VectorXd none = VectorXd::Zero(body.modes);
  for (int axis = 0; axis < 3; ++axis) {
    // The places' displacements of second order, ½ φ × (φ × r).
    const Vector3d turn = 0.1 * Vector3d::Unit(axis);
    VectorXd d = VectorXd::Zero(s.places.cols());
    for (std::size_t k = 0; k < body.frames.size(); ++k)
      d.segment<3>(6 * s.place_of_frame[k]) = 0.5 * turn.cross(turn.cross(body.frames[k].position));
    const VectorXd e = stretches(s, none, turn);
    EXPECT_LT((e + s.places * d).norm(), 1e-6 * (s.places.cwiseAbs() * d.cwiseAbs()).norm()) << axis;
  }
}

TEST(Stretching, OfAMirroredBodyIsMirrored) {
  Sheet sheet;
  sheet.nx = 8;
  sheet.ny = 3;
  sheet.width = 0.3;
  const auto start = [](int i, int) { return i == 0; };
  const auto end = [](int i, int j) { return i == 8 && j > 1; };
  SolidMesh mesh = sheet.mesh(), other = mesh;
  other.nodes.row(1) *= -1;
  for (std::size_t e = 0; e < other.groups[0].nodes.size(); e += 4)
    std::swap(other.groups[0].nodes[e + 1], other.groups[0].nodes[e + 3]);
  const ReducedBody body = reduced(
      mesh, {sheet.where("start", Vector3d(0, 0.1, 0), start), sheet.where("end", Vector3d(1, 0.2, 0), end)},
      6);
  const ReducedBody built = reduced(
      other,
      {sheet.where("start", Vector3d(0, -0.1, 0), start), sheet.where("end", Vector3d(1, -0.2, 0), end)}, 6);
  ASSERT_TRUE(body.stretching && built.stretching);
  const ReducedBody image = mirrored(body, Vector3d(1, -1, 1));
  // The same modes but for their signs.
  const MatrixXd same = (image.node_shapes.transpose() * built.node_shapes);
  VectorXd y = VectorXd::LinSpaced(body.modes, 1, 2).cwiseQuotient(body.eigenfrequencies), other_y = y;
  for (Index k = 0; k < y.size(); ++k)
    if (same(k, k) < 0) other_y[k] *= -1;
  const Vector3d turn(1e-3, 2e-3, -1e-3);
  EXPECT_NEAR(stretches(*image.stretching, y, turn).norm(),
              stretches(*built.stretching, other_y, turn).norm(),
              1e-6 * stretches(*built.stretching, other_y, turn).norm());
}

}  // namespace
}  // namespace mimbre::fe::stretching_test
