#include "model_file/text/builder.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "spec/nearest_place.h"

namespace mimbre::model_file {
namespace {

std::vector<std::string> attachment_names(const Builder& builder, const Part& part) {
  std::vector<std::string> names{"ground"};
  const std::string prefix = part.instance.empty() ? "" : part.instance + ".";
  for (const auto& [name, index] : builder.frame_names.index)
    names.push_back(!prefix.empty() && name.starts_with(prefix) ? name.substr(prefix.size()) : name);
  std::sort(names.begin(), names.end());
  return names;
}

int find(const std::unordered_map<std::string, int>& index, const std::string& name) {
  const auto it = index.find(name);
  return it == index.end() ? -2 : it->second;
}

/// BODY.NODE of a described node, or -2.
int find_node_frame(Builder& builder, const std::string& full_name) {
  if (full_name.size() > 300) return -2;  // longer than names can be
  if (const int known = find(builder.node_frames, full_name); known >= 0) return known;
  for (auto dot = full_name.rfind('.'); dot != std::string::npos && dot > 0;
       dot = full_name.rfind('.', dot - 1)) {
    const int body = find(builder.body_names.index, full_name.substr(0, dot));
    if (body < 0) continue;
    const BodyInfo& info = builder.bodies[static_cast<std::size_t>(body)];
    for (std::size_t k = 0; k < info.node_names.size(); ++k)
      if (info.node_names[k] == full_name.substr(dot + 1)) {
        spec::Frame frame;
        frame.name = full_name;
        frame.mark = builder.model.bodies[static_cast<std::size_t>(body)].mark;
        frame.body = body;
        frame.pose.position = info.node_positions[k];
        frame.flexible_frame = info.flexible ? static_cast<int>(k) : -1;
        return builder.node_frames[full_name] = builder.add_frame(std::move(frame));
      }
  }
  return -2;
}

/// Of BODY.NODE, where BODY has nodes: which they are, and which could be meant.
std::optional<std::string> nodes_of_body_before_dot(const Builder& builder, const std::string& full_name) {
  const auto dot = full_name.rfind('.');
  if (dot == std::string::npos) return {};
  const int body = find(builder.body_names.index, full_name.substr(0, dot));
  if (body < 0) return {};
  const auto& nodes = builder.bodies[static_cast<std::size_t>(body)].node_names;
  if (nodes.empty()) return {};
  return fmt::format("{}; the nodes of '{}' are: {}", did_you_mean(full_name.substr(dot + 1), nodes),
                     full_name.substr(0, dot), joined(nodes));
}

bool means_ground(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name == "world" || name == "earth" || name == "inertial" || name == "origin" || name == "fixed" ||
         name == "ground";
}

}  // namespace

std::optional<Value> Part::section(const std::string& key) const {
  const Tree::Entry* entry = tree->find(key);
  if (!entry || entry->value->kind == Tree::Kind::null) return {};
  return Value(reading, *entry->value, instance.empty() ? key : instance + ": " + key);
}

std::vector<std::string> Part::meanings(const std::string& name) const {
  std::vector<std::string> names;
  for (const Part* part = this; part; part = part->outer) names.push_back(part->full_name(name));
  return names;
}

std::vector<std::string> Names::list() const {
  std::vector<std::string> names;
  for (const auto& [name, k] : index) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

bool Builder::claim(Names& names, const Part& part, const std::string& full_name, const Mark& mark,
                    int index) {
  if (full_name == "ground") {
    errors.add(mark, fmt::format("'ground' is the fixed world; choose another name for the {}", names.kind));
    return false;
  }
  if (!check_name(part.reading, full_name, mark, names.kind)) return false;
  if (names.index.emplace(full_name, index).second) return true;
  errors.add(mark, fmt::format(
                       "there are two items called '{}' (bodies and frames share their names); rename the {}",
                       full_name, names.kind));
  return false;
}

void Builder::claim_end(const Names& items, const Part& part, const std::string& item, char end,
                        const Mark& mark, int frame) {
  const std::string name = fmt::format("{}.{}", item, end);
  if (!frame_names.index.contains(name)) {
    claim(frame_names, part, name, mark, frame);
    return;
  }
  const std::string what = fmt::format("{} '{}'", items.kind, item);
  if (!clashing_ends.insert(what).second) return;
  std::string other =
      fmt::format("{} '{}' is there already", body_names.index.contains(name) ? "body" : "frame", name);
  for (const Names* of : {&joint_names, &constraint_names})
    if (of != &items && of->index.contains(item))
      other = fmt::format("those of {} '{}' are called so, too", of->kind, item);
  errors.add(mark, fmt::format("{}: its ends are the frames '{}.a' and '{}.b', but {}; rename one of them",
                               what, item, item, other));
}

int Builder::known(const Names& names, const Part& part, const std::string& name) const {
  for (const std::string& full : part.meanings(name))
    if (const int found = find(names.index, full); found >= 0) return found;
  return -1;
}

int Builder::resolve(const Names& names, const Part& part, const std::string& name, const Value& value) {
  if (const int found = this->known(names, part, name); found >= 0) return found;
  const auto list = names.list();
  value.error(fmt::format("there is no {} '{}'{}{}", names.kind, name, did_you_mean(name, list),
                          list.empty() ? "" : "; there are: " + joined(list)));
  return -1;
}

int Builder::add_frame(spec::Frame frame) {
  model.frames.push_back(std::move(frame));
  return static_cast<int>(model.frames.size()) - 1;
}

spec::Pose Builder::body_pose(int body) const {
  return body == spec::ground ? spec::Pose{} : model.bodies[static_cast<std::size_t>(body)].pose;
}

spec::Pose Builder::global_pose(int frame) const {
  const spec::Frame& f = model.frames[static_cast<std::size_t>(frame)];
  const spec::Pose body = body_pose(f.body);
  return {body.position + body.rotation * f.pose.position, body.rotation * f.pose.rotation};
}

int Builder::add_frame_at(const std::string& name, int body, const Eigen::Vector3d& position,
                          const Eigen::Matrix3d& axes, const Value& value) {
  const spec::Pose pose = body_pose(body);
  spec::Frame frame;
  frame.name = name;
  frame.mark = value.mark();
  frame.body = body;
  frame.pose.position = pose.rotation.transpose() * (position - pose.position);
  frame.pose.rotation = pose.rotation.transpose() * axes;
  if (body != spec::ground) {
    const BodyInfo& info = bodies[static_cast<std::size_t>(body)];
    // The body frame's origin is where the clamped nodes hold the tangent frame: it moves with the body, not
    // the modes.
    const double within = place_tolerance(info.node_positions, position.norm() + pose.position.norm());
    const bool at_origin = frame.pose.position.norm() <= within;
    if (info.flexible && !info.failed) {
      frame.flexible_frame = nearest_place(info.node_positions, frame.pose.position, within);
      if (frame.flexible_frame < 0 && !at_origin) {
        std::vector<std::string> nodes;
        for (std::size_t k = 0; k < info.node_names.size(); ++k)
          nodes.push_back(info.node_names[k] + " " +
                          to_text(Eigen::Vector3d(pose.position + pose.rotation * info.node_positions[k])));
        value.error(fmt::format("flexible body '{}' has no named node at {}; its nodes are: {}",
                                model.bodies[static_cast<std::size_t>(body)].name, to_text(position),
                                joined(nodes)));
      }
    }
  }
  return add_frame(std::move(frame));
}

std::optional<Attachment> resolve_attachment(Builder& builder, const Part& part, const Value& value) {
  const auto name = value.word();
  if (!name) return {};
  if (*name == "ground") return Attachment{};
  const std::vector<std::string> tried = part.meanings(*name);
  for (const std::string& full : tried) {
    if (const int body = find(builder.body_names.index, full); body >= 0) return Attachment{body, -1};
    int frame = find(builder.frame_names.index, full);
    if (frame < 0) frame = find_node_frame(builder, full);
    if (frame >= 0) return Attachment{builder.model.frames[static_cast<std::size_t>(frame)].body, frame};
  }
  for (const std::string& full : tried)
    if (const auto nodes = nodes_of_body_before_dot(builder, full)) {
      value.error(fmt::format("there is no body, frame or node '{}'{}", *name, *nodes));
      return {};
    }
  const auto known = attachment_names(builder, part);
  value.error(
      fmt::format("there is no body, frame or node '{}'{}; there are: {}", *name,
                  means_ground(*name) ? " (the fixed world is called 'ground')" : did_you_mean(*name, known),
                  joined(known)));
  return {};
}

namespace {

/// Items of that name whose places are frames called ITEM.`end`.
std::vector<std::string> items_with_places(const Builder& builder, const std::string& item,
                                           const std::string& end) {
  std::vector<const Names*> kinds;
  if (end == "frame")
    kinds = {&builder.load_names, &builder.tyre_names};
  else if (end == "a" || end == "b")
    kinds = {&builder.joint_names, &builder.constraint_names, &builder.spring_names};
  else if (end == "output" || end == "reference")
    kinds = {&builder.output_names};
  for (const auto& [section, names] : builder.element_names) kinds.push_back(&names);
  std::vector<std::string> found;
  for (const Names* names : kinds)
    if (names->index.contains(item)) found.push_back(fmt::format("{} '{}'", names->kind, item));
  return found;
}

/// The frame of an item's place, ITEM.frame for example: who clashes says it by the items, as nobody named
/// the frame.
void claim_place(Builder& builder, const Part& part, const std::string& name, const Mark& mark, int frame) {
  const auto dot = name.rfind('.');
  const auto found = dot == std::string::npos
                         ? std::vector<std::string>()
                         : items_with_places(builder, name.substr(0, dot), name.substr(dot + 1));
  if (!builder.frame_names.index.contains(name) || found.empty()) {
    builder.claim(builder.frame_names, part, name, mark, frame);
    return;
  }
  if (found.size() > 1)
    builder.errors.add(
        mark, fmt::format("{} and {} both have a frame '{}' at their place; rename one of them", found[0],
                          found[1], name));
  else
    builder.errors.add(
        mark, fmt::format("{} has a frame '{}' at its place, but {} '{}' is there already; rename one "
                          "of them",
                          found[0], name, builder.body_names.index.contains(name) ? "body" : "frame", name));
}

}  // namespace

int attach(Builder& builder, const Part& part, const Value& value, const std::optional<Value>& at,
           const std::string& new_name) {
  const auto found = resolve_attachment(builder, part, value);
  if (!found) return -1;
  if (found->frame >= 0) {
    if (at) at->error("a frame has its place already; 'at' goes with the name of a body");
    return found->frame;
  }
  if (!at && found->body != spec::ground)
    return builder.frame_names.index.at(builder.model.bodies[static_cast<std::size_t>(found->body)].name);
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  if (at) {
    const auto given = at->triple(quantity::length);
    if (!given) return -1;
    position = part.place.point(*given);
  } else {
    value.error("a point of the ground needs its place: at: [x, y, z]");
    return -1;
  }
  const int frame = builder.add_frame_at(new_name, found->body, position,
                                         builder.body_pose(found->body).rotation, at ? *at : value);
  claim_place(builder, part, new_name, value.mark(), frame);
  return frame;
}

bool has_folder(const Builder& builder, const Value& value) {
  if (!builder.directory.empty()) return true;
  value.error("this model has no folder, so it cannot name other files");
  return false;
}

std::string path_of(const Builder& builder, const Mark& mark, const std::string& name) {
  namespace fs = std::filesystem;
  const bool own = mark.file.empty() || mark.file == builder.model.file;
  const fs::path folder = own ? fs::path(builder.directory) : fs::path(mark.file).parent_path();
  return folder == "." ? name : (folder / name).string();
}

std::optional<std::string> read_file(Builder& builder, const Value& value, const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code status;
  const fs::path full = path;
  if (!fs::is_regular_file(full, status)) {
    value.error(fmt::format("there is no file '{}'", full.string()));
    return {};
  }
  if (const auto size = fs::file_size(full, status); status || size > builder.limits.bytes) {
    value.error(fmt::format("'{}' is larger than {} MiB", full.string(), builder.limits.bytes >> 20));
    return {};
  }
  builder.other_files.push_back(full.string());
  std::ifstream file(full, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) {
    value.error(fmt::format("'{}' cannot be read", full.string()));
    return {};
  }
  return text.str();
}

}  // namespace mimbre::model_file
