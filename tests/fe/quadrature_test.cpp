#include "fe/elements/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fe/solid_meshes.h"

namespace mimbre::test::quadrature_test {
namespace {

double factorial(int n) { return std::tgamma(n + 1.0); }

double on_line(int power) { return power % 2 == 1 ? 0 : 2.0 / (power + 1); }

/// Integral of x^a y^b z^c over the reference element.
double exact(ElementType type, int a, int b, int c) {
  switch (corners_only(type)) {
    case ElementType::tet4:
      return factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
    case ElementType::wedge6:
      return factorial(a) * factorial(b) / factorial(a + b + 2) * on_line(c);
    case ElementType::pyramid5:
      return on_line(a) * on_line(b) * factorial(c) * factorial(a + b + 2) / factorial(a + b + c + 3);
    default:
      return on_line(a) * on_line(b) * on_line(c);
  }
}

/// Up to total degree `degree`; bricks and wedges have more in single directions.
void expect_exact(ElementType type, const fe::Quadrature& rule, int degree) {
  for (int a = 0; a <= degree; ++a)
    for (int b = 0; a + b <= degree; ++b)
      for (int c = 0; a + b + c <= degree; ++c) {
        double sum = 0;
        for (const fe::IntegrationPoint& p : rule)
          sum += p.weight * std::pow(p.at.x(), a) * std::pow(p.at.y(), b) * std::pow(p.at.z(), c);
        EXPECT_NEAR(sum, exact(type, a, b, c), 1e-14)
            << type_name(type) << " x^" << a << " y^" << b << " z^" << c;
      }
}

TEST(Quadrature, IsExactForPolynomialsUpToItsDegree) {
  const auto check = [](ElementType type, int stiffness, int mass, int stress) {
    expect_exact(type, fe::stiffness_quadrature(type), stiffness);
    expect_exact(type, fe::mass_quadrature(type), mass);
    expect_exact(type, fe::stress_points(type), stress);
  };
  check(ElementType::tet4, 1, 2, 1);
  check(ElementType::tet10, 2, 5, 2);
  check(ElementType::hex8, 3, 5, 3);
  check(ElementType::hex20, 5, 5, 3);
  check(ElementType::wedge6, 1, 4, 1);
  check(ElementType::wedge15, 2, 4, 2);
  check(ElementType::pyramid5, 3, 5, 1);
  check(ElementType::pyramid13, 5, 5, 2);
}

TEST(SolidShape, FunctionsAreOneAtTheirNodeAndReproduceCompletePolynomials) {
  const Eigen::Vector3d at(0.21, 0.34, 0.17);
  for (ElementType type : kSolidTypes) {
    const fe::NodePositions nodes = fe::reference_nodes(type);
    for (Eigen::Index n = 0; n < nodes.cols(); ++n)
      EXPECT_LT((fe::shape_values(type, nodes.col(n)) - Eigen::VectorXd::Unit(nodes.cols(), n)).norm(),
                1e-14);
    const fe::ShapeValues values = fe::shape_values(type, at);
    const int degree = type == corners_only(type) ? 1 : 2;
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b)
        for (int c = 0; a + b + c <= degree; ++c) {
          const auto f = [&](const Eigen::Vector3d& x) {
            return std::pow(x.x(), a) * std::pow(x.y(), b) * std::pow(x.z(), c);
          };
          double sum = 0;
          for (Eigen::Index n = 0; n < nodes.cols(); ++n) sum += values[n] * f(nodes.col(n));
          EXPECT_NEAR(sum, f(at), 1e-14) << type_name(type);
        }
  }
}

TEST(SolidShape, GradientsAreTheDerivatives) {
  const Eigen::Vector3d at(0.21, 0.34, 0.17);
  constexpr double h = 1e-5;
  for (ElementType type : kSolidTypes) {
    const fe::ShapeGradients gradients = fe::shape_gradients(type, at);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
      const Eigen::VectorXd difference =
          (fe::shape_values(type, at + step) - fe::shape_values(type, at - step)) / (2 * h);
      EXPECT_LT((gradients.row(k).transpose() - difference).norm(), 1e-9) << type_name(type);
    }
  }
}

}  // namespace
}  // namespace mimbre::test::quadrature_test
