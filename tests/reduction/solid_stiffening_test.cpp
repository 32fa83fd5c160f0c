#include "reduction/stiffening/solid_stiffening.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "fe/bar_ends.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"

/// Geometric stiffness of solids from unit loads.
namespace mimbre::test::solid_stiffening_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const fe::Material steel{2.1e11, 0, 7850};  // without Poisson's ratio a clamped bar is a beam
constexpr double length = 1, width = 0.02;

ReducedBody clamped_bar() {
  const fe::SolidMesh mesh = block(fe::ElementType::hex20, {length, width, width}, {12, 1, 1}, steel);
  fe::ModelReduction o;
  o.interfaces = {end(mesh, "root", 0), end(mesh, "tip", length)};
  o.dynamic_modes = 6;
  o.free_modes = 0;
  o.geometric_stiffness = true;
  return fe::reduce(mesh, fe::assemble(mesh), o).body;
}

/// Σ s_l K_l of the forces at the interfaces that belong to a static deformation y.
MatrixXd boundary_stiffening(const ReducedBody& body, const Eigen::VectorXd& y) {
  const GeometricStiffness& g = *body.geometric;
  const Eigen::VectorXd loads = g.boundary_loads * y;
  MatrixXd sum = MatrixXd::Zero(body.modes, body.modes);
  for (std::size_t l = 0; l < g.loads.size(); ++l)
    if (const int row = g.loads[l] - GeometricStiffness::boundary; row >= 0)
      sum += loads[row] * g.stiffness[l];
  return sum;
}

/// Of a unit load of inertia.
MatrixXd stiffening(const ReducedBody& body, int load) {
  const GeometricStiffness& g = *body.geometric;
  for (std::size_t l = 0; l < g.loads.size(); ++l)
    if (g.loads[l] == load) return g.stiffness[l];
  ADD_FAILURE() << "no load " << load;
  return MatrixXd::Zero(body.modes, body.modes);
}

constexpr double area = width * width, inertia = area * area / 12;
const double unit = std::sqrt(steel.young * inertia / (steel.density * area)) / (length * length);

/// Flapping of a cantilever that turns about z: μ = 3.5160, 4.1373, 5.5850, 7.3604 at γ = 0, 2, 4, 6 (A. D.
/// Wright et al., J. Appl. Mech. 49 (1982) 197–202).
TEST(SolidStiffening, ATurningBarFlapsAsTheorySays) {
  const ReducedBody body = clamped_bar();
  ASSERT_TRUE(body.geometric.has_value());
  EXPECT_TRUE(check(body).empty());
  for (const auto& [speed, frequency] :
       {std::pair{0.0, 3.5160}, {2.0, 4.1373}, {4.0, 5.5850}, {6.0, 7.3604}}) {
    const double omega = speed * unit;
    // The tip is not held: what the held body lacks of the tension comes with the stretch of its static
    // modes.
    const Eigen::VectorXd force = omega * omega * (body.S_position[0].row(0) + body.S_position[1].row(1));
    const MatrixXd K = body.stiffness + omega * omega * stiffening(body, 2) +
                       boundary_stiffening(body, PivotedCholesky(body.stiffness).solve(force));
    // Out of the plane of rotation nothing else acts; in it the bar moves away from the axis: −ω² M.
    const VectorXd flap = symmetric_eigenvalues(K);
    EXPECT_NEAR(std::sqrt(flap[0]) / unit / frequency, 1, 0.01) << speed;
  }
}

/// A force on the tip that buckles it: π² EI / 4 L².
TEST(SolidStiffening, AColumnBucklesAtEulersLoad) {
  const ReducedBody body = clamped_bar();
  const BodyFrame& tip = body.frames[1];
  const MatrixXd KG = boundary_stiffening(
      body, PivotedCholesky(body.stiffness).solve(tip.X.transpose() * Eigen::Vector3d::UnitX()));
  // K − P KG is singular at the buckling load.
  const VectorXd buckling = symmetric_eigenvalues(KG, body.stiffness);
  const double load = 1 / buckling.maxCoeff();
  const double euler = std::numbers::pi * std::numbers::pi * steel.young * inertia / (4 * length * length);
  EXPECT_NEAR(load / euler, 1, 0.02);
}

}  // namespace
}  // namespace mimbre::test::solid_stiffening_test
