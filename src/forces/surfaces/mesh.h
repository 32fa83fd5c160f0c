#pragma once
#include <array>
#include <limits>
#include <type_traits>

#include "compile/compiled.h"
#include "compile/triangle_mesh.h"
#include "forces/surfaces/drawing.h"
#include "forces/surfaces/touch.h"
#include "spec/check/checked_item.h"
#include "spec/closed_surface.h"
#include "spec/surface_kind.h"

/// Triangles that close, or reach as far as anything does. The nearest point of all by a tree of boxes; the
/// sign by the normal of the face, edge or corner on which it lies (Bærentzen and Aanæs, IEEE Trans. Vis.
/// Comput. Graph. 11, 2005).
namespace mimbre::surfaces {

struct NearestPoint {
  double distance = 0;  ///< negative inside
  Vec3d normal = Vec3d::UnitZ();
  int corners = 3;  ///< on how many it lies: 3 a face, 2 an edge, 1 a corner
  Vec3d edge = Vec3d::Zero();
};

/// Of a triangle the point nearest to p (Ericson, Real-Time Collision Detection, 2005, 5.1.5), and where it
/// lies: 0 to 2 a corner, 3 to 5 the edge from that corner, 6 the face.
inline Vec3d nearest_in_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p, int& where) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return where = 0, a;
  if (d3 >= 0 && d4 <= d3) return where = 1, b;
  if (d6 >= 0 && d5 <= d6) return where = 2, c;
  const double of_c = d1 * d4 - d3 * d2, of_b = d5 * d2 - d1 * d6, of_a = d3 * d6 - d5 * d4;
  if (of_c <= 0 && d1 >= 0 && d3 <= 0) return where = 3, a + d1 / (d1 - d3) * ab;
  if (of_a <= 0 && d4 >= d3 && d5 >= d6) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return where = 4, b + t * (c - b);
  }
  if (of_b <= 0 && d2 >= 0 && d6 <= 0) return where = 5, a + d2 / (d2 - d6) * ac;
  const double all = of_a + of_b + of_c;
  return where = 6, a + of_b / all * ab + of_c / all * ac;
}

inline double distance_to_box(const TriangleMesh::Node& box, const Vec3d& p) {
  return (box.low - p).cwiseMax(p - box.high).cwiseMax(0).squaredNorm();
}

inline Vec3d face_normal(const TriangleMesh& m, int triangle) {
  const std::array<int, 3>& t = m.triangles[static_cast<std::size_t>(triangle)];
  const Vec3d &a = m.vertices[static_cast<std::size_t>(t[0])],
              &b = m.vertices[static_cast<std::size_t>(t[1])],
              &c = m.vertices[static_cast<std::size_t>(t[2])];
  return (b - a).cross(c - a).normalized();
}

inline NearestPoint nearest_point(const TriangleMesh& m, const Vec3d& p) {
  // Of a tree over fewer than 2³¹ triangles no more boxes than this wait at a time.
  std::array<int, 64> waiting;
  int count = 0, triangle = 0, where = 6;
  double least = std::numeric_limits<double>::infinity();
  Vec3d found = p;
  waiting[static_cast<std::size_t>(count++)] = 0;
  while (count > 0) {
    const TriangleMesh::Node& node =
        m.nodes[static_cast<std::size_t>(waiting[static_cast<std::size_t>(--count)])];
    if (distance_to_box(node, p) >= least) continue;
    if (node.count == 0) {
      const auto first = static_cast<std::size_t>(node.first);
      const bool swap = distance_to_box(m.nodes[first], p) < distance_to_box(m.nodes[first + 1], p);
      waiting[static_cast<std::size_t>(count++)] = node.first + (swap ? 1 : 0);
      waiting[static_cast<std::size_t>(count++)] = node.first + (swap ? 0 : 1);
      continue;
    }
    for (int k = node.first; k < node.first + node.count; ++k) {
      const std::array<int, 3>& t = m.triangles[static_cast<std::size_t>(k)];
      int at = 6;
      const Vec3d point = nearest_in_triangle(m.vertices[static_cast<std::size_t>(t[0])],
                                              m.vertices[static_cast<std::size_t>(t[1])],
                                              m.vertices[static_cast<std::size_t>(t[2])], p, at);
      const double square = (p - point).squaredNorm();
      if (square >= least) continue;
      least = square;
      found = point;
      triangle = k;
      where = at;
    }
  }
  const std::array<int, 3>& t = m.triangles[static_cast<std::size_t>(triangle)];
  NearestPoint n;
  Vec3d outwards = face_normal(m, triangle);
  if (where < 3) {
    n.corners = 1;
    outwards = m.vertex_normals[static_cast<std::size_t>(t[static_cast<std::size_t>(where)])].normalized();
  } else if (where < 6) {
    const auto k = static_cast<std::size_t>(where - 3);
    n.corners = 2;
    n.edge =
        (m.vertices[static_cast<std::size_t>(t[(k + 1) % 3])] - m.vertices[static_cast<std::size_t>(t[k])])
            .normalized();
    if (const int other = m.neighbours[static_cast<std::size_t>(triangle)][k]; other >= 0)
      outwards = (outwards + face_normal(m, other)).normalized();
  }
  const Vec3d away = p - found;
  const double length = std::sqrt(least), side = away.dot(outwards) < 0 ? -1 : 1;
  n.distance = side * length;
  n.normal = n.corners == 3 || !(length > 0) ? outwards : Vec3d(side / length * away);
  return n;
}

struct Mesh {
  template <class T>
  static Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
    Touch<T> found;
    Vec3d at;
    if constexpr (std::is_same_v<T, double>) {
      const NearestPoint n = nearest_point(s.mesh, p);
      found = {n.distance, n.normal};
    } else if constexpr (is_pack<T>) {
      for (int i = 0; i < T::lanes; ++i) {
        for (int k = 0; k < 3; ++k) at[k] = p[k][i];
        const NearestPoint n = nearest_point(s.mesh, at);
        found.distance[i] = n.distance;
        for (int k = 0; k < 3; ++k) found.normal[k][i] = n.normal[k];
      }
    } else {
      Vec3d rate;
      for (int k = 0; k < 3; ++k) {
        at[k] = p[k].value;
        rate[k] = p[k].derivative;
      }
      const NearestPoint n = nearest_point(s.mesh, at);
      Vec3d turning = Vec3d::Zero();
      if (n.corners < 3 && n.distance != 0)
        turning = (rate - n.normal * n.normal.dot(rate) - n.edge * n.edge.dot(rate)) / n.distance;
      found.distance = T(n.distance, n.normal.dot(rate));
      for (int k = 0; k < 3; ++k) found.normal[k] = T(n.normal[k], turning[k]);
    }
    return found;
  }
  static void check(const spec::Surface& s, const checks::CheckedItem& item) {
    for (const Eigen::Vector3d& vertex : s.vertices)
      if (!item.finite("one of its vertices", vertex)) return;
    if (const std::string why = why_not_closed(s.vertices, s.triangles); !why.empty()) item.error(why);
  }
  static TriangleMesh mesh(const spec::Surface& s) { return triangle_mesh(s.vertices, s.triangles); }
  static void draw(const spec::Surface& s, const spec::Pose& pose, double, BodyDrawing& body) {
    draw_triangles(s.vertices, s.triangles, pose, body);
  }
  static constexpr SurfaceInfo info{
      .name = "mesh", .triangles = true, .check = check, .mesh = mesh, .draw = draw};
};

}  // namespace mimbre::surfaces
