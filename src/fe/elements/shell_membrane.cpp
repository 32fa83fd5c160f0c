#include "fe/elements/shell_membrane.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mimbre::fe {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Triangle = Eigen::Matrix<double, 2, 3>;

/// What constant stresses see (Felippa's α_b = 3/2): twice the nodal forces of unit stresses.
Eigen::Matrix<double, 9, 3> lumping(const Triangle& nodes) {
  constexpr double kAlpha = 1.5;
  const auto x = [&](int i, int j) { return nodes(0, i % 3) - nodes(0, j % 3); };
  const auto y = [&](int i, int j) { return nodes(1, i % 3) - nodes(1, j % 3); };
  Eigen::Matrix<double, 9, 3> forces;
  for (int i = 0; i < 3; ++i) {
    const int j = i + 1;
    const int k = i + 2;
    forces.row(3 * i) << y(j, k), 0, x(k, j);
    forces.row(3 * i + 1) << 0, x(k, j), y(j, k);
    forces.row(3 * i + 2) << kAlpha / 6 * y(j, k) * (y(i, k) - y(j, i)),
        kAlpha / 6 * x(k, j) * (x(k, i) - x(i, j)), kAlpha / 3 * (x(k, i) * y(i, k) - x(i, j) * y(j, i));
  }
  return forces;
}

double area_of(const Triangle& n) {
  return 0.5 * ((n(0, 1) - n(0, 0)) * (n(1, 2) - n(1, 0)) - (n(0, 2) - n(0, 0)) * (n(1, 1) - n(1, 0)));
}

/// Calls add(triangle, corners, share) for the triangles of the element.
template <class Add>
void for_each_triangle(const PlaneNodes& nodes, const Add& add) {
  const auto part = [&](const std::array<int, 3>& corners, double share) {
    Triangle triangle;
    for (int i = 0; i < 3; ++i) triangle.col(i) = nodes.col(corners[i]);
    add(triangle, corners, share);
  };
  if (nodes.cols() == 3) {
    part({0, 1, 2}, 1);
  } else {
    part({0, 1, 2}, 0.5);
    part({0, 2, 3}, 0.5);
    part({0, 1, 3}, 0.5);
    part({1, 2, 3}, 0.5);
  }
}

/// Stiffness of unit thickness. Corners i, j, k in cyclic order; "side i" runs from i to j.
Matrix9 triangle_stiffness(const Triangle& nodes, const Eigen::Matrix3d& elasticity, double beta0) {
  const auto x = [&](int i, int j) { return nodes(0, i % 3) - nodes(0, j % 3); };
  const auto y = [&](int i, int j) { return nodes(1, i % 3) - nodes(1, j % 3); };
  const double area = area_of(nodes);
  const Eigen::Matrix<double, 9, 3> basic = lumping(nodes);
  Matrix9 stiffness = basic * elasticity * basic.transpose() / (4 * area);

  // Higher part: strains along the three sides (natural strains) of the corners' rotations beyond the mean.
  std::array<double, 3> squared_length;
  for (int i = 0; i < 3; ++i) squared_length[i] = x(i + 1, i) * x(i + 1, i) + y(i + 1, i) * y(i + 1, i);
  Eigen::Matrix3d from_natural;  // Cartesian strains (engineering shear) of natural ones
  for (int i = 0; i < 3; ++i) {
    const int j = i + 1;
    const int k = i + 2;
    from_natural.col(i) << y(j, k) * y(i, k), x(j, k) * x(i, k), y(j, k) * x(k, i) + x(k, j) * y(i, k);
    from_natural.col(i) *= squared_length[i] / (4 * area * area);
  }
  const Eigen::Matrix3d natural = from_natural.transpose() * elasticity * from_natural;

  const Eigen::Matrix3d beta = (Eigen::Matrix3d() << 1, 2, 1, 0, 1, -1, -1, -1, -2).finished();
  std::array<Eigen::Matrix3d, 3> at_corner;  // natural strains · rotations
  for (int c = 0; c < 3; ++c)
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        at_corner[c](row, column) =
            2 * area / 3 / squared_length[row] * beta((row - c + 3) % 3, (column - c + 3) % 3);
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  for (int c = 0; c < 3; ++c) {
    const Eigen::Matrix3d strain = 0.5 * (at_corner[c] + at_corner[(c + 1) % 3]);
    rotations += strain.transpose() * natural * strain;
  }
  Eigen::Matrix<double, 3, 9> deviation = Eigen::Matrix<double, 3, 9>::Zero();
  for (int i = 0; i < 3; ++i) {
    deviation.col(3 * i).setConstant(x(i + 2, i + 1) / (4 * area));
    deviation.col(3 * i + 1).setConstant(y(i + 2, i + 1) / (4 * area));
    deviation(i, 3 * i + 2) += 1;
  }
  stiffness += 0.75 * beta0 * area * deviation.transpose() * rotations * deviation;
  return stiffness;
}

