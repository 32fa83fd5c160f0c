#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>

#include "base/output_place.h"
#include "mimbre/spec.h"
#include "mimbre/surface_mesh.h"
#include "mimbre/urdf.h"
#include "urdf/merged.h"
#include "urdf/mesh_paths.h"
#include "urdf/repair.h"
#include "urdf/yaml_text.h"

/// A robot's model file.
namespace mimbre {
namespace {

using namespace urdf;
namespace fs = std::filesystem;

// What URDF lacks of a stop: how long an impact takes, in default steps, and that it takes most of the
// impact's energy. Nor of friction: the presliding displacement; half a period of that takes a step at least.
constexpr double steps_of_impact = 5, steps_of_sticking = 1;
constexpr double restitution = 0.1;
constexpr double least_sticking = 1e-5;  ///< m or rad

/// The square of 1/ω of what oscillates once in twice as many default steps, s²: displacement under a
/// load by the acceleration that the load gives what is free.
double softness(double steps) {
  const double time = steps * spec::Simulation().step / EIGEN_PI;
  return time * time;
}

/// A name that a model may have: the given one, or one like it.
std::string allowed_name(const std::string& given) {
  // Suffixes need room, and characters beyond ASCII have several bytes.
  std::size_t length = std::min<std::size_t>(given.size(), 90);
  while (length < given.size() && length > 0 && (static_cast<unsigned char>(given[length]) & 0xC0) == 0x80)
    --length;
  std::string name = given.substr(0, length);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-' && c != '.' &&
        static_cast<unsigned char>(c) < 0x80)
      c = '_';
  if (name.empty() || name[0] == '.' || name[0] == '-') name = "_" + name;
  // YAML's words for other values, and the ground.
  static const std::set<std::string> taken{"ground", "all", "null", "true", "false",
                                           "yes",    "no",  "on",   "off"};
  if (taken.contains(name)) name += "_";
  return name;
}

/// Names that a model may have, each once.
class Names {
 public:
  std::string make(const std::string& given) {
    const std::string name = allowed_name(given);
    std::string free = name;
    for (int k = 2; !used_.insert(free).second; ++k) free = fmt::format("{}_{}", name, k);
    return free;
  }
  /// Of all of a kind, whose names differ: those that may stay do so, whatever comes first.
  template <class Named>
  std::vector<std::string> make_all(const std::vector<Named>& all) {
    std::vector<std::string> names(all.size());
    for (const bool stays : {true, false})
      for (std::size_t k = 0; k < all.size(); ++k)
        if ((allowed_name(all[k].name) == all[k].name) == stays) names[k] = make(all[k].name);
    return names;
  }

 private:
  std::set<std::string> used_;
};

class Writer {
 public:
  Writer(const std::string& path, const UrdfOptions& options)
      : path_(path),
        options_(options),
        robot_(read_robot(path, options.repair)),
        merged_(joined(robot_, options.keep_fixed, options.floating)) {
    links_ = places_.make_all(robot_.links);
    joints_ = couplings_.make_all(robot_.joints);
    // A root that is nothing but a name is the ground.
    const MergedBody& root = merged_.bodies.front();
    root_is_ground_ = !options.floating && root.mass == 0 && root.visuals.empty();
    result_.notes = robot_.notes;
    result_.repairs = robot_.repairs;
    for (std::size_t k = 0; k < links_.size(); ++k) say_renamed("link", robot_.links[k], links_[k]);
    for (std::size_t k = 0; k < joints_.size(); ++k)
      if (written(robot_.joints[k])) say_renamed("joint", robot_.joints[k], joints_[k]);
    const std::size_t first = root_is_ground_ ? 1 : 0;
    if (options.repair)
      for (Diagnostic& repair : urdf::repair(robot_, merged_, options.floating, first,
                                             [&](const Visual& mesh) { return box_of(mesh); }))
        result_.repairs.push_back(std::move(repair));
    for (Diagnostic& fault : faults(robot_, merged_, options.floating, first)) {
      if (!options.repair) fault.message += "; --repair does";
      result_.notes.push_back(std::move(fault));
    }
    if (merged_.bodies.size() == first)
      result_.notes.push_back(
          {Mark{path_},
           "no link has a mass or a shape, so the model has no body, and `mimbre check` refuses it"});
    inertias_ = BodyTree(robot_, merged_, options.floating).least_inertias();
  }

