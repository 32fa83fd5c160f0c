#include <set>

#include "mimbre/reduced_body.h"
#include "mimbre/surface_mesh.h"
#include "reduction/file/check_arrays.h"
#include "spec/check/checked_item.h"
#include "spec/rigid_inertia.h"

/// Bodies and the frames on them.
namespace mimbre::checks {
namespace {

void check_rigid(const CheckedItem& item, const spec::Model& model, std::size_t number) {
  const spec::Body& body = model.bodies[number];
  item.finite("com", body.com);
  const Eigen::Matrix3d& J = body.inertia;
  if (!item.not_negative("mass", body.mass) || !item.finite("inertia", J)) return;
  constexpr double rounding = 1e-6;
  if ((J - J.transpose()).cwiseAbs().maxCoeff() > rounding * J.cwiseAbs().maxCoeff())
    return item.error("inertia is not symmetric; Ixy must be Iyx, and so on");
  const auto fault = inertia_fault(model, number);
  if (fault && fault->harmless.empty()) item.error((body.mass > 0 ? "inertia " : "") + fault->what);
}

void check_spatial_ancf(const CheckedItem& item, const ReducedBody& body) {
  const AncfBeam& beam = *body.ancf;
  for (std::size_t k = 0; k < beam.spatial.size(); ++k) {
    const AncfBeam::SpatialElement& e = beam.spatial[k];
    const auto what = [&](const char* name) {
      return fmt::format("reduced body: beam: element {}: {}", k, name);
    };
    item.positive(what("length"), e.length);
    item.not_negative(what("axial"), e.axial);
    item.not_negative(what("bending_y"), e.bending_y);
    item.not_negative(what("bending_z"), e.bending_z);
    if (beam.kind == AncfKind::cable && e.bending_y != e.bending_z)
      item.error(what("bending_y and bending_z differ, but a cable bends alike in all directions"));
    item.not_negative(what("torsion"), e.torsion);
    item.not_negative(what("shear_y"), e.shear_y);
    item.not_negative(what("shear_z"), e.shear_z);
    item.not_negative(what("section_shear"), e.section_shear);
    for (const int amplitude : e.amplitudes) item.between(what("amplitude"), amplitude, -1, body.modes - 1);
  }
  if (beam.kind == AncfKind::thick && beam.sections.size() != body.frames.size())
    item.error("reduced body: beam: each frame needs the amplitudes of its section");
  for (const auto& section : beam.sections)
    for (const int amplitude : section)
      item.between("reduced body: beam: amplitude of a section", amplitude, -1, body.modes - 1);
}

void check_ancf(const CheckedItem& item, const ReducedBody& body) {
  const AncfBeam& beam = *body.ancf;
  item.not_negative("reduced body: beam: stiffness_damping", beam.stiffness_damping);
  if (!item.enumerator("reduced body: beam: kind", beam.kind, 3)) return;
  const auto unit = [](const Eigen::Vector3d& v) { return std::abs(v.norm() - 1) < 1e-6; };
  if (!unit(beam.along) || !unit(beam.normal) || !(std::abs(beam.along.dot(beam.normal)) < 1e-6))
    item.error("reduced body: beam: along and normal must be unit vectors at right angles");
  if ((beam.kind == AncfKind::planar ? beam.spatial.size() : beam.elements.size()) > 0)
    item.error("reduced body: beam: has elements of another kind");
  check_spatial_ancf(item, body);
  for (std::size_t k = 0; k < beam.elements.size(); ++k) {
    const AncfBeam::Element& e = beam.elements[k];
    const auto what = [&](const char* name) {
      return fmt::format("reduced body: beam: element {}: {}", k, name);
    };
    item.positive(what("length"), e.length);
    item.not_negative(what("axial"), e.axial);
    item.not_negative(what("bending"), e.bending);
    for (const int amplitude : e.amplitudes) item.between(what("amplitude"), amplitude, -1, body.modes - 1);
  }
}

/// True when the arrays fit each other, so that frames and outputs may look into them.
bool check_flexible(const CheckedItem& item, const ReducedBody& body) {
  const auto messages = check_arrays(body);
  for (const std::string& message : messages) item.error("reduced body: " + message);
  const bool turns = item.enumerator("reduced body: boundary_rotation", body.boundary_rotation, 3);
  if (!messages.empty() || !turns) return false;
  if (body.ancf) check_ancf(item, body);
  return true;
}

void check_mesh(const CheckedItem& item, const spec::Shape& shape) {
  if (item.finite("size of a shape", shape.size) && (shape.size.array() == 0).any())
    item.error("size of a shape is 0; the factors on a mesh's coordinates can be anything else");
  if (!shape.mesh) return item.error("a shape is a mesh, but has none");
  item.finite("mesh of a shape", shape.mesh->vertices);
  for (const auto& triangle : shape.mesh->triangles)
    for (const int corner : triangle)
      if (corner < 0 || corner >= shape.mesh->vertices.cols())
        return item.error(fmt::format("a triangle of a shape's mesh ends at vertex {}, but it has {}", corner,
                                      shape.mesh->vertices.cols()));
}

void check_drawing(const CheckedItem& item, const spec::Body& body) {
  for (const spec::Shape& shape : body.shapes) {
    item.pose(shape.pose);
    if (!item.enumerator("kind of a shape", shape.kind, 4)) continue;
    if (shape.kind == spec::Shape::Kind::mesh) {
      check_mesh(item, shape);
      continue;
    }
    const int sizes = shape.kind == spec::Shape::Kind::box        ? 3
                      : shape.kind == spec::Shape::Kind::cylinder ? 2
                                                                  : 1;
    for (int k = 0; k < sizes; ++k) item.positive("size of a shape", shape.size[k]);
  }
  for (const auto& line : body.lines)
    for (const Eigen::Vector3d& end : line) item.finite("end of a line", end);
}

/// The node whose modes move a frame lies where the frame does.
void check_node(const CheckedItem& item, const spec::Frame& frame, const spec::Body& body) {
  const auto& nodes = body.flexible->frames;
  if (frame.flexible_frame >= static_cast<int>(nodes.size()))
    return item.error(fmt::format("flexible_frame is {}, but body '{}' has {} frames that its modes move",
                                  frame.flexible_frame, body.name, nodes.size()));
  const BodyFrame& node = nodes[static_cast<std::size_t>(frame.flexible_frame)];
  double size = node.position.norm();
  for (const BodyFrame& other : nodes) size = std::max(size, (other.position - node.position).norm());
  if (body.flexible->nodes.cols() > 0)
    size = std::max(size, (body.flexible->nodes.colwise() - node.position).colwise().norm().maxCoeff());
  const double distance = (node.position - frame.pose.position).norm();
  if (distance > 1e-4 * size)  // rounded figures, as of drawings
    item.error(
        fmt::format("lies {:.3g} m away from '{}' of body '{}', whose modes move it (flexible_frame {}); "
                    "it must lie there",
                    distance, node.name, body.name, frame.flexible_frame));
}

/// Linear elastodynamics takes what is linear in the amplitudes.
void check_elastodynamic(const CheckedItem& item, const spec::Body& body) {
  if (!body.elastodynamic) return;
  if (!body.flexible)
    item.error("is rigid, so that nothing of it bends by elastodynamics");
  else if (body.flexible->ancf || body.flexible->second_order || body.flexible->geometric)
    item.error("stiffens, or bends beyond linear theory, which elastodynamics leaves out; take it linear");
}

}  // namespace

void check_bodies(const spec::Model& model, std::vector<Diagnostic>& errors) {
  std::set<const ReducedBody*> known;
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    const spec::Body& body = model.bodies[k];
    const CheckedItem item(errors, "body", body.name, body.mark, k);
    item.pose(body.pose);
    check_drawing(item, body);
    if (!body.flexible)
      check_rigid(item, model, k);
    else if (known.insert(body.flexible.get()).second)
      check_flexible(item, *body.flexible);
    check_elastodynamic(item, body);
  }
}

