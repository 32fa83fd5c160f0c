#include "compile/flexible_data.h"

#include <algorithm>
#include <cmath>

#include "math/once/decompositions.h"
#include "math/rotation.h"

namespace mimbre {

Rows padded(const Eigen::MatrixXd& m, int stride) {
  Rows rows = Rows::Zero(m.rows(), stride);
  rows.matrix().leftCols(m.cols()) = m;
  return rows;
}

namespace {

constexpr double gauss = 0.28867513459481287;  ///< √(1/12): from the middle to a point of Gauss's rule

AncfElement ancf_element(const AncfBeam::Element& e) {
  AncfElement out;
  out.amplitudes = e.amplitudes;
  const double L = out.length = e.length;
  const auto point = [&](double x, double stiffness) {
    AncfElement::Point p;
    p.slope = {6 * (x * x - x) / L, 1 - 4 * x + 3 * x * x, 6 * (x - x * x) / L, 3 * x * x - 2 * x};
    p.curvature = {(12 * x - 6) / (L * L), (6 * x - 4) / L, (6 - 12 * x) / (L * L), (6 * x - 2) / L};
    p.stiffness = stiffness * L;
    return p;
  };
  // As many strains as ways to deform: three points for stretching (Lobatto) and two for bending (Gauss) keep
  // the cubic axis from resisting bending by stretching it (Gerstmayr, Irschik 2008).
  out.axial = {point(0, e.axial / 6), point(0.5, e.axial * 4 / 6), point(1, e.axial / 6)};
  out.bending = {point(0.5 - gauss, e.bending / 2), point(0.5 + gauss, e.bending / 2)};
  return out;
}

AncfSpatialElement cable_element(const AncfBeam::SpatialElement& e) {
  // The points of a planar beam, for the same reason.
  const AncfElement planar = ancf_element({{}, e.length, e.axial, e.bending_y});
  AncfSpatialElement out;
  out.amplitudes = e.amplitudes;
  out.length = e.length;
  for (std::size_t k = 0; k < 5; ++k) {
    const AncfElement::Point& p = k < 3 ? planar.axial[k] : planar.bending[k - 3];
    out.points[k] = {p.slope, p.curvature, {p.stiffness, p.stiffness, p.stiffness, 0, 0, 0}};
  }
  return out;
}

AncfSpatialElement thick_element(const AncfBeam::SpatialElement& e) {
  AncfSpatialElement out;
  out.thick = true;
  out.amplitudes = e.amplitudes;
  const double L = out.length = e.length;
  const auto point = [&](double x, double share, const std::array<double, 6>& stiffness) {
    AncfSpatialElement::Point p;
    p.lower = {(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1), 0};
    p.higher = {(4 * x - 3) / L, (4 - 8 * x) / L, (4 * x - 1) / L, 0};
    for (std::size_t m = 0; m < 6; ++m) p.stiffness[m] = share * L * stiffness[m];
    return p;
  };
  // Again as many strains as ways to deform: 2 · 6 of the line, so that it does not lock in shear, and 3 · 3
  // of the section.
  const std::array<double, 6> line{e.axial, e.shear_y, e.shear_z, e.torsion, e.bending_y, e.bending_z};
  const std::array<double, 6> section{e.axial, e.axial, e.section_shear, 0, 0, 0};
  out.points = {point(0.5 - gauss, 0.5, line), point(0.5 + gauss, 0.5, line), point(0, 1.0 / 6, section),
                point(0.5, 4.0 / 6, section), point(1, 1.0 / 6, section)};
  return out;
}

/// Rigid motion nearest to each mode of the undeformed body: velocity of the origin and angular velocity.
Eigen::MatrixXd mean_motion(const ReducedBody& body) {
  Eigen::Matrix<double, 6, 6> rigid;
  rigid.topLeftCorner<3, 3>() = body.mass * Mat3d::Identity();
  rigid.topRightCorner<3, 3>() = -skew<double>(body.first_moment);
  rigid.bottomLeftCorner<3, 3>() = skew<double>(body.first_moment);
  rigid.bottomRightCorner<3, 3>() = body.second_moment.trace() * Mat3d::Identity() - body.second_moment;
  Eigen::MatrixXd coupling(6, body.modes);
  coupling.topRows<3>() = body.S;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    coupling.row(3 + k) = body.S_position[i].row(j) - body.S_position[j].row(i);
  }
  // A body without inertia about its axis has no mean turn about it.
  return shortest_solution(rigid, coupling);
}

GeometricData geometric_data(const ReducedBody& reduced, int stride) {
  const GeometricStiffness& body = *reduced.geometric;
  const int modes = reduced.modes;
  GeometricData g;
  g.modes = modes;
  g.loads = body.loads;
  g.mean_motion = padded(mean_motion(reduced), stride);
  g.stiffness = Rows::Zero(static_cast<Eigen::Index>(body.loads.size()) * modes, stride);
  for (std::size_t k = 0; k < body.loads.size(); ++k)
    g.stiffness.matrix().block(static_cast<Eigen::Index>(k) * modes, 0, modes, modes) = body.stiffness[k];
  g.inertial = static_cast<int>(std::count_if(body.loads.begin(), body.loads.end(),
                                              [](int l) { return l < GeometricStiffness::boundary; }));
  g.boundary_loads = padded(body.boundary_loads, stride);
  if (body.boundary_loads.rows() > 0)
    g.boundary_compliance =
        padded(shortest_solution(reduced.stiffness, body.boundary_loads.transpose()).transpose(), stride);
  return g;
}

}  // namespace

