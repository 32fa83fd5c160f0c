#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"
#include "reduction/stiffening/geometric_stiffness.h"

/// Reduced strips whose bending in one plane lets them tip over and twist.
namespace mimbre::test::lateral_buckling_test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Loads = GeometricStiffness;

/// A cantilever in any direction, 0.1 m high (along its z) and 0.01 m thick.
struct Strip {
  double length = 2;
  Eigen::Matrix3d axes = some_rotation();
  double eccentricity = 0;  ///< of the tip's node, up from the axis
  fe::Section section = [] {
    fe::Section s = rectangle(0.01, 0.1);
    s.J = 0.1 * 1e-6 / 3 * (1 - 0.63 * 0.1);
    return s;
  }();

  /// √(EI GJ)
  double stiffness() const {
    const fe::Material m = steel();
    return m.young * std::sqrt(section.Iz * section.J / (2 * (1 + m.poisson)));
  }

  ReducedBody reduce(bool tip_mode) const {
    const Vector3d root(0.3, -0.2, 0.5), up = eccentricity * axes.col(2);
    fe::Mesh mesh = with_nodes({root, root + length * axes.col(0)});
    add_bar(mesh, 0, 1, 24, section, axes.col(1));
    mesh.nodes.col(1) += up;
    mesh.elements.back().offsets[1] = -up;
    fe::ReductionOptions options;
    options.clamped_nodes = {0};
    if (tip_mode) options.boundary.push_back({1, false, axes.col(2), "up"});
    options.dynamic_modes = 24;
    options.stiffening = fe::Stiffening::geometric_stiffness;
    return fe::reduce(mesh, options, {});
  }
};

/// The least p > 0 and the greatest below 0 at which K + p G is singular.
std::array<double, 2> critical(const MatrixXd& K, const MatrixXd& G) {
  const Eigen::VectorXd values = symmetric_eigenvalues(-G, K);
  return {1 / values.maxCoeff(), 1 / values.minCoeff()};
}

MatrixXd matrix_of(const ReducedBody& body, int load) {
  for (std::size_t k = 0; k < body.geometric->loads.size(); ++k)
    if (body.geometric->loads[k] == load) return body.geometric->stiffness[k];
  ADD_FAILURE() << "no load " << load;
  return MatrixXd::Zero(body.modes, body.modes);
}

// P = 4.0126 √(EI GJ)/L² (Prandtl 1899).
TEST(LateralBuckling, OfAReducedCantileverUnderAForceAtItsTip) {
  const Strip strip;
  const ReducedBody body = strip.reduce(true);
  const double exact = 4.0126 * strip.stiffness() / (strip.length * strip.length);
  for (const double p : critical(body.stiffness, matrix_of(body, Loads::boundary)))
    EXPECT_NEAR(std::abs(p), exact, 5e-3 * exact) << p;
}

// q L = 12.85 √(EI GJ)/L² (Timoshenko, Gere 1961, 6.3): a field of gravity, or of acceleration.
TEST(LateralBuckling, OfAReducedCantileverUnderItsWeight) {
  const Strip strip;
  const ReducedBody body = strip.reduce(false);
  MatrixXd G = MatrixXd::Zero(body.modes, body.modes);
  for (int k = 0; k < 3; ++k) G += strip.axes(k, 2) * matrix_of(body, Loads::acceleration + k);
  const double exact = 12.85 * strip.stiffness() / (strip.length * strip.length),
               mass = steel().density * strip.section.area * strip.length;
  for (const double a : critical(body.stiffness, G))
    EXPECT_NEAR(mass * std::abs(a), exact, 5e-3 * exact) << a;
}

// A force at a small height a above the axis: P falls by 1.0254 a/L √(EI/GJ) of itself. The twist's equation
// is stationary for ½∫ GJ φ'² − (P²/EI) s² φ² ds − ½ P a φ², the last at the tip, where s = 0: to the first
// order dP/P = −½ a φ² EI/(P ∫ s² φ² ds) at the tip, with φ = 1 − b² x⁴/12 + b⁴ x⁸/672 − …, b = 4.0126, x =
// s/L. (Timoshenko, Gere 1961, 6.3, round the factor to 1.)
TEST(LateralBuckling, OfACantileverUnderAForceAboveItsAxis) {
  Strip strip;
  strip.eccentricity = 0.04;
  const ReducedBody body = strip.reduce(true);
  const auto [up, down] = critical(body.stiffness, matrix_of(body, Loads::boundary));
  const double G = 1 / (2 * (1 + steel().poisson)),
               part = strip.eccentricity / strip.length * std::sqrt(strip.section.Iz / (G * strip.section.J));
  EXPECT_GT(part, 0.01);
  EXPECT_NEAR((up + down) / (up - down), 1.0254 * part, 0.01 * part);  // a force downwards is worse
}

}  // namespace
}  // namespace mimbre::test::lateral_buckling_test