  ConvertedRobot write() {
    std::string text;
    text += section("bodies", bodies());
    text += section("frames", frames());
    text += section("joints", joints());
    text += section("frictions", frictions());
    text += section("stops", stops());
    text += section("constraints", mimics());
    text += section("outputs", outputs());
    say_left_out();
    std::string head =
        fmt::format("# {} as a model of mimbre.\n", comment(fs::path(path_).filename().string()));
    const auto add = [&](const char* kind, const std::vector<Diagnostic>& list) {
      for (const Diagnostic& one : list)
        head += fmt::format("#   {}{}{}\n", kind,
                            one.mark.line > 0 ? fmt::format("line {}: ", one.mark.line) : "",
                            comment(one.message));
    };
    add("", result_.notes);
    add("repaired: ", result_.repairs);
    std::string title = robot_.name.empty() ? "robot" : robot_.name;
    std::replace(title.begin(), title.end(), '$', '_');  // which would be a parameter
    result_.text = head + fmt::format("mimbre: 1\ntitle: {}\n\n", yaml_word(title)) + text;
    return std::move(result_);
  }

 private:
  static MergedRobot joined(Robot& robot, bool keep_fixed, bool floating) {
    fix_immobile_joints(robot);
    MergedRobot all = merged(robot, keep_fixed);
    // A root without mass that the ground holds does not move, and so needs no inertia.
    if (MergedBody& root = all.bodies.front(); !floating && root.mass == 0) root.inertia.setZero();
    return all;
  }
  static std::string section(const std::string& name, const std::string& content) {
    return content.empty() ? "" : fmt::format("{}:\n{}\n", name, content);
  }
  void note(const Mark& mark, const std::string& message) { result_.notes.push_back({mark, message}); }
  template <class Named>
  void say_renamed(const char* kind, const Named& one, const std::string& name) {
    if (name == one.name) return;
    note(one.mark, fmt::format("{} '{}' is called '{}' in the model", kind, one.name, name));
  }
  bool written(const Joint& joint) const { return joint.type != Joint::Type::fixed || options_.keep_fixed; }
  const Link& link(int index) const { return robot_.links[static_cast<std::size_t>(index)]; }
  const std::string& name_of_link(int index) const { return links_[static_cast<std::size_t>(index)]; }
  /// What a joint takes hold of.
  std::string body_name(int index) const {
    const int body = merged_.body_of[static_cast<std::size_t>(index)];
    return body == 0 && root_is_ground_ ? "ground"
                                        : name_of_link(merged_.bodies[static_cast<std::size_t>(body)].link);
  }

  std::string bodies() {
    std::string text;
    for (std::size_t k = root_is_ground_ ? 1 : 0; k < merged_.bodies.size(); ++k) {
      const MergedBody& body = merged_.bodies[k];
      text += fmt::format("  {}:\n    mass: {}\n    com: {}\n", yaml_word(name_of_link(body.link)),
                          number(body.mass), point(body.com));
      if (body.mass > 0 || !body.inertia.isZero(0)) {
        const Eigen::Matrix3d& J = body.inertia;
        text +=
            fmt::format("    inertia: {}\n", numbers({J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2)}));
      }
      text += fmt::format("    frame: {{at: {}{}}}\n", point(body.pose.position), axes(body.pose.rotation));
      std::string shapes;
      for (const Visual& visual : body.visuals) shapes += shape(visual);
      if (!shapes.empty()) text += "    shapes:\n" + shapes;
    }
    return text;
  }

  /// The corners of the box around a mesh, without the factors on its coordinates.
  std::optional<std::pair<Eigen::Vector3d, Eigen::Vector3d>> box_of(const Visual& visual) const {
    const auto file = find_mesh(visual.file, path_, options_.packages);
    if (!file) return {};
    try {
      const SurfaceMesh mesh = read_surface_mesh(*file);
      return std::pair(Eigen::Vector3d(mesh.vertices.rowwise().minCoeff()),
                       Eigen::Vector3d(mesh.vertices.rowwise().maxCoeff()));
    } catch (const InputError&) {
      return {};
    }
  }

