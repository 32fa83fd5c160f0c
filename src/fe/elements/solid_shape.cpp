#include "fe/elements/solid_shape.h"

#include <array>
#include <stdexcept>
#include <unsupported/Eigen/AutoDiff>

// Written once over the scalar: with dual numbers the same text gives the derivatives. Speed does not matter
// here, the elements keep tables of what they need.

namespace mimbre::fe {
namespace {

using Corner = std::array<double, 3>;
using Edge = std::array<int, 2>;

constexpr std::array<Corner, 4> kTetCorners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr std::array<Edge, 6> kTetEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
constexpr std::array<Corner, 8> kHexCorners{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};
constexpr std::array<Edge, 12> kHexEdges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};
constexpr std::array<Corner, 6> kWedgeCorners{
    {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}}};
constexpr std::array<Edge, 9> kWedgeEdges{
    {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};

constexpr std::array<Corner, 5> kPyramidCorners{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}}};
constexpr std::array<Edge, 8> kPyramidEdges{{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}};

template <class T>
using Point = std::array<T, 3>;
template <class T>
using Values = std::array<T, kMaxSolidNodes>;

template <class T>
void tetrahedron(const Point<T>& x, bool quadratic, Values<T>& n) {
  const std::array<T, 4> l{1.0 - x[0] - x[1] - x[2], x[0], x[1], x[2]};
  for (int i = 0; i < 4; ++i) n[i] = quadratic ? T(l[i] * (2.0 * l[i] - 1.0)) : l[i];
  if (!quadratic) return;
  for (int e = 0; e < 6; ++e) n[4 + e] = 4.0 * l[kTetEdges[e][0]] * l[kTetEdges[e][1]];
}

template <class T>
void brick(const Point<T>& x, bool quadratic, Values<T>& n) {
  for (int i = 0; i < 8; ++i) {
    const Corner& c = kHexCorners[i];
    const T product = (1.0 + c[0] * x[0]) * (1.0 + c[1] * x[1]) * (1.0 + c[2] * x[2]) / 8.0;
    n[i] = quadratic ? T(product * (c[0] * x[0] + c[1] * x[1] + c[2] * x[2] - 2.0)) : product;
  }
  if (!quadratic) return;
  for (int e = 0; e < 12; ++e) {
    n[8 + e] = T(0.25);
    for (int k = 0; k < 3; ++k) {
      const double c = (kHexCorners[kHexEdges[e][0]][k] + kHexCorners[kHexEdges[e][1]][k]) / 2;
      n[8 + e] = c == 0 ? T(n[8 + e] * (1.0 - x[k] * x[k])) : T(n[8 + e] * (1.0 + c * x[k]));
    }
  }
}

template <class T>
void wedge(const Point<T>& x, bool quadratic, Values<T>& n) {
  const std::array<T, 3> l{1.0 - x[0] - x[1], x[0], x[1]};
  for (int i = 0; i < 6; ++i) {
    const T along = 0.5 * (1.0 + kWedgeCorners[i][2] * x[2]);
    n[i] = l[i % 3] * along;
    if (quadratic) n[i] = T(n[i] * (2.0 * l[i % 3] + 2.0 * along - 3.0));
  }
  if (!quadratic) return;
  for (int e = 0; e < 9; ++e) {
    const int i = kWedgeEdges[e][0];
    const int j = kWedgeEdges[e][1];
    n[6 + e] = e < 6 ? T(4.0 * l[i % 3] * l[j % 3] * 0.5 * (1.0 + kWedgeCorners[i][2] * x[2]))
                     : T(l[i] * (1.0 - x[2] * x[2]));
  }
}

