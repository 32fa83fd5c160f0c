#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <string_view>

#include "math/turn.h"
#include "urdf/robot.h"

/// URDF by its description in ROS's wiki (urdf/XML).
namespace mimbre::urdf {
namespace {

using pugi::xml_node;

constexpr std::size_t most_bytes = 64u << 20;

class Reader {
 public:
  Reader(const std::string& path, const std::string& text, bool repair)
      : path_(path), text_(text), repair_(repair) {
    for (std::size_t k = 0; k < text.size(); ++k)
      if (text[k] == '\n') ends_.push_back(k);
  }

  Robot read() {
    pugi::xml_document document;
    const auto result = document.load_buffer(text_.data(), text_.size());
    if (!result) throw InputError(at(result.offset), fmt::format("is no XML: {}", result.description()));
    const xml_node root = document.child("robot");
    if (!root) throw InputError(Mark{path_, 1, 1}, "is no URDF: it has no <robot>");
    Robot robot;
    robot.name = root.attribute("name").value();
    for (const xml_node node : root.children()) {
      if (node.type() != pugi::node_element) continue;
      const std::string tag = node.name();
      if (tag.starts_with("xacro:"))
        throw InputError(
            mark(node),
            fmt::format("<{}>: this is a macro file; write it out with the program xacro first", tag));
      if (tag == "link")
        robot.links.push_back(link(node, robot));
      else if (tag == "joint")
        joints_.push_back(node);
      else if (tag != "material")
        ++robot.left_out[tag];
    }
    name_links(robot);
    for (const xml_node node : joints_) robot.joints.push_back(joint(node));
    if (robot.links.empty()) error(root, "has no links");
    check_joints(robot);
    if (errors_.empty()) order(robot);
    if (!errors_.empty()) throw InputError(errors_);
    robot.notes = std::move(notes_);
    robot.repairs = std::move(repairs_);
    return robot;
  }

 private:
  Mark at(std::ptrdiff_t offset) const {
    const auto place = static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0));
    const auto line = std::lower_bound(ends_.begin(), ends_.end(), place);
    const std::size_t start = line == ends_.begin() ? 0 : *(line - 1) + 1;
    return {path_, static_cast<int>(line - ends_.begin()) + 1, static_cast<int>(place - start) + 1};
  }
  Mark mark(const xml_node& node) const { return at(node.offset_debug() - 1); }
  void error(const xml_node& node, const std::string& message) { errors_.push_back({mark(node), message}); }
  void repaired(const xml_node& node, const std::string& message) {
    repairs_.push_back({mark(node), message});
  }
  /// An error that has only one sensible repair.
  void error_or_repair(const xml_node& node, const std::string& wrong, const std::string& repair) {
    if (repair_)
      repaired(node, wrong + ": " + repair);
    else
      error(node, wrong);
  }

  /// Finite numbers, blanks between; empty where something else stands there.
  static std::vector<double> finite_numbers(const std::string& text) {
    std::vector<double> values;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
      double value = 0;
      const char* first = word.data() + (word.starts_with('+') ? 1 : 0);
      const auto [end, status] = std::from_chars(first, word.data() + word.size(), value);
      if (status != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
      values.push_back(value);
    }
    return values;
  }

