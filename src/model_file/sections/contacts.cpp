#include "model_file/sections/contacts.h"

#include <fmt/format.h>

#include "model_file/sections/elements.h"
#include "model_file/sections/heights.h"
#include "model_file/sections/surface_files.h"
#include "spec/force_law.h"
#include "spec/surface_kind.h"

/// Surfaces, and spheres that touch them.
namespace mimbre::model_file {
namespace {

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const SurfaceInfo* kind : all_surfaces()) names.emplace_back(kind->name);
  return names;
}

/// The frame that is named, or one of its own at a place with axes.
int read_place(Builder& builder, const Part& part, const Fields& fields, const SurfaceInfo& kind,
               const spec::Surface& surface) {
  const auto on = fields.get("on");
  int body = spec::ground;
  if (on) {
    const auto found = resolve_attachment(builder, part, *on);
    if (!found) return -1;
    if (found->frame >= 0) {
      for (const char* key : {"at", "x", "y", "z"})
        if (const auto given = fields.get(key))
          given->error("a frame has its place and axes already; these keys go with the name of a body");
      return found->frame;
    }
    body = found->body;
  }
  spec::Pose pose = read_pose(part, fields, Eigen::Vector3d::Zero());
  if (body >= 0 && !fields.has("at")) pose.position = builder.body_pose(body).position;
  // The upper side of what is mirrored along z is its lower one.
  if (kind.one_sided && part.place.mirror[2] < 0)
    pose.rotation = (pose.rotation * Eigen::Vector3d(1, -1, -1).asDiagonal()).eval();
  return builder.add_frame_at(surface.name + ".surface", body, pose.position, pose.rotation,
                              on ? *on : fields.value());
}

void read_sizes(const Fields& fields, const SurfaceInfo& kind, spec::Surface& surface) {
  for (std::size_t k = 0; k < kind.sizes.size() && !kind.sizes[k].empty(); ++k) {
    const std::string key(kind.sizes[k]);
    if (key == "size") {
      if (const auto size = fields.need(key, "[1, 1, 0.1]"))
        surface.size = size->triple(quantity::length).value_or(Eigen::Vector3d::Ones());
    } else if (const auto size = fields.need(key, "0.1")) {
      surface.size[static_cast<Eigen::Index>(k)] = size->positive(quantity::length).value_or(1);
    }
  }
}

void read_grid(const Part& part, const Fields& fields, spec::Surface& surface) {
  if (part.place.mirror != Eigen::Vector3d::Ones())
    fields.error("a grid of heights cannot be mirrored; give each place its own");
  if (const auto spacing = fields.need("spacing", "[0.1, 0.1]"))
    if (const auto numbers = spacing->numbers(2, 2, quantity::length))
      surface.spacing = {(*numbers)[0], (*numbers)[1]};
  const auto heights = fields.need("heights", "[[0, 0], [0, 0.1]]");
  if (auto read = heights ? read_heights(*heights) : std::nullopt) surface.heights = std::move(*read);
}

/// Of a file, whose triangles enclose a solid.
void read_file(Builder& builder, const Part& part, const Fields& fields, const Value& file,
               spec::Surface& surface) {
  for (const char* key : {"vertices", "triangles"})
    if (const auto given = fields.get(key)) given->error("the file has these already; keep one");
  const auto mesh = read_surface_file(builder, file);
  if (!mesh) return;
  if (const std::string why = why_not_closed(*mesh); !why.empty())
    return file.error("does not enclose a solid: " + why);
  const Eigen::Vector3d factors = part.place.mirror.cwiseProduct(read_scale(fields));
  for (Eigen::Index k = 0; k < mesh->vertices.cols(); ++k)
    surface.vertices.emplace_back(factors.cwiseProduct(mesh->vertices.col(k)));
  surface.triangles = mesh->triangles;
  if (factors.prod() < 0)
    for (std::array<int, 3>& t : surface.triangles) std::swap(t[1], t[2]);
}

void read_triangles(Builder& builder, const Part& part, const Fields& fields, spec::Surface& surface) {
  if (const auto file = fields.get("file")) return read_file(builder, part, fields, *file, surface);
  if (const auto scale = fields.get("scale")) scale->error("is for a mesh from a file");
  if (const auto vertices = fields.need("vertices", "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]"))
    for (const Value& vertex : vertices->list())
      surface.vertices.push_back(
          part.place.mirror.cwiseProduct(vertex.triple(quantity::length).value_or(Eigen::Vector3d::Zero())));
  if (const auto triangles = fields.need("triangles", "[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]"))
    for (const Value& triangle : triangles->list()) {
      const auto corners = triangle.list();
      if (corners.size() != 3) {
        if (triangle.is_list()) triangle.error("three vertices are needed, counted from 0");
        continue;
      }
      std::array<int, 3> t{};
      for (std::size_t k = 0; k < 3; ++k)
        t[k] = corners[k].integer(0, std::max(0, static_cast<int>(surface.vertices.size()) - 1)).value_or(0);
      if (part.place.determinant() < 0) std::swap(t[1], t[2]);
      surface.triangles.push_back(t);
    }
}

