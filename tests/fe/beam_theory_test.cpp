#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "fe/elements/beam_element.h"
#include "fe/elements/shear_coefficient.h"
#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/beam_reduction.h"
#include "support/dense.h"

/// Bars with shear and rotary inertia against closed forms.
namespace mimbre::test::beam_theory_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using fe::BeamTheory;
using std::numbers::pi;

/// A stocky bar whose two planes differ in everything.
struct Bar {
  double length = 0.6;
  fe::Section section = [] {
    fe::Section s = rectangle(0.08, 0.14);
    s.shear_y = 0.8 * s.area;
    s.shear_z = 0.65 * s.area;
    return s;
  }();

  fe::Mesh mesh(BeamTheory theory, int elements) const {
    fe::Mesh mesh = straight_beam(length, elements, section);
    for (fe::BeamElement& element : mesh.elements) element.theory = theory;
    return mesh;
  }
};

/// Bending in one plane: dofs of deflection and rotation, EI, kGA, and inertia per length.
struct Plane {
  int deflection, rotation;
  double EI, kGA, mass, rotary;
};

std::array<Plane, 2> planes(const Bar& bar) {
  const fe::Material m = steel();
  const fe::Section& s = bar.section;
  const double G = m.young / (2 * (1 + m.poisson)), mass = m.density * s.area;
  return {{{1, 5, m.young * s.Iz, G * s.shear_y, mass, m.density * s.Iz},
           {2, 4, m.young * s.Iy, G * s.shear_z, mass, m.density * s.Iy}}};
}

/// All dofs but those of the plane, and the ones that supports hold: of both ends, or of the root.
std::vector<int> held(const fe::Mesh& mesh, const Plane& plane, const std::vector<int>& at_root,
                      const std::vector<int>& at_tip) {
  std::vector<int> fixed;
  for (int node = 0; node < mesh.nodes.cols(); ++node)
    for (int k = 0; k < 6; ++k)
      if (k != plane.deflection && k != plane.rotation) fixed.push_back(6 * node + k);
  fixed.insert(fixed.end(), at_root.begin(), at_root.end());
  for (const int k : at_tip) fixed.push_back(6 + k);
  return fixed;
}

/// The rows and columns that are not held.
MatrixXd left(const MatrixXd& matrix, const std::vector<int>& fixed) {
  std::vector<int> kept;
  for (int k = 0; k < matrix.rows(); ++k)
    if (std::find(fixed.begin(), fixed.end(), k) == fixed.end()) kept.push_back(k);
  return matrix(kept, kept);
}

TEST(BeamTheory, ATipLoadBendsAndShears) {
  const Bar bar;
  const double P = 1000, L = bar.length;
  for (const int elements : {1, 3})
    for (const Plane& plane : planes(bar)) {
      const fe::Matrices m = fe::assemble(bar.mesh(BeamTheory::timoshenko, elements));
      VectorXd load = VectorXd::Zero(m.stiffness.rows());
      load[6 + plane.deflection] = P;
      const Eigen::Index n = load.size() - 6;
      const VectorXd u = mimbre::solve(MatrixXd(m.stiffness).bottomRightCorner(n, n), load.tail(n));
      const double bent = P * L * L * L / (3 * plane.EI), sheared = P * L / plane.kGA;
      EXPECT_GT(sheared, 0.01 * bent);
      EXPECT_NEAR(u[plane.deflection], bent + sheared, 1e-9 * bent) << elements;
      // θy = −w': the section turns as without shear.
      EXPECT_NEAR(std::abs(u[plane.rotation]), P * L * L / (2 * plane.EI), 1e-9);
    }
}

/// ω of a wave sin kx: (kGA k² − ρA ω²)(EI k² + kGA − ρI ω²) = (kGA k)² (Timoshenko 1921), the lower root.
double timoshenko_wave(const Plane& p, double k) {
  const double a = p.mass * p.rotary, b = p.mass * (p.EI * k * k + p.kGA) + p.rotary * p.kGA * k * k,
               c = p.kGA * p.EI * k * k * k * k;
  return std::sqrt((b - std::sqrt(b * b - 4 * a * c)) / (2 * a));
}

double rayleigh_wave(const Plane& p, double k) {
  return k * k * std::sqrt(p.EI / (p.mass + p.rotary * k * k));
}

TEST(BeamTheory, AStockySimplySupportedBeamHasTheFrequenciesOfTheory) {
  const Bar bar;
  for (const Plane& plane : planes(bar))
    for (const auto& [theory, wave] : {std::pair(BeamTheory::timoshenko, &timoshenko_wave),
                                       std::pair(BeamTheory::rayleigh, &rayleigh_wave)}) {
      const fe::Mesh mesh = bar.mesh(theory, 120);
      const VectorXd found =
          fe::eigenfrequencies_fixed_dofs(mesh, held(mesh, plane, {plane.deflection}, {plane.deflection}), 4);
      for (int n = 1; n <= 4; ++n) {
        const double k = n * pi / bar.length, expected = wave(plane, k);
        EXPECT_NEAR(found[n - 1], expected, 5e-4 * expected) << n;
        EXPECT_LT(expected, 0.995 * k * k * std::sqrt(plane.EI / plane.mass)) << n;
      }
    }
}