/// Felippa's β₀, the share of the higher part with which the element bends in its plane as it should (2003,
/// of any sheet): the same in all axes, so that it does not go by where the corners' numbering begins.
/// Isotropic: ½ (1 − 4 ν²). For ν of nearly ½ and for strong fibres some stiffness must be left.
double share_of_bending(const Eigen::Matrix3d& elastic) {
  constexpr double kLeast = 0.01, kRoundOff = 1e-12;
  const double e11 = elastic(0, 0), e12 = elastic(0, 1), e13 = elastic(0, 2), e22 = elastic(1, 1),
               e23 = elastic(1, 2), e33 = elastic(2, 2);
  const double beside =
      std::max({std::abs(e11 - e22), std::abs(e11 - e12 - 2 * e33), std::abs(e13), std::abs(e23)});
  if (beside <= kRoundOff * e11) {
    const double poisson = e12 / std::sqrt(e11 * e22);
    return std::max(0.5 * (1 - 4 * poisson * poisson), kLeast);
  }
  const double w = -6 * e12 * e12 * e12 + 5 * e11 * e11 * e22 - 5 * e12 * e12 * e22 -
                   e22 * (75 * e13 * e13 + 14 * e13 * e23 + 3 * e23 * e23) +
                   2 * e12 * (7 * e13 * e13 + 46 * e13 * e23 + 7 * e23 * e23) -
                   e11 * (5 * e12 * e12 + 3 * e13 * e13 - 6 * e12 * e22 - 5 * e22 * e22 + 14 * e13 * e23 +
                          75 * e23 * e23) +
                   (3 * e11 * e11 + 82 * e11 * e22 + 3 * e22 * e22) * e33 -
                   4 * (6 * e12 * e12 + 5 * e13 * e13 - 6 * e13 * e23 + 5 * e23 * e23) * e33 +
                   4 * (5 * e11 - 6 * e12 + 5 * e22) * e33 * e33;
  return std::max(256 * elastic.determinant() / w - 1.5, kLeast);
}

}  // namespace

MembraneMatrix membrane_stiffness(const PlaneNodes& nodes, double young, double poisson, double thickness) {
  Eigen::Matrix3d elastic;
  elastic << 1, poisson, 0, poisson, 1, 0, 0, 0, (1 - poisson) / 2;
  return membrane_stiffness(nodes, Eigen::Matrix3d(young / (1 - poisson * poisson) * elastic), thickness);
}

MembraneMatrix membrane_stiffness(const PlaneNodes& nodes, const Eigen::Matrix3d& elastic, double thickness) {
  const Eigen::Matrix3d elasticity = thickness * elastic;
  const double beta0 = share_of_bending(elastic);
  const int count = static_cast<int>(nodes.cols());
  MembraneMatrix stiffness = MembraneMatrix::Zero(3 * count, 3 * count);
  for_each_triangle(nodes, [&](const Triangle& triangle, const std::array<int, 3>& corners, double share) {
    const Matrix9 part = triangle_stiffness(triangle, elasticity, beta0);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        stiffness.block<3, 3>(3 * corners[i], 3 * corners[j]) += share * part.block<3, 3>(3 * i, 3 * j);
  });
  return 0.5 * (stiffness + stiffness.transpose());
}

Eigen::Matrix<double, 3, Eigen::Dynamic> membrane_strain(const PlaneNodes& nodes) {
  Eigen::Matrix<double, 3, Eigen::Dynamic> strain =
      Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, 3 * nodes.cols());
  double area = 0;
  for_each_triangle(nodes, [&](const Triangle& triangle, const std::array<int, 3>& corners, double share) {
    const Eigen::Matrix<double, 9, 3> basic = lumping(triangle);
    for (int i = 0; i < 3; ++i)
      strain.middleCols<3>(3 * corners[i]) += 0.5 * share * basic.middleRows<3>(3 * i).transpose();
    area += share * area_of(triangle);
  });
  return strain / area;
}

}  // namespace mimbre::fe