void read_surface(Builder& builder, const Part& part, const Value& value, spec::Surface& surface) {
  std::vector<std::string> keys{"type", "on", "at", "x", "y", "z"};
  for (const char* key :
       {"size", "radius", "length", "spacing", "heights", "vertices", "triangles", "file", "scale"})
    keys.emplace_back(key);
  const Fields any(value, keys);
  if (!value.has_fields()) return;
  const auto type = any.need("type", "half_space");
  const auto choice = type ? type->choice(kind_names()) : std::nullopt;
  if (!choice) return;
  const SurfaceInfo& kind = surface_info(*choice);
  surface.kind = kind.name;
  keys.resize(6);
  for (const std::string_view size : kind.sizes)
    if (!size.empty()) keys.emplace_back(size);
  if (kind.grid) keys.insert(keys.end(), {"spacing", "heights"});
  if (kind.triangles) keys.insert(keys.end(), {"vertices", "triangles", "file", "scale"});
  const Fields fields(value, keys);
  surface.frame = read_place(builder, part, fields, kind, surface);
  read_sizes(fields, kind, surface);
  if (kind.grid) read_grid(part, fields, surface);
  if (kind.triangles) read_triangles(builder, part, fields, surface);
}

/// {on, at, radius}: about a point or several of a body, or a frame or node; {surface_of, radius}.
void read_spheres(Builder& builder, const Part& part, const Value& value, spec::Contact& contact) {
  const Fields fields(value, {"on", "at", "surface_of", "radius"});
  if (!value.has_fields()) return;
  spec::Spheres spheres;
  if (const auto radius = fields.need("radius", "0.05"))
    spheres.radius = radius->positive(quantity::length).value_or(1);
  const auto on = fields.get("on"), of = fields.get("surface_of"), at = fields.get("at");
  if (on.has_value() == of.has_value())
    return value.error(
        "are about points: on: wheel (and at: [[x, y, z], ..]), or about all nodes of a flexible "
        "body's surface: surface_of: blade; give one of them");
  if (of) {
    const auto name = of->word();
    spheres.surface_of = name ? builder.resolve(builder.body_names, part, *name, *of) : -1;
    if (spheres.surface_of >= 0) contact.spheres.push_back(std::move(spheres));
    return;
  }
  std::vector<std::optional<Value>> places{at};
  if (at && at->is_list()) {
    const auto list = at->list();
    if (!list.empty() && list.front().is_list()) places.assign(list.begin(), list.end());
  }
  for (const auto& place : places) {
    const int frame = attach(builder, part, *on, place,
                             fmt::format("{}.sphere{}", contact.name, builder.model.frames.size()));
    if (frame >= 0) spheres.frames.push_back(frame);
  }
  contact.spheres.push_back(std::move(spheres));
}

/// What is reported once or in a list of several.
std::vector<Value> one_or_more(const Value& value) {
  return value.is_list() ? value.list() : std::vector{value};
}

void read_contact(Builder& builder, const Part& part, const Value& value, spec::Contact& contact) {
  const LawInfo& law = law_info(find_law("contact"));
  std::vector<std::string> keys{"spheres", "surfaces", "among", "swarm"};
  for (const LawNumber& number : law.numbers) keys.emplace_back(number.key);
  const Fields fields(value, keys);
  if (!value.has_fields()) return;
  if (const auto spheres = fields.need("spheres", "{on: ball, radius: 0.1}"))
    for (const Value& set : one_or_more(*spheres)) read_spheres(builder, part, set, contact);
  if (const auto surfaces = fields.get("surfaces"))
    for (const Value& surface : one_or_more(*surfaces))
      if (const auto name = surface.word())
        if (const int found = builder.resolve(builder.surface_names, part, *name, surface); found >= 0)
          contact.surfaces.push_back(found);
  if (const auto among = fields.get("among")) contact.among = among->flag().value_or(false);
  if (const auto swarm = fields.get("swarm")) {
    contact.swarm = swarm->flag().value_or(false);
    if (contact.swarm && !contact.among) swarm->error("its spheres touch one another: among: true, too");
  }
  if (!fields.has("surfaces") && !contact.among)
    value.error("touches nothing: name 'surfaces', or let the spheres touch one another by among: true");
  contact.numbers = read_numbers(law, fields, value, false);
}

}  // namespace

void read_surfaces(Builder& builder, Part& part) {
  read_each(builder, part, "surfaces", builder.surface_names, builder.model.surfaces, read_surface);
}

void read_contacts(Builder& builder, Part& part) {
  read_each(builder, part, "contacts", builder.contact_names, builder.model.contacts, read_contact);
}

}  // namespace mimbre::model_file