  static std::string sphere(double radius, const Eigen::Vector3d& at) {
    return fmt::format("      - {{sphere: {}, at: {}}}\n", number(radius), point(at));
  }
  std::string shape(const Visual& visual) {
    const std::string place =
        fmt::format("at: {}{}", point(visual.pose.position), axes(visual.pose.rotation));
    const Eigen::Vector3d& size = visual.size;
    const bool sized =
        visual.kind == Visual::Kind::mesh ? (size.array() != 0).all() : (size.array() > 0).all();
    if (!sized) {
      note(visual.mark, "a <visual> of no size is left out");
      return "";
    }
    switch (visual.kind) {
      case Visual::Kind::box:
        return fmt::format("      - {{box: {}, {}}}\n", list(size), place);
      case Visual::Kind::cylinder:
        return fmt::format("      - {{cylinder: {}, at: {}, axis: {}}}\n", numbers({size[0], size[1]}),
                           point(visual.pose.position), list(Eigen::Vector3d(visual.pose.rotation.col(2))));
      case Visual::Kind::sphere:
        return sphere(size[0], visual.pose.position);
      case Visual::Kind::capsule: {
        const Eigen::Vector3d axis = visual.pose.rotation.col(2), end = 0.5 * size[1] * axis;
        return fmt::format("      - {{cylinder: {}, at: {}, axis: {}}}\n", numbers({size[0], size[1]}),
                           point(visual.pose.position), list(axis)) +
               sphere(size[0], visual.pose.position - end) + sphere(size[0], visual.pose.position + end);
      }
      case Visual::Kind::mesh:
        break;
    }
    std::string ending = fs::path(visual.file).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto& endings = surface_mesh_endings();
    if (ending.empty() || std::find(endings.begin(), endings.end(), ending.substr(1)) == endings.end()) {
      note(visual.mark, fmt::format("the mesh '{}' is left out: its format is not known", visual.file));
      return "";
    }
    const auto file = find_mesh(visual.file, path_, options_.packages);
    if (!file) {
      const std::string scheme = "package://";
      const bool packed = visual.file.starts_with(scheme);
      auto& [count, example] =
          missing_[packed ? visual.file.substr(scheme.size(),
                                               visual.file.find('/', scheme.size()) - scheme.size())
                          : ""];
      if (++count == 1) example = visual.file;
      return "";
    }
    std::error_code unknown;
    std::string from = *file;
    if (!options_.folder.empty())
      if (const fs::path near = fs::relative(*file, options_.folder, unknown); !unknown && !near.empty())
        from = near.string();
    return fmt::format("      - {{mesh: {}, {}{}}}\n", yaml_word(from), place,
                       size == Eigen::Vector3d::Ones() ? "" : ", scale: " + list(size));
  }

  std::string frames() const {
    std::string text;
    for (const MergedBody& body : merged_.bodies)
      for (const int index : body.frames) {
        const Pose& pose = merged_.links[static_cast<std::size_t>(index)];
        text += fmt::format("  {}: {{body: {}, at: {}{}}}\n", yaml_word(name_of_link(index)),
                            yaml_word(body_name(index)), point(pose.position), axes(pose.rotation));
      }
    if (root_is_ground_) {
      const MergedBody& root = merged_.bodies.front();
      text =
          fmt::format("  {}: {{body: ground, at: [0, 0, 0]}}\n", yaml_word(name_of_link(root.link))) + text;
    }
    return text;
  }

  std::string joints() {
    std::string text;
    if (!root_is_ground_) {
      const std::string root = name_of_link(merged_.bodies.front().link);
      text += fmt::format("  {}: {{type: {}, between: [ground, {}]}}\n",
                          yaml_word(couplings_.make(root + "_to_ground")),
                          options_.floating ? "floating" : "fixed", yaml_word(root));
    }
    for (const int index : robot_.order) {
      const int holder = robot_.held_by[static_cast<std::size_t>(index)];
      if (holder < 0) continue;
      const Joint& joint = robot_.joints[static_cast<std::size_t>(holder)];
      if (!written(joint)) continue;
      text += this->joint(joint, joints_[static_cast<std::size_t>(holder)]);
    }
    return text;
  }