void check_frames(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.frames.size(); ++k) {
    const spec::Frame& frame = model.frames[k];
    const CheckedItem item(errors, "frame", frame.name, frame.mark, k);
    item.pose(frame.pose);
    if (!item.index("body", frame.body, model.bodies.size(), "bodies", spec::ground)) continue;
    if (frame.flexible_frame < -1)
      item.error(fmt::format("flexible_frame is {}; -1 means that no modes move it", frame.flexible_frame));
    if (frame.node != -1) {
      const auto& flexible =
          frame.body < 0 ? nullptr : model.bodies[static_cast<std::size_t>(frame.body)].flexible;
      if (!flexible)
        item.error(fmt::format("node is {}, but it is on no flexible body; -1 means none", frame.node));
      else
        item.index("node", frame.node, static_cast<std::size_t>(flexible->nodes.cols()), "nodes");
    }
    if (frame.flexible_frame < 0 || frame.body == spec::ground) continue;
    const spec::Body& body = model.bodies[static_cast<std::size_t>(frame.body)];
    if (!body.flexible)
      item.error(fmt::format("flexible_frame is {}, but body '{}' is rigid; -1 means that no modes move it",
                             frame.flexible_frame, body.name));
    else if (frame.pose.position.allFinite())
      check_node(item, frame, body);
  }
}

}  // namespace mimbre::checks
