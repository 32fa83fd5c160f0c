#include <algorithm>
#include <cctype>
#include <cmath>

#include "joints/axes.h"
#include "mimbre/reduced_body.h"
#include "spec/model_builder_parts.h"
#include "spec/nearest_place.h"

/// Names, places and frames of what is added to a builder.
namespace mimbre {
namespace {

std::string to_text(const Eigen::Vector3d& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v[0], v[1], v[2]);
}

std::vector<std::string> names_of(const NamedItems& items) {
  std::vector<std::string> names;
  for (const auto& [name, number] : items.index) names.push_back(name);
  return names;
}

int number_of(const NamedItems& items, const std::string& name) {
  const auto found = items.index.find(name);
  return found == items.index.end() ? -1 : found->second;
}

}  // namespace

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t most = 30;
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), most));
  return fmt::format("{}{}", fmt::join(names.begin(), end, ", "),
                     names.size() > most ? fmt::format(", … ({} in all)", names.size()) : "");
}

Addition::Addition(ModelBuilder::Impl& builder, const NamedItems& kind, const std::string& name)
    : builder_(builder), name_(name), called_(fmt::format("{} '{}'", kind.kind, name)) {
  if (&kind == &builder.outputs) {  // the check knows what a column may be called
    if (kind.index.contains(name)) refuse("there is an output of this name; rename one");
    return;
  }
  check_name(name, kind.kind);
  const bool place = &kind == &builder.bodies || &kind == &builder.frames;
  if (place && builder.frames.index.contains(name))
    refuse("there is a body or frame of this name (they share their names); rename one");
  if (kind.index.contains(name)) refuse(fmt::format("there is a {} of this name; rename one", kind.kind));
}

void Addition::refuse(const std::string& message) const {
  throw InputError(Mark{}, fmt::format("{}: {}", called_, message));
}

void Addition::check_name(const std::string& name, const char* kind) const {
  if (name == "ground")
    refuse(fmt::format("'ground' is the fixed world; choose another name for the {}", kind));
  const auto good = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.' || (c & 0x80);
  };
  if (name.empty() || name.size() > 100 || name[0] == '.' || name[0] == '-' ||
      !std::all_of(name.begin(), name.end(), good))
    refuse(fmt::format("is no name for a {}; names have 1 to 100 letters, digits, '_', '-' or '.'", kind));
}

void Addition::coordinates_of(const std::string& in) {
  if (in.empty() || in == "ground") return;
  const Attachment base = attachment("in", in);
  base_ = frame_pose(base.frame >= 0 ? base.frame : own_frame(base.body));
}

Eigen::Vector3d Addition::point(const char* what, const Eigen::Vector3d& given) const {
  if (!given.allFinite()) refuse(fmt::format("{} has an entry that is not finite", what));
  return base_.position + base_.rotation * given;
}

Eigen::Vector3d Addition::direction(const char* what, const Eigen::Vector3d& given) const {
  const double length = given.stableNorm();
  if (!(length > 0) || !std::isfinite(length))
    refuse(fmt::format("{}: the direction has no length; give a vector such as (0, 0, 1)", what));
  return vector(given / length);
}

spec::Pose Addition::pose(const Eigen::Vector3d& at, const build::Axes& axes) const {
  std::vector<std::pair<int, Eigen::Vector3d>> given;
  if (axes.x) given.emplace_back(0, direction("x", *axes.x));
  if (axes.y) given.emplace_back(1, direction("y", *axes.y));
  if (axes.z) given.emplace_back(2, direction("z", *axes.z));
  if (given.size() > 2) refuse("two of the axes x, y, z determine all; leave one out");
  if (given.size() == 2 && !perpendicular(given[0].second, given[1].second))
    refuse(fmt::format("the axes {} and {} are not perpendicular: they have the cosine {:.4g}",
                       "xyz"[given[0].first], "xyz"[given[1].first], given[0].second.dot(given[1].second)));
  return {point("at", at), given.empty() ? base_.rotation : axes_with(given)};
}

int Addition::find(const NamedItems& items, const char* what, const std::string& name) const {
  if (const int number = number_of(items, name); number >= 0) return number;
  const auto known = names_of(items);
  refuse(fmt::format("{}: there is no {} '{}'{}{}", what, items.kind, name, did_you_mean(name, known),
                     known.empty() ? "" : "; there are: " + listed(known)));
}

Attachment Addition::attachment(const char* what, const std::string& name) {
  if (name == "ground") return {};
  if (name.empty()) refuse(fmt::format("{} is missing; it names a body, a frame or 'ground'", what));
  if (const int body = number_of(builder_.bodies, name); body >= 0) return {body, -1};
  if (const int known = number_of(builder_.frames, name); known >= 0) return {frame(known).body, known};
  if (const auto known = builder_.node_frames.find(name); known != builder_.node_frames.end())
    return {frame(known->second).body, known->second};
  for (const auto& [node, known] : made_nodes_)
    if (node == name) return {frame(known).body, known};
  // BODY.NODE of a flexible body.
  for (auto dot = name.rfind('.'); dot != std::string::npos && dot > 0; dot = name.rfind('.', dot - 1)) {
    const int body = number_of(builder_.bodies, name.substr(0, dot));
    if (body < 0) continue;
    const auto& reduced = builder_.model.bodies[static_cast<std::size_t>(body)].flexible;
    if (!reduced) continue;
    const std::string node = name.substr(dot + 1);
    const int k = reduced->find_frame(node);
    if (k < 0) {
      std::vector<std::string> nodes;
      for (const BodyFrame& f : reduced->frames) nodes.push_back(f.name);
      refuse(fmt::format("{}: there is no body, frame or node '{}'{}; the nodes of '{}' are: {}", what, name,
                         did_you_mean(node, nodes), name.substr(0, dot), listed(nodes)));
    }
    spec::Frame at_node;
    at_node.name = name;
    at_node.body = body;
    at_node.pose.position = reduced->frames[static_cast<std::size_t>(k)].position;
    at_node.flexible_frame = k;
    made_nodes_.emplace_back(name, add(std::move(at_node)));
    return {body, made_nodes_.back().second};
  }
  auto known = names_of(builder_.frames);
  known.emplace_back("ground");
  refuse(fmt::format("{}: there is no body, frame or node '{}'{}; there are: {}", what, name,
                     did_you_mean(name, known), listed(known)));
}

