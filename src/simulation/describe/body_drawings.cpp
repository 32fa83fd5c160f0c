#include "simulation/describe/body_drawings.h"

#include "mimbre/reduced_body.h"
#include "mimbre/surface_mesh.h"
#include "simulation/describe/contact_drawings.h"

namespace mimbre {
namespace {

void draw_flexible(const ReducedBody& body, BodyDrawing& drawing) {
  const auto& second = body.second_order;
  drawing.points = body.nodes;
  drawing.point_shapes = second ? second->node_shapes : body.node_shapes;
  drawing.lines = body.lines;
  drawing.triangles = body.triangles;
  drawing.labels = body.node_labels;
  drawing.stress = body.stress;
  if (body.bar_stress) {
    drawing.bar_stress = body.bar_stress->shapes;
    drawing.round_lines = body.bar_stress->round;
  }
  drawing.line_radius = body.line_radius;
  drawing.modes = static_cast<int>(drawing.point_shapes.cols());
}

void draw_lines(const std::vector<std::array<Eigen::Vector3d, 2>>& lines, BodyDrawing& drawing) {
  drawing.points.resize(3, static_cast<Eigen::Index>(2 * lines.size()));
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const int first = static_cast<int>(2 * l);
    drawing.points.col(first) = lines[l][0];
    drawing.points.col(first + 1) = lines[l][1];
    drawing.lines.push_back({first, first + 1});
  }
  drawing.point_shapes.resize(3 * drawing.points.cols(), 0);
}

/// Points that move with the body's frame and have no stress.
void draw_surface(const spec::Shape& shape, BodyDrawing& drawing) {
  const SurfaceMesh& mesh = *shape.mesh;
  const Eigen::Index before = drawing.points.cols(), added = mesh.vertices.cols(), all = before + added;
  const bool labelled = !drawing.labels.empty(), stressed = drawing.stress.size() > 0;
  drawing.points.conservativeResize(3, all);
  drawing.points.rightCols(added) =
      (shape.pose.rotation * (shape.size.asDiagonal() * mesh.vertices)).colwise() + shape.pose.position;
  drawing.point_shapes.conservativeResize(3 * all, Eigen::NoChange);
  drawing.point_shapes.bottomRows(3 * added).setZero();
  if (labelled) drawing.labels.resize(static_cast<std::size_t>(all), 0);
  if (stressed) {
    drawing.stress.conservativeResize(6 * all, Eigen::NoChange);
    drawing.stress.bottomRows(6 * added).setZero();
  }
  const int first = static_cast<int>(before);
  const bool mirrored = shape.size.prod() < 0;
  for (const auto& [a, b, c] : mesh.triangles)
    drawing.triangles.push_back({first + a, first + (mirrored ? c : b), first + (mirrored ? b : c)});
}

}  // namespace

std::vector<BodyDrawing> body_drawings(const spec::Model& model) {
  std::vector<BodyDrawing> drawings;
  for (const spec::Body& body : model.bodies) {
    BodyDrawing& drawing = drawings.emplace_back();
    drawing.name = body.name;
    if (body.flexible)
      draw_flexible(*body.flexible, drawing);
    else
      draw_lines(body.lines, drawing);
    for (const spec::Shape& shape : body.shapes)
      if (shape.kind == spec::Shape::Kind::mesh)
        draw_surface(shape, drawing);
      else
        drawing.shapes.push_back(shape);
  }
  draw_contacts(model, drawings);
  return drawings;
}

}  // namespace mimbre
