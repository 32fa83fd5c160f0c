#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fe_files/inp/inp_model.h"
#include "fe_files/text.h"

// A slave node is where it is projected onto a master face, and moves with the face and with its normal: so
// that rigid motions of the body satisfy the tie although the surfaces do not meet exactly.

namespace mimbre::fe {
namespace {

using Eigen::Vector3d;
using Values = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 8, 1>;
using Derivatives = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::ColMajor, 8, 2>;

/// Functions of a face of 3, 4, 6 or 8 nodes, corners first; triangles over [0, 1], others over [-1, 1].
void face_shapes(std::size_t count, double x, double y, Values& n, Derivatives& d) {
  n.resize(static_cast<Eigen::Index>(count));
  d.resize(static_cast<Eigen::Index>(count), 2);
  if (count == 3 || count == 6) {
    const std::array<double, 3> l{1 - x - y, x, y};
    constexpr double by_x[] = {-1, 1, 0}, by_y[] = {-1, 0, 1};
    for (int i = 0; i < 3; ++i) {
      const bool quadratic = count == 6;
      n[i] = quadratic ? l[i] * (2 * l[i] - 1) : l[i];
      const double slope = quadratic ? 4 * l[i] - 1 : 1;
      d.row(i) << slope * by_x[i], slope * by_y[i];
      if (!quadratic) continue;
      const int j = (i + 1) % 3;
      n[3 + i] = 4 * l[i] * l[j];
      d.row(3 + i) << 4 * (l[i] * by_x[j] + l[j] * by_x[i]), 4 * (l[i] * by_y[j] + l[j] * by_y[i]);
    }
    return;
  }
  constexpr double a[] = {-1, 1, 1, -1, 0, 1, 0, -1}, b[] = {-1, -1, 1, 1, -1, 0, 1, 0};
  for (int i = 0; i < static_cast<int>(count); ++i) {
    if (count == 4) {
      n[i] = 0.25 * (1 + a[i] * x) * (1 + b[i] * y);
      d.row(i) << 0.25 * a[i] * (1 + b[i] * y), 0.25 * b[i] * (1 + a[i] * x);
    } else if (i < 4) {
      n[i] = 0.25 * (1 + a[i] * x) * (1 + b[i] * y) * (a[i] * x + b[i] * y - 1);
      d.row(i) << 0.25 * a[i] * (1 + b[i] * y) * (2 * a[i] * x + b[i] * y),
          0.25 * b[i] * (1 + a[i] * x) * (a[i] * x + 2 * b[i] * y);
    } else if (a[i] == 0) {
      n[i] = 0.5 * (1 - x * x) * (1 + b[i] * y);
      d.row(i) << -x * (1 + b[i] * y), 0.5 * b[i] * (1 - x * x);
    } else {
      n[i] = 0.5 * (1 + a[i] * x) * (1 - y * y);
      d.row(i) << 0.5 * a[i] * (1 - y * y), -y * (1 + a[i] * x);
    }
  }
}

struct Projection {
  double distance = std::numeric_limits<double>::infinity();
  Values values;
  Derivatives derivatives;
  Eigen::Matrix3Xd corners;
  Vector3d offset;  ///< from the projection to the node
};

Projection project(const SolidMesh& mesh, const std::vector<int>& face, const Vector3d& point) {
  Projection p;
  p.corners.resize(3, static_cast<Eigen::Index>(face.size()));
  for (std::size_t k = 0; k < face.size(); ++k)
    p.corners.col(static_cast<Eigen::Index>(k)) = mesh.nodes.col(face[k]);
  const bool triangle = face.size() == 3 || face.size() == 6;
  const auto inside = [&](Eigen::Vector2d at) {
    if (!triangle) return Eigen::Vector2d(at.cwiseMax(-1).cwiseMin(1));
    at = at.cwiseMax(0);
    if (const double beyond = at.x() + at.y() - 1; beyond > 0) {
      at -= Eigen::Vector2d::Constant(beyond / 2);
      at = at.cwiseMax(0).cwiseMin(1);
    }
    return at;
  };
  Eigen::Vector2d at = triangle ? Eigen::Vector2d::Constant(1.0 / 3) : Eigen::Vector2d(0, 0);
  constexpr int most_steps = 30;
  for (int step = 0; step < most_steps; ++step) {
    face_shapes(face.size(), at.x(), at.y(), p.values, p.derivatives);
    p.offset = point - p.corners * p.values;
    const Eigen::Matrix<double, 3, 2> tangents = p.corners * p.derivatives;
    const Eigen::Vector2d next = inside(at + Eigen::Matrix2d(tangents.transpose() * tangents).inverse() *
                                                 (tangents.transpose() * p.offset));
    const double change = (next - at).norm();
    at = next;
    if (!(change > 1e-12)) break;
  }
  face_shapes(face.size(), at.x(), at.y(), p.values, p.derivatives);
  p.offset = point - p.corners * p.values;
  p.distance = p.offset.allFinite() ? p.offset.norm() : std::numeric_limits<double>::infinity();
  return p;
}

/// u of the node = u of the projection + the turn of the face × offset.
void add_equations(int node, const std::vector<int>& face, const Projection& p, const std::string& name,
                   std::vector<Equation>& equations) {
  const Eigen::Matrix<double, 3, 2> tangents = p.corners * p.derivatives;
  const Vector3d normal = tangents.col(0).cross(tangents.col(1)).normalized();
  const Eigen::Matrix<double, 3, 2> reciprocal =
      tangents * Eigen::Matrix2d(tangents.transpose() * tangents).inverse();
  // The turn of the face: its tilts, by the displacements along the normal, and about the normal by those
  // in the plane.
  for (int i = 0; i < 3; ++i) {
    Equation equation{name, {{node, i, 1}}};
    for (std::size_t k = 0; k < face.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      const Vector3d g = reciprocal * p.derivatives.row(column).transpose();
      Eigen::Matrix3d turn;  // vector of the turn by the displacement of the face's node
      for (int j = 0; j < 3; ++j) {
        const Vector3d unit = Vector3d::Unit(j);
        // ω = n × (−∇w) … as of a rigid motion: tilt g × (w n), and half the curl about the normal.
        turn.col(j) = g.cross(Vector3d(normal.dot(unit) * normal)) + 0.5 * normal.dot(g.cross(unit)) * normal;
      }
      for (int j = 0; j < 3; ++j) {
        const double factor = (i == j ? p.values[column] : 0) + Vector3d(turn.col(j)).cross(p.offset)[i];
        if (factor != 0) equation.terms.push_back({face[k], j, -factor});
      }
    }
    equations.push_back(std::move(equation));
  }
}

}  // namespace

void finish_inp_ties(InpModel& model, SolidMesh& mesh) {
  for (const InpTie& tie : model.ties) {
    const auto master = model.surfaces.find(lower(tie.master));
    if (master == model.surfaces.end() || master->second.faces.empty())
      throw InputError(tie.mark,
                       fmt::format("there is no surface of element faces '{}' for *TIE", shown(tie.master)));
    std::vector<int> slaves;
    for (const NodeSet& set : mesh.node_sets)
      if (lower(set.name) == lower(tie.slave)) slaves = set.nodes;
    if (slaves.empty())
      throw InputError(tie.mark, fmt::format("there is no surface '{}' for *TIE", shown(tie.slave)));
    struct Ball {
      Vector3d centre;
      double radius;
    };
    std::vector<Ball> balls;
    for (const std::vector<int>& face : master->second.faces) {
      Vector3d centre = Vector3d::Zero();
      for (const int node : face) centre += mesh.nodes.col(node) / static_cast<double>(face.size());
      double radius = 0;
      for (const int node : face) radius = std::max(radius, (mesh.nodes.col(node) - centre).norm());
      balls.push_back({centre, 1.2 * radius});
    }
    const std::string name = fmt::format("*TIE of line {}", tie.mark.line);
    std::size_t apart = 0;
    for (const int node : slaves) {
      const Vector3d point = mesh.nodes.col(node);
      Projection best;
      std::size_t nearest = 0;
      bool own = false;
      for (std::size_t f = 0; f < balls.size(); ++f) {
        const std::vector<int>& face = master->second.faces[f];
        const double bound = tie.tolerance >= 0 ? tie.tolerance : balls[f].radius;
        if ((point - balls[f].centre).norm() > balls[f].radius + std::min(best.distance, bound)) continue;
        own = own || std::find(face.begin(), face.end(), node) != face.end();
        Projection p = project(mesh, face, point);
        if (p.distance < best.distance) best = std::move(p), nearest = f;
      }
      if (own) continue;  // of both surfaces: it is tied already
      // CalculiX: 2.5 % of a typical size of the elements, where nothing is given.
      const double tolerance = tie.tolerance >= 0 ? tie.tolerance : 0.05 * balls[nearest].radius;
      if (!(best.distance <= tolerance)) {
        ++apart;
        continue;
      }
      add_equations(node, master->second.faces[nearest], best, name, mesh.equations);
    }
    if (apart > 0)
      model.warn(
          "tie " + std::to_string(tie.mark.line), tie.mark,
          fmt::format("{} of the {} nodes of the slave surface {} are not near enough to the master surface "
                      "{} and stay free; see POSITION TOLERANCE",
                      apart, slaves.size(), shown(tie.slave), shown(tie.master)));
  }
}

}  // namespace mimbre::fe