  std::string joint(const Joint& joint, const std::string& name) {
    static constexpr const char* types[] = {"fixed",    "revolute", "revolute", "prismatic",
                                            "floating", "planar",   "spherical"};
    const Pose& child = merged_.links[static_cast<std::size_t>(joint.child)];
    std::string text = fmt::format("  {}: {{type: {}, between: [{}, {}]", yaml_word(name),
                                   types[static_cast<int>(joint.type)], yaml_word(body_name(joint.parent)),
                                   yaml_word(body_name(joint.child)));
    if (joint.type == Joint::Type::spherical)
      text += fmt::format(", at: {}", point(child.position));
    else if (joint.type != Joint::Type::fixed && joint.type != Joint::Type::floating)
      text += fmt::format(", at: {}, axis: {}", point(child.position),
                          list(Eigen::Vector3d(child.rotation * joint.axis)));
    const double start = start_of(joint);
    const bool outside = start != 0;
    const bool leads = std::any_of(robot_.joints.begin(), robot_.joints.end(), [&](const Joint& other) {
      return other.mimic && other.mimic->joint == joint.name;
    });
    // What follows another joint starts where that puts it.
    if (!joint.mimic && (outside || leads)) {
      text += fmt::format(", position: {}", number(start));
      if (outside)
        note(joint.mark,
             fmt::format("joint '{}' starts at {}, in the middle between its limits, which do not include 0",
                         joint.name, number(start)));
    }
    if (joint.damping > 0 && joint.scalar())
      text += fmt::format(", spring: {{stiffness: 0, damping: {}}}", number(joint.damping));
    if ((joint.damping > 0 || joint.friction > 0) && !joint.scalar())
      note(joint.mark,
           fmt::format("damping and friction of joint '{}' are left out: it is neither a hinge nor a slide",
                       joint.name));
    return text + "}\n";
  }

  template <class Line>
  std::string of_scalar_joints(const Line& line) const {
    std::string text;
    for (std::size_t k = 0; k < robot_.joints.size(); ++k)
      if (robot_.joints[k].scalar()) text += line(robot_.joints[k], joints_[k]);
    return text;
  }

  /// Behind a line: the least inertia that a joint moves within its limits.
  std::string inertia_comment(const Joint& joint) const {
    const double moved = inertia_of(joint);
    return moved > 0 ? fmt::format("  # {:.3g} {}", moved, joint.turns() ? "kg m2" : "kg") : "";
  }
  double inertia_of(const Joint& joint) const {
    return inertias_[static_cast<std::size_t>(&joint - robot_.joints.data())];
  }

  std::string frictions() {
    bool any = false;
    const std::string text = of_scalar_joints([&](const Joint& joint, const std::string& name) {
      if (joint.friction == 0) return std::string();
      const double moved = inertia_of(joint);
      const double sticking = moved > 0 ? joint.friction / moved * softness(steps_of_sticking) : 0;
      const bool soft = sticking > least_sticking;
      // The default of a length goes by the mechanism.
      const bool written = soft || !joint.turns();
      any = any || soft;
      return fmt::format("  {}: {{joint: {}, {}: {}{}}}{}\n", yaml_word(elements_.make(name + "_friction")),
                         yaml_word(name), joint.turns() ? "torque" : "force", number(joint.friction),
                         written ? fmt::format(", sticking: {:.3g}", std::max(sticking, least_sticking)) : "",
                         soft ? inertia_comment(joint) : "");
    });
    if (any)
      note({},
           fmt::format(
               "'sticking' of frictions is assumed: with the least inertia that the joint moves within "
               "the limits (behind each friction) half a period of what sticks takes a default step, so a "
               "load moves it by {:.2g} s² times the acceleration of the free joint; with steps n times as "
               "short it may be n² times as small",
               softness(steps_of_sticking)));
    return text;
  }

