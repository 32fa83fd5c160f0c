#include "reduction/stiffening/second_order.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

#include "fe/elements/beam_element.h"
#include "math/gauss.h"

namespace mimbre::fe {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector3d;

/// An element with the modes' dofs in its axes.
struct Piece {
  ElementGeometry geometry;
  const BeamElement* beam = nullptr;
  ShearRatio shear;
  MatrixXd dofs;  ///< 12 × modes

  Vector3d axis() const { return geometry.axes.col(0); }
  /// dv/ds and dw/ds at xi (rows) by mode: of cubic displacements, by differences that are exact for them.
  MatrixXd slopes(double xi) const {
    const auto at = [&](double x) {
      return MatrixXd(shape_functions(x, geometry.length, shear).bottomRows<2>() * dofs);
    };
    return (8 * (at(xi + 0.25) - at(xi - 0.25)) - (at(xi + 0.5) - at(xi - 0.5))) / (3 * geometry.length);
  }
  RowVectorXd axial_strain() const { return (dofs.row(6) - dofs.row(0)) / geometry.length; }
};

using Products = std::vector<std::array<int, 2>>;

/// Factor of a product in a sum over all ordered pairs.
double multiplicity(const std::array<int, 2>& p) { return p[0] == p[1] ? 1 : 2; }

/// v'_a · v'_b of each product.
RowVectorXd slope_products(const MatrixXd& slopes, const Products& products) {
  RowVectorXd out(static_cast<Eigen::Index>(products.size()));
  for (std::size_t p = 0; p < products.size(); ++p)
    out[static_cast<Eigen::Index>(p)] = slopes.col(products[p][0]).dot(slopes.col(products[p][1]));
  return out;
}

std::vector<Piece> pieces_of(const Mesh& mesh, const MatrixXd& shapes) {
  std::vector<Piece> pieces;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    Piece piece;
    piece.beam = &mesh.elements[e];
    piece.geometry = element_geometry(mesh, e);
    piece.shear = shear_ratio(*piece.beam, piece.geometry.length);
    MatrixXd nodal(12, shapes.cols());
    for (int end = 0; end < 2; ++end)
      nodal.middleRows<6>(6 * end) = shapes.middleRows<6>(6 * piece.beam->nodes[end]);
    piece.dofs = element_transformation(*piece.beam, piece.geometry.axes) * nodal;
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

/// The pairs of modes whose slopes have anything in common.
Products find_products(const std::vector<Piece>& pieces, int modes) {
  MatrixXd sum = MatrixXd::Zero(modes, modes);
  for (const Piece& piece : pieces)
    for (const GaussPoint& g : gauss6) {
      const MatrixXd s = piece.slopes(g.xi);
      sum += g.weight * piece.geometry.length * (s.transpose() * s);
    }
  Products products;
  for (int a = 0; a < modes; ++a)
    for (int b = a; b < modes; ++b)
      if (std::abs(sum(a, b)) > 1e-9 * std::sqrt(sum(a, a) * sum(b, b)) &&
          sum(a, a) > 1e-9 * sum.diagonal().maxCoeff() && sum(b, b) > 1e-9 * sum.diagonal().maxCoeff())
        products.push_back({a, b});
  return products;
}

/// ∫ v'ᵀv' ds from `from` to `to` (parts of the element) of each product, times its multiplicity.
RowVectorXd slopes_between(const Piece& piece, double from, double to, const Products& products) {
  RowVectorXd sum = RowVectorXd::Zero(static_cast<Eigen::Index>(products.size()));
  for (const GaussPoint& g : gauss4)
    sum += g.weight * (to - from) * piece.geometry.length *
           slope_products(piece.slopes(from + g.xi * (to - from)), products);
  for (std::size_t p = 0; p < products.size(); ++p)
    sum[static_cast<Eigen::Index>(p)] *= multiplicity(products[p]);
  return sum;
}

/// Second-order turn of a vector that is fixed to a node: ½ φ × (φ × d), φ = Σ y_a φ_a.
Matrix3Xd turned(const Matrix3Xd& rotation, const Vector3d& d, const Products& products) {
  Matrix3Xd out(3, static_cast<Eigen::Index>(products.size()));
  for (std::size_t p = 0; p < products.size(); ++p) {
    const Vector3d a = rotation.col(products[p][0]), b = rotation.col(products[p][1]);
    out.col(static_cast<Eigen::Index>(p)) =
        0.25 * multiplicity(products[p]) * (a.cross(b.cross(d)) + b.cross(a.cross(d)));
  }
  return out;
}

/// Displacements that go with the products: of the nodes, and of the beginning (the end nearer to the clamped
/// node) of each element's axis.
struct Shortening {
  std::vector<Matrix3Xd> nodes, starts;
  std::vector<int> near;  ///< which end of the element is the beginning
};

Shortening shortening(const Mesh& mesh, const std::vector<Piece>& pieces, const MatrixXd& shapes,
                      const std::vector<int>& clamped, const Products& products) {
  const Eigen::Index count = static_cast<Eigen::Index>(products.size());
  Shortening s;
  s.nodes.assign(static_cast<std::size_t>(mesh.nodes.cols()), Matrix3Xd::Zero(3, count));
  s.starts.assign(pieces.size(), Matrix3Xd::Zero(3, count));
  s.near.assign(pieces.size(), -1);
  std::vector<bool> reached(static_cast<std::size_t>(mesh.nodes.cols()), false);
  for (int node : clamped) reached[static_cast<std::size_t>(node)] = true;
  const auto rotation = [&](int node) { return Matrix3Xd(shapes.middleRows<3>(6 * node + 3)); };
  for (bool more = true; more;) {
    more = false;
    for (std::size_t e = 0; e < pieces.size(); ++e) {
      if (s.near[e] >= 0) continue;
      const auto& ends = pieces[e].beam->nodes;
      const bool first = reached[static_cast<std::size_t>(ends[0])],
                 second = reached[static_cast<std::size_t>(ends[1])];
      if (!first && !second) continue;
      if (first && second)
        throw std::invalid_argument(
            "foreshortening needs bars that form a tree held at one node; here they form a loop");
      const int near = first ? 0 : 1, far = 1 - near;
      const auto a = static_cast<std::size_t>(ends[near]), b = static_cast<std::size_t>(ends[far]);
      s.near[e] = near;
      s.starts[e] = s.nodes[a] + turned(rotation(ends[near]), pieces[e].beam->offsets[near], products);
      const Vector3d along = (near == 0 ? 1 : -1) * pieces[e].axis();
      s.nodes[b] = s.starts[e] - 0.5 * along * slopes_between(pieces[e], 0, 1, products) -
                   turned(rotation(ends[far]), pieces[e].beam->offsets[far], products);
      reached[b] = true;
      more = true;
    }
  }
  return s;
}

/// Integrals (3.9)–(3.11) of the extended shapes; the sections' polar inertia as in the linear ones.
void extend_integrals(const std::vector<Piece>& pieces, const Shortening& s, const Products& products,
                      MassMatrix mass_matrix, const ReducedBody& body, SecondOrder& out) {
  const std::span<const GaussPoint> points =
      mass_matrix == MassMatrix::lumped ? std::span<const GaussPoint>(trapezoid2) : gauss6;
  const Eigen::Index n = body.modes, count = static_cast<Eigen::Index>(products.size()), all = n + count;
  out.S.setZero(3, all);
  for (int i = 0; i < 3; ++i) {
    out.S_position[i].setZero(3, all);
    for (int j = 0; j < 3; ++j) out.S_modes[i][j].setZero(all, all);
  }
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const Piece& piece = pieces[e];
    const double mass = piece.beam->material.density * piece.beam->section.area * piece.geometry.length;
    for (const GaussPoint& g : points) {
      Matrix3Xd X(3, all);
      X.leftCols(n) =
          piece.geometry.axes * shape_functions(g.xi, piece.geometry.length, piece.shear) * piece.dofs;
      X.rightCols(count) = s.starts[e];
      const double near = s.near[e];
      // From the beginning to xi, along the way that leads there.
      X.rightCols(count) -= 0.5 * piece.axis() * slopes_between(piece, near, g.xi, products);
      const Vector3d position = piece.geometry.start + g.xi * piece.geometry.length * piece.axis();
      const double dm = g.weight * mass;
      out.S += dm * X;
      for (int i = 0; i < 3; ++i) {
        out.S_position[i] += dm * position[i] * X;
        for (int j = 0; j < 3; ++j) out.S_modes[i][j].noalias() += dm * X.row(i).transpose() * X.row(j);
      }
    }
  }
  out.mass_matrix = out.S_modes[0][0] + out.S_modes[1][1] + out.S_modes[2][2];
  // The modes' own blocks as they are, with the sections' inertia.
  out.S.leftCols(n) = body.S;
  for (int i = 0; i < 3; ++i) {
    out.S_position[i].leftCols(n) = body.S_position[i];
    for (int j = 0; j < 3; ++j) out.S_modes[i][j].topLeftCorner(n, n) = body.S_modes[i][j];
  }
  out.mass_matrix.topLeftCorner(n, n) = body.mass_matrix;
}

/// Blocks of the linear body with columns of zeros for the products.
void extend_linear(const ReducedBody& body, SecondOrder& out) {
  const Eigen::Index n = body.modes, all = n + static_cast<Eigen::Index>(out.products.size());
  const auto extended = [&](const auto& block) {
    MatrixXd e = MatrixXd::Zero(block.rows(), all);
    e.leftCols(n) = block;
    return e;
  };
  out.S = extended(body.S);
  for (int i = 0; i < 3; ++i) {
    out.S_position[i] = extended(body.S_position[i]);
    for (int j = 0; j < 3; ++j) {
      out.S_modes[i][j].setZero(all, all);
      out.S_modes[i][j].topLeftCorner(n, n) = body.S_modes[i][j];
    }
  }
  out.mass_matrix.setZero(all, all);
  out.mass_matrix.topLeftCorner(n, n) = body.mass_matrix;
  for (const BodyFrame& frame : body.frames) out.frame_shapes.push_back(extended(frame.X));
  out.node_shapes = extended(body.node_shapes);
  if (body.mesh_inertia) out.mesh_shapes = extended(body.mesh_inertia->shapes);
}

void add_foreshortening(const Mesh& mesh, const std::vector<Piece>& pieces, const MatrixXd& shapes,
                        const ReductionOptions& options, const ReducedBody& body, SecondOrder& out) {
  const Shortening s = shortening(mesh, pieces, shapes, options.clamped_nodes, out.products);
  extend_integrals(pieces, s, out.products, options.mass_matrix, body, out);
  const Eigen::Index count = static_cast<Eigen::Index>(out.products.size());
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node) {
    const Matrix3Xd& h = s.nodes[static_cast<std::size_t>(node)];
    out.node_shapes.block(3 * node, body.modes, 3, count) = h;
    if (out.mesh_shapes.size() > 0) out.mesh_shapes.block(6 * node, body.modes, 3, count) = h;
    // Of several nodes at one place the one that moves as the frame does, up to round-off.
    const auto X = shapes.middleRows<3>(6 * node);
    for (std::size_t f = 0; f < body.frames.size(); ++f)
      if ((body.frames[f].position - mesh.nodes.col(node)).norm() == 0 &&
          (body.frames[f].X - X).norm() <= 1e-9 * X.norm())
        out.frame_shapes[f].rightCols(count) = h;
  }
}

