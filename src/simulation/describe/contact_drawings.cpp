#include "simulation/describe/contact_drawings.h"

#include <algorithm>

#include "roads/grid.h"

namespace mimbre {
namespace {

using SurfaceForm = spec::Surface::Kind;
using Shape = spec::Shape;

const spec::Frame& frame_of(const spec::Model& model, int frame) {
  return model.frames[static_cast<std::size_t>(frame)];
}

spec::Pose shifted(const spec::Pose& pose, double along_z) {
  return {pose.position + along_z * pose.rotation.col(2), pose.rotation};
}

/// A half-space is drawn as wide as is large for the spheres that touch it.
double plate_size(const spec::Model& model, int surface) {
  constexpr double radii = 40;
  double largest = 0;
  for (const spec::Contact& contact : model.contacts)
    if (std::find(contact.surfaces.begin(), contact.surfaces.end(), surface) != contact.surfaces.end())
      for (const spec::Spheres& spheres : contact.spheres) largest = std::max(largest, spheres.radius);
  return largest > 0 ? radii * largest : 1;
}

/// Triangles go to the points of a body that has no modes.
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

/// Of large grids only the rows and columns where they bend, or, where they do all over, every so many.
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

/// As wheels feel it (roads/grid.h).
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

void draw(const spec::Model& model, int number, BodyDrawing& body) {
  const spec::Surface& s = model.surfaces[static_cast<std::size_t>(number)];
  const spec::Pose& pose = frame_of(model, s.frame).pose;
  const auto add = [&](Shape::Kind kind, const spec::Pose& at, const Eigen::Vector3d& size) {
    body.shapes.push_back({kind, at, size});
  };
  switch (s.kind) {
    case SurfaceForm::half_space: {
      const double side = plate_size(model, number), thick = 0.01 * side;
      return add(Shape::Kind::box, shifted(pose, -0.5 * thick), {side, side, thick});
    }
    case SurfaceForm::box:
      return add(Shape::Kind::box, pose, s.size);
    case SurfaceForm::capsule:
      for (const double end : {-0.5, 0.5})
        add(Shape::Kind::sphere, shifted(pose, end * s.size[1]), {s.size[0], 0, 0});
      [[fallthrough]];
    case SurfaceForm::cylinder:
      return add(Shape::Kind::cylinder, pose, {s.size[0], s.size[1], 0});
    case SurfaceForm::sphere:
      return add(Shape::Kind::sphere, pose, {s.size[0], 0, 0});
    case SurfaceForm::heights:
      return draw_heights(s.heights, s.spacing, pose, body);
    case SurfaceForm::mesh:
      return draw_triangles(s.vertices, s.triangles, pose, body);
  }
}

bool is_grid(const spec::Road& road) { return road.over == spec::Road::Over::grid; }

}  // namespace

bool draws_ground(const spec::Model& model) {
  return std::any_of(model.surfaces.begin(), model.surfaces.end(),
                     [&](const spec::Surface& s) { return frame_of(model, s.frame).body < 0; }) ||
         std::any_of(model.roads.begin(), model.roads.end(), is_grid);
}

void draw_contacts(const spec::Model& model, std::vector<BodyDrawing>& bodies) {
  if (draws_ground(model)) {
    bodies.emplace_back().name = "ground";
    bodies.back().points.resize(3, 0);
    bodies.back().point_shapes.resize(0, 0);
  }
  const auto drawing = [&](int body) -> BodyDrawing& {
    return body < 0 ? bodies.back() : bodies[static_cast<std::size_t>(body)];
  };
  for (int k = 0; k < static_cast<int>(model.surfaces.size()); ++k)
    draw(model, k, drawing(frame_of(model, model.surfaces[static_cast<std::size_t>(k)].frame).body));
  for (const spec::Road& road : model.roads)
    if (is_grid(road) && road.along_line.along() > 0)
      draw_along_line(road.along_line, bodies.back());
    else if (is_grid(road))
      draw_heights(road.heights, road.spacing,
                   {{road.origin[0], road.origin[1], 0}, Eigen::Matrix3d::Identity()}, bodies.back());
  for (const spec::Contact& contact : model.contacts)
    for (const spec::Spheres& spheres : contact.spheres)
      for (const int frame : spheres.frames)
        if (const spec::Frame& at = frame_of(model, frame); at.body >= 0)
          drawing(at.body).shapes.push_back({Shape::Kind::sphere, at.pose, {spheres.radius, 0, 0}});
}

}  // namespace mimbre