/// Rational functions (Bedrosian 1992): on the faces those of the triangle and the quadrilateral. At the apex
/// they have values but no derivatives.
template <class T>
void pyramid(const Point<T>& x, bool quadratic, Values<T>& n) {
  const T rest = 1.0 - x[2];
  const bool apex = !(rest > 0.0 || rest < 0.0);
  const T inverse = apex ? T(0.0 * rest) : T(1.0 / rest);
  for (int i = 0; i < 4; ++i) {
    const Corner& c = kPyramidCorners[i];
    const T linear =
        ((1.0 + c[0] * x[0]) * (1.0 + c[1] * x[1]) - x[2] + c[0] * c[1] * x[0] * x[1] * x[2] * inverse) / 4.0;
    n[i] = quadratic ? T(linear * (c[0] * x[0] + c[1] * x[1] - 1.0)) : linear;
  }
  n[4] = quadratic ? T(x[2] * (2.0 * x[2] - 1.0)) : x[2];
  if (!quadratic) return;
  for (int e = 0; e < 4; ++e) {
    const Corner &a = kPyramidCorners[kPyramidEdges[e][0]], &b = kPyramidCorners[kPyramidEdges[e][1]];
    const int along = a[1] == b[1] ? 0 : 1, across = 1 - along;
    n[5 + e] = (rest + x[along]) * (rest - x[along]) * (rest + a[across] * x[across]) * inverse / 2.0;
    n[9 + e] = x[2] * (rest + a[0] * x[0]) * (rest + a[1] * x[1]) * inverse;
  }
}

template <class T>
Values<T> evaluate(ElementType type, const Point<T>& x) {
  Values<T> n;
  switch (type) {
    case ElementType::tet4:
      tetrahedron(x, false, n);
      break;
    case ElementType::tet10:
      tetrahedron(x, true, n);
      break;
    case ElementType::hex8:
      brick(x, false, n);
      break;
    case ElementType::hex20:
      brick(x, true, n);
      break;
    case ElementType::wedge6:
      wedge(x, false, n);
      break;
    case ElementType::wedge15:
      wedge(x, true, n);
      break;
    case ElementType::pyramid5:
      pyramid(x, false, n);
      break;
    case ElementType::pyramid13:
      pyramid(x, true, n);
      break;
    default:
      throw std::logic_error("shells have shape functions of their own");
  }
  return n;
}

template <std::size_t Corners, std::size_t Edges>
NodePositions positions(const std::array<Corner, Corners>& corners, const std::array<Edge, Edges>& edges,
                        bool quadratic) {
  NodePositions x(3, quadratic ? Corners + Edges : Corners);
  for (std::size_t i = 0; i < Corners; ++i) x.col(i) = Eigen::Vector3d::Map(corners[i].data());
  for (std::size_t e = 0; quadratic && e < Edges; ++e)
    x.col(Corners + e) = 0.5 * (x.col(edges[e][0]) + x.col(edges[e][1]));
  return x;
}

}  // namespace

NodePositions reference_nodes(ElementType type) {
  switch (type) {
    case ElementType::tet4:
    case ElementType::tet10:
      return positions(kTetCorners, kTetEdges, type == ElementType::tet10);
    case ElementType::hex8:
    case ElementType::hex20:
      return positions(kHexCorners, kHexEdges, type == ElementType::hex20);
    case ElementType::wedge6:
    case ElementType::wedge15:
      return positions(kWedgeCorners, kWedgeEdges, type == ElementType::wedge15);
    case ElementType::pyramid5:
    case ElementType::pyramid13:
      return positions(kPyramidCorners, kPyramidEdges, type == ElementType::pyramid13);
    default:
      throw std::logic_error("shells have shape functions of their own");
  }
}

ShapeValues shape_values(ElementType type, const Eigen::Vector3d& at) {
  const Values<double> n = evaluate<double>(type, {at.x(), at.y(), at.z()});
  return ShapeValues::Map(n.data(), node_count(type));
}

ShapeGradients shape_gradients(ElementType type, const Eigen::Vector3d& at) {
  using Dual = Eigen::AutoDiffScalar<Eigen::Vector3d>;
  const Values<Dual> n = evaluate<Dual>(type, {Dual(at.x(), 3, 0), Dual(at.y(), 3, 1), Dual(at.z(), 3, 2)});
  ShapeGradients gradients(3, node_count(type));
  for (int i = 0; i < node_count(type); ++i) gradients.col(i) = n[i].derivatives();
  return gradients;
}

}  // namespace mimbre::fe