FlexibleData flexible_data(const ReducedBody& body) {
  FlexibleData f;
  // Blocks of amplitudes and products where there are products.
  const auto& second = body.second_order;
  f.amplitudes = body.modes;
  if (second) f.products = second->products;
  const auto& S = second ? second->S : body.S;
  const auto& S_position = second ? second->S_position : body.S_position;
  const auto& S_modes = second ? second->S_modes : body.S_modes;
  const auto& mass = second ? second->mass_matrix : body.mass_matrix;
  const auto& stiffness = second ? second->stiffness : body.stiffness;
  const int n = f.modes = body.modes + static_cast<int>(f.products.size());
  const int s = f.stride = pad(n);
  f.S = padded(S, s);
  f.S_position = Rows::Zero(9, s);
  for (int i = 0; i < 3; ++i) f.S_position.matrix().middleRows(3 * i, 3).leftCols(n) = S_position[i];
  f.C = Rows::Zero(3, s);
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    f.C.matrix().row(a) = f.S_position.matrix().row(3 * b + c) - f.S_position.matrix().row(3 * c + b);
  }
  f.S_modes = Rows::Zero(s, 9 * s);
  f.coriolis = Rows::Zero(s, 3 * s);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) f.S_modes.matrix().block(0, (3 * i + j) * s, n, n) = S_modes[i][j];
    const int b = (i + 1) % 3, c = (i + 2) % 3;
    f.coriolis.matrix().block(0, i * s, n, n) = S_modes[b][c] - S_modes[c][b];
  }
  f.mass = Rows::Zero(s, s);
  f.stiffness = Rows::Zero(s, s);
  f.damping = Rows::Zero(s, s);
  f.mass.matrix().topLeftCorner(n, n) = mass;
  f.stiffness.matrix().topLeftCorner(n, n) = stiffness;
  f.damping.matrix().topLeftCorner(body.modes, body.modes) = body.damping;
  const auto diagonal = [](const Eigen::MatrixXd& m) {
    const Eigen::MatrixXd off = m - Eigen::MatrixXd(m.diagonal().asDiagonal());
    return off.cwiseAbs().maxCoeff() <= 1e-10 * std::max(1e-300, m.diagonal().cwiseAbs().maxCoeff());
  };
  if (n > 0) {
    f.identity_mass = (mass - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff() < 1e-9;
    f.nonlinear_stiffness = !stiffness.rightCols(n - body.modes).isZero(0);
    f.diagonal_stiffness = !body.ancf && diagonal(stiffness) && diagonal(body.damping);
  }
  if (body.geometric) f.geometric = geometric_data(body, s);
  if (body.ancf) {
    for (const AncfBeam::Element& e : body.ancf->elements) f.ancf.push_back(ancf_element(e));
    for (const AncfBeam::SpatialElement& e : body.ancf->spatial)
      f.ancf_spatial.push_back(body.ancf->kind == AncfKind::thick ? thick_element(e) : cable_element(e));
    f.ancf_damping = body.ancf->stiffness_damping;
  }
  return f;
}

}  // namespace mimbre