double root_between(const std::function<double(double)>& f, double low, double high) {
  const double sign = f(low);
  for (int k = 0; k < 200; ++k) {
    const double middle = 0.5 * (low + high);
    (sign * f(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The `number` lowest positive roots.
std::vector<double> roots(const std::function<double(double)>& f, double step, int number) {
  std::vector<double> found;
  for (double low = step; static_cast<int>(found.size()) < number; low += step)
    if (f(low) * f(low + step) < 0) found.push_back(root_between(f, low, low + step));
  return found;
}

/// T. C. Huang, The effect of rotatory inertia and of shear deformation on the frequency and normal mode
/// equations of uniform beams, Journal of Applied Mechanics 28 (1961) 579–584: clamped and free.
double huang_cantilever(const Plane& p, double length, double omega) {
  const double L2 = length * length, r2 = p.rotary / (p.mass * L2), s2 = p.EI / (p.kGA * L2),
               b2 = p.mass * L2 * L2 * omega * omega / p.EI, b = std::sqrt(b2);
  const double root = std::sqrt((r2 - s2) * (r2 - s2) + 4 / b2), alpha = std::sqrt((root - r2 - s2) / 2),
               beta = std::sqrt((root + r2 + s2) / 2);
  return 2 + (b2 * (r2 - s2) * (r2 - s2) + 2) * std::cosh(b * alpha) * std::cos(b * beta) -
         b * (r2 + s2) / std::sqrt(1 - b2 * r2 * s2) * std::sinh(b * alpha) * std::sin(b * beta);
}

TEST(BeamTheory, AStockyCantileverHasTheFrequenciesOfTheory) {
  const Bar bar;
  for (const Plane& plane : planes(bar)) {
    const fe::Mesh mesh = bar.mesh(BeamTheory::timoshenko, 60);
    const VectorXd found =
        fe::eigenfrequencies_fixed_dofs(mesh, held(mesh, plane, {plane.deflection, plane.rotation}, {}), 2);
    const std::vector<double> expected =
        roots([&](double w) { return huang_cantilever(plane, bar.length, w); }, 10, 2);
    for (int n = 0; n < 2; ++n) EXPECT_NEAR(found[n], expected[n], 2e-4 * expected[n]) << n;
    EXPECT_LT(expected[1], 0.93 * 22.034 * std::sqrt(plane.EI / plane.mass) / (bar.length * bar.length));
  }
}

/// Engesser's formula: the force along the axis does work on the whole slope, shear included.
TEST(BeamTheory, ShearLowersTheBucklingLoad) {
  const Bar bar;
  const int elements = 40;
  const fe::Mesh mesh = bar.mesh(BeamTheory::timoshenko, elements);
  MatrixXd KG = MatrixXd::Zero(6 * mesh.nodes.cols(), 6 * mesh.nodes.cols());
  for (const fe::BeamElement& e : mesh.elements) {
    const double length = bar.length / elements;
    const fe::Matrix12 k =
        fe::element_geometric_stiffness({.axial = {1}}, length, fe::shear_ratio(e, length));
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b)
        KG.block<6, 6>(6 * e.nodes[a], 6 * e.nodes[b]) += k.block<6, 6>(6 * a, 6 * b);
  }
  const MatrixXd K = fe::assemble(mesh).stiffness;
  for (const Plane& plane : planes(bar)) {
    const double euler = pi * pi * plane.EI / (bar.length * bar.length);
    for (const auto& [load, fixed] :
         {std::pair(euler, held(mesh, plane, {plane.deflection}, {plane.deflection})),
          std::pair(euler / 4, held(mesh, plane, {plane.deflection, plane.rotation}, {}))}) {
      const double found = 1 / symmetric_eigenvalues(left(KG, fixed), left(K, fixed)).maxCoeff();
      EXPECT_NEAR(found, load / (1 + load / plane.kGA), 1e-4 * load);
      EXPECT_LT(found, 0.99 * load);
    }
  }
}

TEST(BeamTheory, ShearCoefficientsAreCowpers) {
  EXPECT_NEAR(fe::round_shear(0).at(0.3), 6 * 1.3 / (7 + 6 * 0.3), 1e-12);
  EXPECT_NEAR(fe::round_shear(1).at(0.3), 2 * 1.3 / (4 + 3 * 0.3), 1e-12) << "a thin tube";
  EXPECT_NEAR(fe::round_shear(0.5).at(0.3), 0.62023, 1e-4) << "6·1.3·1.5625/(8.8·1.5625 + 23.6·0.25)";
  EXPECT_NEAR(fe::rectangle_shear().at(0.3), 10 * 1.3 / (12 + 11 * 0.3), 1e-12);
}

/// What turns rigidly has the inertia of the bar as a solid block.
TEST(BeamTheory, RigidMotionHasTheInertiaOfABlock) {
  const Bar bar;
  const fe::Mesh mesh = bar.mesh(BeamTheory::timoshenko, 4);
  const MatrixXd rigid = rigid_motions(mesh), M = rigid.transpose() * fe::assemble(mesh).mass * rigid;
  const double m = steel().density * bar.section.area * bar.length, y = 0.08, z = 0.14, L = bar.length;
  EXPECT_NEAR(M(3, 3), m * (y * y + z * z) / 12, 1e-9 * m);
  EXPECT_NEAR(M(4, 4), m * (z * z / 12 + L * L / 3), 1e-9 * m);
  EXPECT_NEAR(M(5, 5), m * (y * y / 12 + L * L / 3), 1e-9 * m);

  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.dynamic_modes = 5;
  const Eigen::Matrix3d R = some_rotation();
  const ReducedBody body = fe::reduce(moved(mesh, R, {0.3, -0.1, 0.2}), options, {});
  const Eigen::Vector3d c(L / 2, 0, 0), at = R * c + Eigen::Vector3d(0.3, -0.1, 0.2);
  const Eigen::Matrix3d central =
      R * Eigen::Vector3d(m * L * L / 12, m * y * y / 12, m * z * z / 12).asDiagonal() * R.transpose();
  EXPECT_LT((body.second_moment - central - m * at * at.transpose()).norm(), 1e-9 * m);
}

/// A shaft clamped to a hub that turns at Ω whirls at ω, seen from outside: EI u'''' + ρI (ω² − 2Ωω) u'' = ρA
/// ω² u for its complex deflection, u'' = EI u''' + ρI (ω² − 2Ωω) u' = 0 at the tip (Rayleigh's beam with
/// gyroscopic moments). Zero at ω.
double rayleigh_whirl(const Plane& plane, double length, double speed, double omega) {
  const double L2 = length * length, p = plane.rotary * (omega * omega - 2 * speed * omega) * L2 / plane.EI,
               square = plane.mass * omega * omega * L2 * L2 / plane.EI;
  const double root = std::sqrt(p * p / 4 + square), a = std::sqrt(root + p / 2), b = std::sqrt(root - p / 2);
  const double bend_a = -a * a * std::cos(a) - b * b * std::cosh(b),
               bend_b = -a * a * std::sin(a) - a * b * std::sinh(b),
               shear_a = (a * a - p) * a * std::sin(a) - (b * b + p) * b * std::sinh(b),
               shear_b = -(a * a - p) * a * std::cos(a) - (b * b + p) * a * std::cosh(b);
  return bend_a * shear_b - bend_b * shear_a;
}

/// Frequencies in the turning frame: M ÿ + 2Ω (S^yz − S^zy)ᵀ ẏ + (K − Ω² (S^yy + S^zz)) y = 0.
std::vector<double> frequencies_in_the_turning_frame(const ReducedBody& body, double speed) {
  const Eigen::Index n = body.modes;
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -mimbre::solve(
      body.mass_matrix, MatrixXd(body.stiffness - speed * speed * (body.S_modes[1][1] + body.S_modes[2][2])));
  A.bottomRightCorner(n, n) = -mimbre::solve(
      body.mass_matrix, MatrixXd(2 * speed * (body.S_modes[1][2] - body.S_modes[2][1]).transpose()));
  std::vector<double> found;
  for (const auto& value : eigenvalues(A)) {
    EXPECT_LT(std::abs(value.real()), 1e-6 * std::abs(value)) << "damped or unstable";
    if (value.imag() > 0) found.push_back(value.imag());
  }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(BeamTheory, AStockyShaftWhirlsWithGyroscopicMoments) {
  Bar bar;
  bar.section = round_bar(0.12);
  bar.section.shear_y = bar.section.shear_z = bar.section.area;
  const Plane plane = planes(bar)[0];
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.dynamic_modes = 24;
  const ReducedBody body = fe::reduce(bar.mesh(BeamTheory::rayleigh, 20), options, {});
  for (const double speed : {0.0, 800.0, 1500.0}) {
    const std::vector<double> found = frequencies_in_the_turning_frame(body, speed);
    const auto nearest = [&](double wanted) {
      double best = 0;
      for (const double f : found)
        if (std::abs(f - wanted) < std::abs(best - wanted)) best = f;
      return best;
    };
    for (const double direction : {1.0, -1.0}) {
      const std::vector<double> whirl =
          roots([&](double w) { return rayleigh_whirl(plane, bar.length, direction * speed, w); }, 20, 2);
      for (const double omega : whirl) {
        const double wanted = std::abs(omega - direction * speed);
        EXPECT_NEAR(nearest(wanted), wanted, 5e-4 * omega) << omega << " at " << speed;
      }
    }
    // The gyroscopic moments are to be seen: they part the second whirls by more than the tolerance.
    const auto second = [&](double s) {
      return roots([&](double w) { return rayleigh_whirl(plane, bar.length, s, w); }, 20, 2)[1];
    };
    if (speed > 0) {
      EXPECT_GT(second(speed) - second(-speed), 0.01 * second(0));
    }
  }
}

}  // namespace
}  // namespace mimbre::test::beam_theory_test