  std::string stops() {
    bool any = false;
    const std::string text = of_scalar_joints([&](const Joint& joint, const std::string& name) {
      if (!joint.lower) return std::string();
      any = true;
      // A joint that moves no inertia cannot run; its stop has some stiffness, so that the file is complete.
      const double moved = inertia_of(joint);
      return fmt::format("  {}: {{joint: {}, lower: {}, upper: {}, stiffness: {:.3g}, restitution: {}}}{}\n",
                         yaml_word(elements_.make(name + "_stop")), yaml_word(name), number(*joint.lower),
                         number(*joint.upper), (moved > 0 ? moved : 1) / softness(steps_of_impact),
                         number(restitution), inertia_comment(joint));
    });
    if (any)
      note({},
           fmt::format("stiffness and restitution of the stops are assumed: with the least inertia that "
                       "the joint moves within the limits (behind each stop) an impact takes {} s, {} "
                       "default steps. They are soft: an impact at 1 rad/s or m/s goes up to {:.2g} rad or m "
                       "deep, a load by {:.2g} s² times the acceleration of the free joint. With steps n "
                       "times as short they may be n² times as stiff",
                       steps_of_impact * spec::Simulation().step, steps_of_impact,
                       std::sqrt(softness(steps_of_impact)), softness(steps_of_impact)));
    return text;
  }

  /// Joints that follow others.
  std::string mimics() {
    std::string text;
    for (std::size_t k = 0; k < robot_.joints.size(); ++k) {
      const auto& mimic = robot_.joints[k].mimic;
      if (!mimic) continue;
      const auto other = static_cast<std::size_t>(
          std::find_if(robot_.joints.begin(), robot_.joints.end(),
                       [&](const Joint& joint) { return joint.name == mimic->joint; }) -
          robot_.joints.begin());
      text += fmt::format(
          "  {}: {{type: coupling, terms: [{{joint: {}, factor: 1}}, {{joint: {}, factor: {}}}], constant: "
          "{}}}\n",
          yaml_word(elements_.make(joints_[k] + "_mimic")), yaml_word(joints_[k]), yaml_word(joints_[other]),
          number(-mimic->multiplier), number(mimic->offset));
    }
    return text;
  }

  std::string outputs() const {
    return of_scalar_joints([](const Joint&, const std::string& name) {
      return fmt::format("  - {{name: {0}, joint: {0}}}\n", yaml_word(name));
    });
  }

  void say_left_out() {
    for (const auto& [package, found] : missing_) {
      const auto& [count, example] = found;
      const std::string what =
          count == 1 ? fmt::format("the mesh '{}' is left out: there is no such file", example)
                     : fmt::format("{} meshes are left out: there are no such files, for example '{}'", count,
                                   example);
      note({}, what + (package.empty()
                           ? ""
                           : fmt::format("; specify the folder of the package '{0}': --package {0}=FOLDER",
                                         package)));
    }
    std::string what;
    for (const auto& [tag, count] : robot_.left_out)
      what += fmt::format("{}{} <{}>", what.empty() ? "" : ", ", count, tag);
    if (!what.empty()) note({}, "left out: " + what);
    const auto limited = std::count_if(robot_.joints.begin(), robot_.joints.end(),
                                       [](const Joint& joint) { return joint.effort > 0; });
    if (limited > 0)
      note({},
           fmt::format(
               "limits of effort and speed of {} joints are left out; they are a matter of what drives them",
               limited));
  }

  const std::string& path_;
  const UrdfOptions& options_;
  Robot robot_;
  MergedRobot merged_;
  Names places_, couplings_,
      elements_;  ///< bodies and frames share their names; joints and forces have theirs
  std::vector<std::string> links_, joints_;
  std::map<std::string, std::pair<int, std::string>>
      missing_;  ///< meshes by package: how many, and one of them
  bool root_is_ground_ = false;
  std::vector<double> inertias_;  ///< the least that each joint moves
  ConvertedRobot result_;
};

}  // namespace

ConvertedRobot convert_urdf(const std::string& path, const UrdfOptions& options) {
  return Writer(path, options).write();
}

void save(const ConvertedRobot& robot, const std::string& path) {
  try {
    write_whole(path, robot.text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path, error.what()));
  }
}

}  // namespace mimbre