int Addition::attach(const char* what, const std::string& name, const std::optional<Eigen::Vector3d>& at,
                     const std::string& new_name) {
  const Attachment found = attachment(what, name);
  if (found.frame >= 0) {
    if (at) refuse("a frame has its place already; 'at' goes with the name of a body");
    return found.frame;
  }
  if (!at) {
    if (found.body == spec::ground)
      refuse(fmt::format("{}: a point of the ground needs its place, 'at'", what));
    return own_frame(found.body);
  }
  return new_frame(new_name, found.body, {point("at", *at), body_pose(found.body).rotation});
}

int Addition::new_frame(const std::string& name, int body, const spec::Pose& global) {
  const spec::Pose outer = body_pose(body);
  spec::Frame made;
  made.name = name;
  made.body = body;
  made.pose.position = outer.rotation.transpose() * (global.position - outer.position);
  made.pose.rotation = outer.rotation.transpose() * global.rotation;
  const auto& reduced =
      body == spec::ground ? nullptr : builder_.model.bodies[static_cast<std::size_t>(body)].flexible;
  if (reduced) {
    std::vector<Eigen::Vector3d> places;
    for (const BodyFrame& f : reduced->frames) places.push_back(f.position);
    const double within = place_tolerance(places, global.position.norm() + outer.position.norm());
    made.flexible_frame = nearest_place(places, made.pose.position, within);
    // The body frame's origin moves with the body, not with the modes.
    if (made.flexible_frame < 0 && !(made.pose.position.norm() <= within)) {
      std::vector<std::string> nodes;
      for (const BodyFrame& f : reduced->frames)
        nodes.push_back(f.name + " " + to_text(outer.position + outer.rotation * f.position));
      refuse(fmt::format("flexible body '{}' has no node at {}; its nodes are: {}",
                         builder_.model.bodies[static_cast<std::size_t>(body)].name, to_text(global.position),
                         listed(nodes)));
    }
  }
  const auto taken = [&](const auto& other) { return other.first == name; };
  if (builder_.frames.index.contains(name) || std::any_of(made_names_.begin(), made_names_.end(), taken))
    refuse(fmt::format("it needs a frame '{}', but there is one of this name; rename one", name));
  const int number = add(std::move(made));
  made_names_.emplace_back(name, number);
  return number;
}

void Addition::new_body_frame(const std::string& name, int body) {
  spec::Frame own;
  own.name = name;
  own.body = body;
  made_names_.emplace_back(name, add(std::move(own)));
}

int Addition::add(spec::Frame made) {
  made_.push_back(std::move(made));
  return static_cast<int>(builder_.model.frames.size() + made_.size()) - 1;
}

const spec::Frame& Addition::frame(int number) const {
  const auto k = static_cast<std::size_t>(number), known = builder_.model.frames.size();
  return k < known ? builder_.model.frames[k] : made_[k - known];
}

spec::Pose Addition::body_pose(int body) const {
  return body == spec::ground ? spec::Pose{} : builder_.model.bodies[static_cast<std::size_t>(body)].pose;
}

spec::Pose Addition::frame_pose(int number) const {
  const spec::Frame& f = frame(number);
  const spec::Pose outer = body_pose(f.body);
  return {outer.position + outer.rotation * f.pose.position, outer.rotation * f.pose.rotation};
}

int Addition::own_frame(int body) const {
  return builder_.frames.index.at(builder_.model.bodies[static_cast<std::size_t>(body)].name);
}

std::vector<double> numbers_by_key(const Addition& addition, std::string_view kind,
                                   std::span<const LawNumber> numbers,
                                   const std::map<std::string, double>& given) {
  std::vector<std::string> known;
  std::vector<double> values;
  for (const LawNumber& number : numbers) {
    known.emplace_back(number.key);
    const auto found = given.find(known.back());
    values.push_back(found == given.end() ? number.otherwise : found->second);
  }
  for (const auto& [name, value] : given) require_known(addition, "numbers", kind, name, known);
  return values;
}

void require_numbers(const Addition& addition, std::span<const LawNumber> numbers,
                     const std::vector<double>& values, const std::map<std::string, double>& given) {
  for (std::size_t k = 0; k < values.size(); ++k)
    if (std::isnan(values[k]) && !given.contains(std::string(numbers[k].key)))
      addition.refuse(fmt::format("numbers: '{}' is missing: {}", numbers[k].key, numbers[k].about));
}

void require_known(const Addition& addition, const char* what, std::string_view kind, const std::string& name,
                   const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) == known.end())
    addition.refuse(fmt::format("{}: a '{}' has no '{}'{}; it has {}", what, kind, name,
                                did_you_mean(name, known), known.empty() ? "none" : listed(known)));
}

void Addition::commit(NamedItems& kind, std::size_t number) {
  for (spec::Frame& made : made_) builder_.model.frames.push_back(std::move(made));
  for (auto& [name, frame] : made_names_) builder_.frames.index.emplace(std::move(name), frame);
  for (auto& [name, frame] : made_nodes_) builder_.node_frames.emplace(std::move(name), frame);
  kind.index.emplace(name_, static_cast<int>(number));
}

}  // namespace mimbre
