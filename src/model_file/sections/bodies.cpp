#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "joints/axes.h"
#include "mimbre/reduced_body.h"
#include "mimbre/surface_mesh.h"
#include "model_file/sections/surface_files.h"
#include "model_file/text/builder.h"
#include "model_file/text/file_reader.h"
#include "reduction/file/mirror.h"
#include "spec/rigid_inertia.h"

/// Bodies: frames, masses, drawings.
namespace mimbre::model_file {
namespace {

/// Coordinates in which a body was written against its place: what of them lies in body axes.
struct Local {
  const Part& part;
  spec::Pose pose;
  Eigen::Vector3d point(const Eigen::Vector3d& p) const {
    return pose.rotation.transpose() * (part.place.point(p) - pose.position);
  }
};

std::optional<Eigen::Matrix3d> read_inertia(const Value& value) {
  const auto& items = value.tree().items;
  if (items.size() == 3 && items.front()->kind == Tree::Kind::list) {
    value.error("a tensor is given by six numbers, [Ixx, Iyy, Izz, Ixy, Ixz, Iyz], not by its rows");
    return {};
  }
  if (value.is_list() && value.tree().items.size() != 3 && value.tree().items.size() != 6) {
    value.error("three numbers Ixx Iyy Izz or six with Ixy Ixz Iyz are needed");
    return {};
  }
  const auto n = value.numbers(3, 6, quantity::inertia);
  if (!n) return {};
  Eigen::Matrix3d J = Eigen::Vector3d((*n)[0], (*n)[1], (*n)[2]).asDiagonal();
  if (n->size() == 6) {
    J(0, 1) = J(1, 0) = (*n)[3];
    J(0, 2) = J(2, 0) = (*n)[4];
    J(1, 2) = J(2, 1) = (*n)[5];
  }
  return J;
}

void read_rigid(const Fields& fields, const Local& local, const Eigen::Vector3d* com, spec::Body& body,
                BodyInfo& info) {
  const auto mass = fields.need("mass", "1.5");
  const auto kilograms = mass ? mass->not_negative(quantity::mass) : std::nullopt;
  body.mass = kilograms.value_or(0);
  if (com) body.com = local.point(*com);
  const auto inertia = fields.get("inertia");
  if (!inertia) {
    if (body.mass > 0) fields.error("'inertia' is missing; for example inertia: [1, 1, 1]");
    return;
  }
  if (const auto J = read_inertia(*inertia)) {
    if (kilograms) info.inertia = *inertia;
    body.inertia = local.part.place.tensor(*J);
  }
}

void read_shapes(Builder& builder, const Value& value, const Local& local, spec::Body& body) {
  const Part& part = local.part;
  for (const Value& item : value.list()) {
    const Fields fields(item, {"box", "cylinder", "sphere", "mesh", "scale", "at", "axis", "x", "y"});
    spec::Shape shape;
    const auto box = fields.get("box"), cylinder = fields.get("cylinder"), sphere = fields.get("sphere"),
               mesh = fields.get("mesh");
    if (int(box.has_value()) + int(cylinder.has_value()) + int(sphere.has_value()) + int(mesh.has_value()) !=
        1) {
      item.error(
          "one of box: [x, y, z], cylinder: [radius, length], sphere: radius, mesh: part.stl is needed");
      continue;
    }
    if (fields.has("scale") && !mesh) item.error("'scale' is for a mesh; the others have their size");
    std::vector<double> size;
    if (box) size = box->numbers(3, 3, quantity::length).value_or(std::vector<double>{1, 1, 1});
    if (cylinder) size = cylinder->numbers(2, 2, quantity::length).value_or(std::vector<double>{1, 1});
    if (sphere) size = {sphere->number(quantity::length).value_or(1)};
    for (std::size_t k = 0; k < size.size(); ++k) {
      if (!(size[k] > 0)) item.error(fmt::format("size {} is not positive", size[k]));
      shape.size[static_cast<Eigen::Index>(k)] = size[k];
    }
    if (mesh) {
      shape.mesh = read_drawn_file(builder, *mesh);
      shape.size = part.place.mirror.cwiseProduct(read_scale(fields));
      if (!shape.mesh) continue;
    }
    shape.kind = box        ? spec::Shape::Kind::box
                 : cylinder ? spec::Shape::Kind::cylinder
                 : sphere   ? spec::Shape::Kind::sphere
                            : spec::Shape::Kind::mesh;
    Eigen::Vector3d at = part.place.rotation.transpose() * (local.pose.position - part.place.translation);
    at = part.place.mirror.cwiseProduct(at);
    spec::Pose global;
    if (cylinder) {
      if (const auto given = fields.get("at")) at = given->triple(quantity::length).value_or(at);
      const auto axis = fields.get("axis");
      global.position = part.place.point(at);
      global.rotation =
          axes_with_z(part.place.vector(axis ? axis->direction().value_or(Eigen::Vector3d::UnitZ())
                                             : Eigen::Vector3d(Eigen::Vector3d::UnitZ())));
    } else {
      if (fields.has("axis")) item.error("'axis' is for cylinders; others have x and y");
      global = read_pose(part, fields, at);
    }
    shape.pose.position = local.pose.rotation.transpose() * (global.position - local.pose.position);
    shape.pose.rotation = local.pose.rotation.transpose() * global.rotation;
    body.shapes.push_back(shape);
  }
}

void read_lines(const Value& value, const Local& local, spec::Body& body) {
  for (const Value& item : value.list()) {
    if (!item.is_list() || item.tree().items.size() < 2) {
      item.error("a line is a list of two or more points: [[0, 0, 0], [1, 0, 0]]");
      continue;
    }
    std::optional<Eigen::Vector3d> last;
    for (const Value& point : item.list()) {
      const auto p = point.triple(quantity::length);
      if (!p) return;
      const Eigen::Vector3d here = local.point(*p);
      if (last) body.lines.push_back({*last, here});
      last = here;
    }
  }
}

/// The body of a file, mirrored as its part is; the same one for all that are mirrored alike.
std::shared_ptr<const ReducedBody> read_reduced(Builder& builder, const Part& part, const Value& value) {
  const auto path = value.word();
  if (!path) return nullptr;
  if (!has_folder(builder, value)) return nullptr;
  const std::string file = path_of(builder, value.mark(), *path);
  auto& images = builder.reduced_files[file];
  const auto image = [&](const Eigen::Vector3d& mirror) -> std::shared_ptr<const ReducedBody>& {
    return images[{mirror.x() < 0, mirror.y() < 0, mirror.z() < 0}];
  };
  try {
    auto& original = image(Eigen::Vector3d::Ones());
    if (!original) {
      builder.other_files.push_back(file);
      original = builder.reader->reduced_body(file);
    }
    auto& placed = image(part.place.mirror);
    if (!placed) placed = std::make_shared<const ReducedBody>(mirrored(*original, part.place.mirror));
    return placed;
  } catch (const InputError& e) {
    for (const Diagnostic& d : e.diagnostics()) value.error(to_string(d));
    return nullptr;
  }
}

void add_body_frame(Builder& builder, int index) {
  spec::Frame frame;
  frame.name = builder.model.bodies[static_cast<std::size_t>(index)].name;
  frame.mark = builder.model.bodies[static_cast<std::size_t>(index)].mark;
  frame.body = index;
  const int k = builder.add_frame(std::move(frame));
  builder.frame_names.index.emplace(builder.model.frames.back().name, k);
}

/// Which description counts: 0 rigid, 1 flexible, 2 from a file; nothing, and an error, when that is not
/// clear.
std::optional<int> chosen_description(const Fields& fields) {
  const bool rigid = fields.has("rigid") || fields.has("mass"), flexible = fields.has("flexible"),
             reduced = fields.has("reduced");
  std::optional<int> as;
  if (const auto word = fields.get("as")) {
    as = word->choice({"rigid", "flexible", "reduced"});
    if (!as) return {};
    if (*as == 0 && !rigid) {
      word->error("is rigid, but the body has no mass; add rigid: {mass: .., com: .., inertia: ..}");
      return {};
    }
    if (*as == 1 && !flexible && !reduced) {
      word->error("is flexible, but the body has no 'flexible' or 'reduced'");
      return {};
    }
    if (*as == 2 && !reduced) {
      word->error("is reduced, but the body has no 'reduced'; add the file's name");
      return {};
    }
  }
  if (!as && flexible && reduced) {
    fields.error("has both 'flexible' and 'reduced'; choose one: 'as: flexible' or 'as: reduced'");
    return {};
  }
  if (fields.has("rigid") && (fields.has("mass") || fields.has("com") || fields.has("inertia"))) {
    fields.error("mass, com and inertia stand either under 'rigid' or beside it, not both");
    return {};
  }
  if (as) return *as == 1 && !flexible ? 2 : *as;
  if (int(rigid) + int(flexible) + int(reduced) == 1) return rigid ? 0 : flexible ? 1 : 2;
  fields.error(rigid ? "has a rigid and a flexible description; choose one: 'as: rigid' or 'as: flexible'"
                     : "has no mass; give mass, com and inertia, or 'flexible', or 'reduced'");
  return {};
}

void read_body(Builder& builder, const Part& part, const Value& value, int index) {
  const Fields fields(value, {"mass", "com", "inertia", "frame", "as", "rigid", "flexible", "reduced",
                              "flexibility", "shapes", "lines"});
  // A copy: the vectors of the builder stay as they are meanwhile.
  spec::Body body = builder.model.bodies[static_cast<std::size_t>(index)];
  BodyInfo info;
  const int as = value.has_fields() ? chosen_description(fields).value_or(-1) : -1;  // -1: not clear

  const auto rigid_part = fields.get("rigid");
  const Fields rigid = rigid_part ? Fields(*rigid_part, {"mass", "com", "inertia"}) : fields;
  std::optional<Eigen::Vector3d> com;
  if (const auto given = rigid.get("com")) com = given->triple(quantity::length);

  if (const auto frame = fields.get("frame")) {
    const Fields frame_fields(*frame, {"at", "x", "y", "z"});
    body.pose = read_pose(part, frame_fields, com.value_or(Eigen::Vector3d::Zero()));
    if (!rigid.has("com") && !frame_fields.has("at"))
      frame->error("'at' is missing; for example at: [0, 0, 0]");
  } else {
    if (as > 0) fields.error("a flexible body needs its tangent frame, for example frame: {at: [0, 0, 0]}");
    if (as == 0 && !rigid.has("com")) fields.error("'com' is missing; for example com: [0, 0, 0]");
    body.pose = {part.place.point(com.value_or(Eigen::Vector3d::Zero())),
                 part.place.axes(Eigen::Matrix3d::Identity())};
  }
  const Local local{part, body.pose};

  if (rigid.has("mass") || rigid_part) {
    const Eigen::Vector3d* place = com ? &*com : nullptr;
    read_rigid(rigid, local, place, body, info);
  }
  if (const auto flexible = fields.get("flexible")) {
    auto description = read_flexible(builder, part, *flexible, body.pose, info);
    if (as == 1) {
      info.flexible = true;
      info.failed = !description;
      info.description = std::move(description);
    } else if (as == 0 && description && !fields.has("lines")) {
      const auto& mesh = description->mesh;
      for (const auto& element : mesh.elements)
        body.lines.push_back({Eigen::Vector3d(mesh.nodes.col(element.nodes[0]) + element.offsets[0]),
                              Eigen::Vector3d(mesh.nodes.col(element.nodes[1]) + element.offsets[1])});
    }
  }
  if (const auto reduced = fields.get("reduced"); reduced && as == 2) {
    body.flexible = read_reduced(builder, part, *reduced);
    info.flexible = true;
    info.failed = !body.flexible;
    info.node_names.clear();  // those of `flexible:`, beside it
    info.node_positions.clear();
    if (body.flexible)
      for (const BodyFrame& frame : body.flexible->frames) {
        info.node_names.push_back(frame.name);
        info.node_positions.push_back(frame.position);
      }
  }
  if (const auto approach = fields.get("flexibility"))
    body.elastodynamic = approach->choice({"floating_frame", "elastodynamics"}).value_or(0) == 1 && as > 0;
  if (body.elastodynamic && info.description &&
      (info.description->in_pieces() || info.description->in_segments()))
    fields.get("flexibility")
        ->error(
            "a body of several pieces (substructures, corotational, segments) does not bend by "
            "elastodynamics; take one body with modes, or floating_frame");
  if (const auto shapes = fields.get("shapes")) read_shapes(builder, *shapes, local, body);
  if (const auto lines = fields.get("lines")) read_lines(*lines, local, body);
  info.failed = info.failed || as < 0;
  builder.model.bodies[static_cast<std::size_t>(index)] = std::move(body);
  builder.bodies[static_cast<std::size_t>(index)] = std::move(info);
}

}  // namespace

spec::Pose read_pose(const Part& part, const Fields& fields, const Eigen::Vector3d& default_position) {
  spec::Pose pose;
  Eigen::Vector3d position = default_position;
  if (const auto at = fields.get("at")) position = at->triple(quantity::length).value_or(default_position);
  std::vector<std::pair<int, Eigen::Vector3d>> given;
  const char* names[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k)
    if (const auto axis = fields.get(names[k]))
      if (const auto direction = axis->direction()) given.emplace_back(k, *direction);
  if (given.size() > 2) {
    fields.error("two of x, y, z determine all; leave one out");
    given.clear();
  } else if (given.size() == 2 && !perpendicular(given[0].second, given[1].second)) {
    const auto& [i, a] = given[0];
    const auto& [j, b] = given[1];
    fields.error(fmt::format("{} and {} are not perpendicular: {} and {} have the cosine {:.4g}", names[i],
                             names[j], to_text(a), to_text(b), a.dot(b)));
    given.clear();
  }
  pose.position = part.place.point(position);
  pose.rotation = part.place.axes(axes_with(given));
  return pose;
}

void read_bodies(Builder& builder, Part& part) {
  const auto section = part.section("bodies");
  if (!section) return;
  if (!section->is_map()) return section->error("names with their descriptions are needed");
  for (const auto& entry : section->tree().entries) {
    const std::string name = part.full_name(entry.key);
    const int index = static_cast<int>(builder.model.bodies.size());
    if (!builder.claim(builder.body_names, part, name, entry.mark, index)) continue;
    spec::Body body;
    body.name = name;
    body.mark = entry.mark;
    builder.model.bodies.push_back(std::move(body));
    builder.bodies.emplace_back();
    read_body(builder, part, Value(part.reading, *entry.value, fmt::format("body '{}'", name)), index);
    add_body_frame(builder, index);
  }
}

void check_inertias(Builder& builder) {
  for (std::size_t k = 0; k < builder.bodies.size(); ++k) {
    const auto& inertia = builder.bodies[k].inertia;
    if (!inertia || builder.bodies[k].flexible) continue;
    const auto fault = inertia_fault(builder.model, k);
    if (!fault) continue;
    if (fault->harmless.empty())
      inertia->error(fault->what);
    else
      builder.warnings.push_back(
          {inertia->mark(), fmt::format("body '{}': inertia: {}; it is accepted, since {}",
                                        builder.model.bodies[k].name, fault->what, fault->harmless)});
  }
}

}  // namespace mimbre::model_file