void add_nonlinear_stiffness(const std::vector<Piece>& pieces, const ReductionOptions& options, int modes,
                             SecondOrder& out) {
  const Eigen::Index n = modes, count = static_cast<Eigen::Index>(out.products.size());
  MatrixXd third = MatrixXd::Zero(n, count), fourth = MatrixXd::Zero(count, count);
  for (const Piece& piece : pieces) {
    const double EA = piece.beam->material.young * piece.beam->section.area;
    for (const GaussPoint& g : gauss6) {
      RowVectorXd v = slope_products(piece.slopes(g.xi), out.products);
      for (std::size_t p = 0; p < out.products.size(); ++p)
        v[static_cast<Eigen::Index>(p)] *= multiplicity(out.products[p]);
      const double weight = g.weight * piece.geometry.length * EA;
      // ½∫EA u'v'ᵀv' = Σ y_k third_kp p, ⅛∫EA(v'ᵀv')² = ½ pᵀ fourth p
      third += 0.5 * weight * piece.axial_strain().transpose() * v;
      fourth += 0.25 * weight * v.transpose() * v;
    }
  }
  out.stiffness.topRightCorner(n, count) = third;  // acts on the products: stiffnessᵀ η
  if (!options.published_force) out.stiffness.bottomLeftCorner(count, n) = third.transpose();
  if (options.stiffening == Stiffening::nonlinear_stiffness_2)
    out.stiffness.bottomRightCorner(count, count) = fourth;
}

}  // namespace

void add_second_order(const Mesh& mesh, const ReductionOptions& options, ReducedBody& body) {
  if (options.stiffening == Stiffening::linear || options.stiffening == Stiffening::geometric_stiffness)
    return;
  const MatrixXd shapes = body.mesh_inertia->shapes;
  const std::vector<Piece> pieces = pieces_of(mesh, shapes);
  SecondOrder out;
  out.products = find_products(pieces, body.modes);
  extend_linear(body, out);
  const Eigen::Index all = out.mass_matrix.rows();
  out.stiffness.setZero(all, all);
  out.stiffness.topLeftCorner(body.modes, body.modes) = body.stiffness;
  if (options.stiffening == Stiffening::foreshortening)
    add_foreshortening(mesh, pieces, shapes, options, body, out);
  else
    add_nonlinear_stiffness(pieces, options, body.modes, out);
  body.second_order = std::move(out);
}

}  // namespace mimbre::fe