  std::vector<double> numbers(const xml_node& node, const char* attribute, std::size_t count) {
    std::string text = node.attribute(attribute).value();
    std::vector<double> values = finite_numbers(text);
    if (values.size() == count) return values;
    if (repair_) {
      std::string blanks = text;
      std::replace(blanks.begin(), blanks.end(), ',', ' ');
      values = finite_numbers(blanks);
      if (values.size() >= count) {
        values.resize(count);
        repaired(node, fmt::format("<{}>: {}=\"{}\" is not {} finite numbers: {} is read", node.name(),
                                   attribute, text, count, fmt::join(values, " ")));
        return values;
      }
    }
    error(node, fmt::format("<{}>: {}=\"{}\" is not {} finite number{}", node.name(), attribute, text,
                            count == 1 ? "a" : fmt::format("{}", count), count == 1 ? "" : "s"));
    return std::vector<double>(count, 0);
  }
  double number(const xml_node& node, const char* attribute, std::optional<double> fallback = {}) {
    if (node.attribute(attribute)) return numbers(node, attribute, 1).front();
    if (!fallback) error(node, fmt::format("<{}> has no '{}'", node.name(), attribute));
    return fallback.value_or(0);
  }
  Eigen::Vector3d triple(const xml_node& node, const char* attribute, const Eigen::Vector3d& fallback) {
    if (!node.attribute(attribute)) return fallback;
    const auto n = numbers(node, attribute, 3);
    return {n[0], n[1], n[2]};
  }
  /// Roll, pitch, yaw about fixed axes x, y, z: Rz Ry Rx.
  Pose origin(const xml_node& parent) {
    const xml_node node = parent.child("origin");
    const Eigen::Vector3d rpy = triple(node, "rpy", Eigen::Vector3d::Zero());
    const auto turn = [](double angle, int axis) { return turn_about(Eigen::Vector3d::Unit(axis), angle); };
    return {triple(node, "xyz", Eigen::Vector3d::Zero()),
            turn(rpy[2], 2) * turn(rpy[1], 1) * turn(rpy[0], 0)};
  }
  std::string name(const xml_node& node) {
    const std::string name = node.attribute("name").value();
    if (name.empty()) error(node, fmt::format("<{}> has no name", node.name()));
    return name;
  }

  Link link(const xml_node& node, Robot& robot) {
    Link link;
    link.name = name(node);
    link.mark = mark(node);
    if (const xml_node inertial = node.child("inertial")) read_inertia(inertial, link);
    for (const xml_node part : node.children()) {
      const std::string tag = part.name();
      if (tag == "visual") {
        read_shapes(part, link, link.visuals);
      } else if (part.type() == pugi::node_element && tag != "inertial") {
        ++robot.left_out[tag];
        if (tag == "collision" && repair_) read_shapes(part, link, link.collisions);
      }
    }
    return link;
  }

  void read_inertia(const xml_node& node, Link& link) {
    const Pose pose = origin(node);
    link.com = pose.position;
    if (const xml_node mass = node.child("mass")) {
      link.mass = number(mass, "value");
      if (link.mass < 0) {
        error_or_repair(mass, fmt::format("link '{}': mass {} is negative", link.name, link.mass), "0");
        link.mass = 0;
      }
    }
    const xml_node tensor = node.child("inertia");
    if (!tensor) return;
    const double xx = number(tensor, "ixx"), yy = number(tensor, "iyy"), zz = number(tensor, "izz");
    const double xy = number(tensor, "ixy", 0), xz = number(tensor, "ixz", 0), yz = number(tensor, "iyz", 0);
    Eigen::Matrix3d own;
    own << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    link.inertia = pose.rotation * own * pose.rotation.transpose();
  }

  /// All shapes of a <visual> or <collision>; URDF has one in each, some files have several.
  void read_shapes(const xml_node& node, const Link& link, std::vector<Visual>& shapes) {
    const Pose pose = origin(node);
    bool any = false;
    for (const xml_node shape : node.child("geometry").children()) {
      if (shape.type() != pugi::node_element) continue;
      any = true;
      if (const auto visual = this->shape(shape, pose)) {
        shapes.push_back(*visual);
        continue;
      }
      // It is only drawn, or an aid to guess a mass: the robot moves without it.
      if (&shapes == &link.visuals)
        notes_.push_back(
            {mark(node),
             fmt::format("link '{}': a <visual> of the kind <{}> is left out; box, cylinder, sphere, "
                         "capsule and mesh are known",
                         link.name, shape.name())});
    }
    if (!any && &shapes == &link.visuals)
      notes_.push_back(
          {mark(node), fmt::format("link '{}': a <visual> without a <geometry> is left out", link.name)});
  }

