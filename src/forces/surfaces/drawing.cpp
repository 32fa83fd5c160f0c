#include "forces/surfaces/drawing.h"

#include <algorithm>

namespace mimbre::surfaces {

void draw_triangles(const std::vector<Eigen::Vector3d>& vertices,
                    const std::vector<std::array<int, 3>>& triangles, const spec::Pose& pose,
                    BodyDrawing& body) {
  if (body.modes > 0) return;
  const auto before = body.points.cols();
  body.points.conservativeResize(3, before + std::ssize(vertices));
  body.point_shapes.conservativeResize(3 * body.points.cols(), 0);
  for (std::size_t k = 0; k < vertices.size(); ++k)
    body.points.col(before + static_cast<Eigen::Index>(k)) = pose.position + pose.rotation * vertices[k];
  for (std::array<int, 3> t : triangles) {
    for (int& corner : t) corner += static_cast<int>(before);
    body.triangles.push_back(t);
  }
}

namespace {

/// Numbers of the columns between which the others are on straight lines, within the tolerance.
std::vector<Eigen::Index> bends(const Eigen::MatrixXd& heights, double tolerance) {
  constexpr Eigen::Index longest = 100;
  std::vector<Eigen::Index> kept{0};
  for (const Eigen::Index last = heights.cols() - 1; kept.back() < last;) {
    const Eigen::Index from = kept.back();
    const auto straight = [&](Eigen::Index end) {
      for (Eigen::Index k = from + 1; k < end; ++k) {
        const double share = static_cast<double>(k - from) / static_cast<double>(end - from);
        const auto between = (1 - share) * heights.col(from) + share * heights.col(end);
        if ((between - heights.col(k)).cwiseAbs().maxCoeff() > tolerance) return false;
      }
      return true;
    };
    Eigen::Index to = from + 1;
    while (to < last && to - from < longest && straight(to + 1)) ++to;
    kept.push_back(to);
  }
  return kept;
}

constexpr int most_lines = 400;

/// Of many lines of a grid every so many, and the last.
std::vector<Eigen::Index> places(Eigen::Index count) {
  std::vector<Eigen::Index> all;
  const Eigen::Index each = 1 + (count - 1) / most_lines;
  for (Eigen::Index k = 0; k < count - 1; k += each) all.push_back(k);
  all.push_back(count - 1);
  return all;
}

/// Over the lines chosen; `point`: by the numbers of a column and a row.
template <class Point>
void draw_lines(const std::vector<Eigen::Index>& columns, const std::vector<Eigen::Index>& rows,
                const Point& point, const spec::Pose& pose, BodyDrawing& body) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  const int width = static_cast<int>(columns.size());
  for (int j = 0; j < static_cast<int>(rows.size()); ++j)
    for (int i = 0; i < width; ++i) {
      vertices.push_back(point(columns[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(j)]));
      if (i == 0 || j == 0) continue;
      const int last = j * width + i, below = last - width;
      triangles.push_back({below - 1, below, last});
      triangles.push_back({below - 1, last, last - 1});
    }
  draw_triangles(vertices, triangles, pose, body);
}

}  // namespace

void draw_heights(const Eigen::MatrixXd& heights, const Eigen::Vector2d& spacing, const spec::Pose& pose,
                  BodyDrawing& body) {
  constexpr int large = 2000;  // points
  constexpr double share_of_range = 2e-3;
  const auto chosen = [&](const Eigen::MatrixXd& of) {
    if (heights.size() <= large) return places(of.cols());
    std::vector<Eigen::Index> at = bends(of, share_of_range * (of.maxCoeff() - of.minCoeff()));
    return at.size() <= most_lines ? at : places(of.cols());
  };
  const auto point = [&](Eigen::Index i, Eigen::Index j) {
    return Eigen::Vector3d(static_cast<double>(i) * spacing[0], static_cast<double>(j) * spacing[1],
                           heights(j, i));
  };
  draw_lines(chosen(heights), chosen(heights.transpose()), point, pose, body);
}

void draw_along_line(const RoadGrid& road, BodyDrawing& body) {
  const roads::GridArrays grid = roads::arrays_of(road, 0);
  const auto point = [&](Eigen::Index i, Eigen::Index j) {
    const double* p = roads::grid::point(grid, static_cast<int>(i));
    const auto row = static_cast<std::size_t>(i), section = static_cast<std::size_t>(j);
    const double v = road.v[section];
    return Eigen::Vector3d(p[0] + v * p[2], p[1] + v * p[3], grid.height[row * road.across() + section]);
  };
  draw_lines(places(static_cast<Eigen::Index>(road.along())),
             places(static_cast<Eigen::Index>(road.across())), point,
             {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()}, body);
}

}  // namespace mimbre::surfaces
