#include "simulation/describe/contact_drawings.h"

#include <algorithm>

#include "forces/surfaces/drawing.h"
#include "spec/surface_kind.h"

namespace mimbre {
namespace {

using Shape = spec::Shape;

const spec::Frame& frame_of(const spec::Model& model, int frame) {
  return model.frames[static_cast<std::size_t>(frame)];
}

/// What has no end is drawn as wide as is large for the spheres that touch it.
double plate_size(const spec::Model& model, int surface) {
  constexpr double radii = 40;
  double largest = 0;
  for (const spec::Contact& contact : model.contacts)
    if (std::find(contact.surfaces.begin(), contact.surfaces.end(), surface) != contact.surfaces.end())
      for (const spec::Spheres& spheres : contact.spheres) largest = std::max(largest, spheres.radius);
  return largest > 0 ? radii * largest : 1;
}

void draw(const spec::Model& model, int number, BodyDrawing& body) {
  const spec::Surface& s = model.surfaces[static_cast<std::size_t>(number)];
  surface_info(find_surface(s.kind)).draw(s, frame_of(model, s.frame).pose, plate_size(model, number), body);
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
      surfaces::draw_along_line(road.along_line, bodies.back());
    else if (is_grid(road))
      surfaces::draw_heights(road.heights, road.spacing,
                             {{road.origin[0], road.origin[1], 0}, Eigen::Matrix3d::Identity()},
                             bodies.back());
  for (const spec::Contact& contact : model.contacts)
    for (const spec::Spheres& spheres : contact.spheres)
      for (const int frame : spheres.frames)
        if (const spec::Frame& at = frame_of(model, frame); at.body >= 0)
          drawing(at.body).shapes.push_back({Shape::Kind::sphere, at.pose, {spheres.radius, 0, 0}});
}

}  // namespace mimbre