  /// None of a kind that is not known.
  std::optional<Visual> shape(const xml_node& node, const Pose& pose) {
    Visual visual;
    visual.mark = mark(node);
    visual.pose = pose;
    visual.size = Eigen::Vector3d::Ones();
    const std::string_view kind = node.name();
    if (kind == "box") {
      visual.kind = Visual::Kind::box;
      visual.size = triple(node, "size", Eigen::Vector3d::Zero());
    } else if (kind == "cylinder") {
      visual.kind = Visual::Kind::cylinder;
      visual.size = {number(node, "radius"), number(node, "length"), 1};
    } else if (kind == "sphere") {
      visual.kind = Visual::Kind::sphere;
      visual.size = {number(node, "radius"), 1, 1};
    } else if (kind == "capsule") {
      visual.kind = Visual::Kind::capsule;
      visual.size = {number(node, "radius"), number(node, "length"), 1};
    } else if (kind == "mesh") {
      visual.kind = Visual::Kind::mesh;
      visual.file = node.attribute("filename").value();
      visual.size = triple(node, "scale", Eigen::Vector3d::Ones());
      if (visual.file.empty()) error(node, "<mesh> has no filename");
    } else {
      return {};
    }
    return visual;
  }

  void name_links(const Robot& robot) {
    for (std::size_t k = 0; k < robot.links.size(); ++k)
      if (!links_.emplace(robot.links[k].name, static_cast<int>(k)).second)
        errors_.push_back(
            {robot.links[k].mark, fmt::format("there are two links '{}'", robot.links[k].name)});
  }

  int link_of(const xml_node& node, const char* end) {
    const std::string name = node.child(end).attribute("link").value();
    const auto found = links_.find(name);
    if (found != links_.end()) return found->second;
    std::vector<std::string> known;
    for (const auto& [other, index] : links_) known.push_back(other);
    error(node, fmt::format("joint '{}': {} link '{}' is not there{}", node.attribute("name").value(), end,
                            name, did_you_mean(name, known)));
    return -1;
  }

  Joint joint(const xml_node& node) {
    Joint joint;
    joint.name = name(node);
    joint.mark = mark(node);
    // The last is no type of URDF's, but pybullet's.
    static const std::vector<std::string> types{"fixed",    "revolute", "continuous", "prismatic",
                                                "floating", "planar",   "spherical"};
    const std::string type = node.attribute("type").value();
    const auto found = std::find(types.begin(), types.end(), type);
    if (found == types.end())
      error(node,
            fmt::format("joint '{}': there is no type '{}'{}", joint.name, type, did_you_mean(type, types)));
    else
      joint.type = static_cast<Joint::Type>(found - types.begin());
    joint.parent = link_of(node, "parent");
    joint.child = link_of(node, "child");
    joint.pose = origin(node);
    if (const xml_node axis = node.child("axis")) {
      joint.axis = triple(axis, "xyz", Eigen::Vector3d::UnitX());
      if (const double length = joint.axis.stableNorm(); length > 1e-9)
        joint.axis /= length;
      else if (joint.scalar() || joint.type == Joint::Type::planar)
        error(axis, fmt::format("joint '{}': the axis has no length", joint.name));
    }
    if (const xml_node limit = node.child("limit"); limit && joint.scalar()) {
      joint.effort = number(limit, "effort", 0);
      if (joint.type != Joint::Type::continuous && (limit.attribute("lower") || limit.attribute("upper"))) {
        joint.lower = number(limit, "lower", 0);
        joint.upper = number(limit, "upper", 0);
        if (*joint.lower > *joint.upper) {
          error_or_repair(limit,
                          fmt::format("joint '{}': the lower limit {} is above the upper limit {}",
                                      joint.name, *joint.lower, *joint.upper),
                          "it has no limits");
          joint.lower.reset(), joint.upper.reset();
        }
      }
    }
    if (const xml_node dynamics = node.child("dynamics")) {
      joint.damping = number(dynamics, "damping", 0);
      joint.friction = number(dynamics, "friction", 0);
      if (joint.damping < 0 || joint.friction < 0)
        error(dynamics, fmt::format("joint '{}': damping and friction cannot be negative", joint.name));
    }
    if (const xml_node mimic = node.child("mimic"))
      joint.mimic = {mimic.attribute("joint").value(), number(mimic, "multiplier", 1),
                     number(mimic, "offset", 0)};
    return joint;
  }

