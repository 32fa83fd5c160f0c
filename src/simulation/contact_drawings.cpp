#include "simulation/contact_drawings.h"

#include <algorithm>

namespace mimbre {
namespace {

using Kind = spec::Surface::Kind;
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

void draw_heights(const spec::Surface& s, const spec::Pose& pose, BodyDrawing& body) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  const int columns = static_cast<int>(s.heights.cols());
  for (int j = 0; j < s.heights.rows(); ++j)
    for (int i = 0; i < columns; ++i) {
      vertices.push_back({i * s.spacing[0], j * s.spacing[1], s.heights(j, i)});
      if (i == 0 || j == 0) continue;
      const int last = j * columns + i, below = last - columns;
      triangles.push_back({below - 1, below, last});
      triangles.push_back({below - 1, last, last - 1});
    }
  draw_triangles(vertices, triangles, pose, body);
}

void draw(const spec::Model& model, int number, BodyDrawing& body) {
  const spec::Surface& s = model.surfaces[static_cast<std::size_t>(number)];
  const spec::Pose& pose = frame_of(model, s.frame).pose;
  const auto add = [&](Shape::Kind kind, const spec::Pose& at, const Eigen::Vector3d& size) {
    body.shapes.push_back({kind, at, size});
  };
  switch (s.kind) {
    case Kind::half_space: {
      const double side = plate_size(model, number), thick = 0.01 * side;
      return add(Shape::Kind::box, shifted(pose, -0.5 * thick), {side, side, thick});
    }
    case Kind::box:
      return add(Shape::Kind::box, pose, s.size);
    case Kind::capsule:
      for (const double end : {-0.5, 0.5})
        add(Shape::Kind::sphere, shifted(pose, end * s.size[1]), {s.size[0], 0, 0});
      [[fallthrough]];
    case Kind::cylinder:
      return add(Shape::Kind::cylinder, pose, {s.size[0], s.size[1], 0});
    case Kind::sphere:
      return add(Shape::Kind::sphere, pose, {s.size[0], 0, 0});
    case Kind::heights:
      return draw_heights(s, pose, body);
    case Kind::mesh:
      return draw_triangles(s.vertices, s.triangles, pose, body);
  }
}

}  // namespace

bool draws_ground(const spec::Model& model) {
  return std::any_of(model.surfaces.begin(), model.surfaces.end(),
                     [&](const spec::Surface& s) { return frame_of(model, s.frame).body < 0; });
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
  for (const spec::Contact& contact : model.contacts)
    for (const spec::Spheres& spheres : contact.spheres)
      for (const int frame : spheres.frames)
        if (const spec::Frame& at = frame_of(model, frame); at.body >= 0)
          drawing(at.body).shapes.push_back({Shape::Kind::sphere, at.pose, {spheres.radius, 0, 0}});
}

}  // namespace mimbre