  void check_joints(Robot& robot) {
    std::map<std::string, const Joint*> known;
    std::vector<std::string> names;
    for (const Joint& joint : robot.joints) {
      if (!known.emplace(joint.name, &joint).second)
        errors_.push_back({joint.mark, fmt::format("there are two joints '{}'", joint.name)});
      names.push_back(joint.name);
    }
    const auto follows = [](const Joint& joint) {
      return joint.scalar() || joint.type == Joint::Type::fixed;
    };
    for (Joint& joint : robot.joints) {
      if (!joint.mimic) continue;
      const auto other = known.find(joint.mimic->joint);
      if (other == known.end() && repair_) {
        repairs_.push_back(
            {joint.mark, fmt::format("joint '{}' mimics '{}', which is not there: it moves freely",
                                     joint.name, joint.mimic->joint)});
        joint.mimic.reset();
      } else if (other == known.end())
        errors_.push_back(
            {joint.mark, fmt::format("joint '{}' mimics '{}', which is not there{}", joint.name,
                                     joint.mimic->joint, did_you_mean(joint.mimic->joint, names))});
      else if (!follows(joint) || !follows(*other->second))
        errors_.push_back(
            {joint.mark, fmt::format("joint '{}' mimics '{}'; both must turn about or slide along an axis",
                                     joint.name, joint.mimic->joint)});
    }
  }

  /// Each link behind what carries it.
  void order(Robot& robot) {
    robot.held_by.assign(robot.links.size(), -1);
    std::vector<std::vector<int>> carried(robot.links.size());
    for (std::size_t k = 0; k < robot.joints.size(); ++k) {
      const Joint& joint = robot.joints[k];
      int& holder = robot.held_by[static_cast<std::size_t>(joint.child)];
      if (holder >= 0)
        errors_.push_back(
            {joint.mark,
             fmt::format(
                 "link '{}' is the child of joint '{}' and of joint '{}'; a URDF is a tree, without loops",
                 robot.links[static_cast<std::size_t>(joint.child)].name,
                 robot.joints[static_cast<std::size_t>(holder)].name, joint.name)});
      else
        holder = static_cast<int>(k);
      carried[static_cast<std::size_t>(joint.parent)].push_back(joint.child);
    }
    std::vector<int> roots;
    for (std::size_t k = 0; k < robot.links.size(); ++k)
      if (robot.held_by[k] < 0) roots.push_back(static_cast<int>(k));
    if (roots.size() > 1)
      errors_.push_back(
          {robot.links[static_cast<std::size_t>(roots[1])].mark,
           fmt::format("links '{}' and '{}' are both carried by nothing; all links must hang together",
                       robot.links[static_cast<std::size_t>(roots[0])].name,
                       robot.links[static_cast<std::size_t>(roots[1])].name)});
    if (!errors_.empty()) return;
    std::vector<int> open = roots;
    while (!open.empty()) {
      const int link = open.back();
      open.pop_back();
      robot.order.push_back(link);
      const auto& next = carried[static_cast<std::size_t>(link)];
      open.insert(open.end(), next.rbegin(), next.rend());
    }
    if (robot.order.size() < robot.links.size())
      errors_.push_back(
          {robot.links.front().mark, "some links carry each other in a ring; a URDF is a tree"});
  }

  const std::string& path_;
  const std::string& text_;
  std::vector<std::size_t> ends_;  ///< of lines
  std::vector<xml_node> joints_;
  std::map<std::string, int> links_;
  bool repair_;
  std::vector<Diagnostic> errors_, notes_, repairs_;
};

}  // namespace

Robot read_robot(const std::string& path, bool repair) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status))
    throw InputError(Mark{path, 0, 0}, "there is no such file");
  if (std::filesystem::file_size(path, status) > most_bytes || status)
    throw InputError(Mark{path, 0, 0}, fmt::format("is larger than {} MiB", most_bytes >> 20));
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw InputError(Mark{path, 0, 0}, "cannot be read");
  const std::string content = text.str();
  return Reader(path, content, repair).read();
}

}  // namespace mimbre::urdf
