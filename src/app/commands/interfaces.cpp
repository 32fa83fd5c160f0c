#include "app/commands/interfaces.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <sstream>

#include "mimbre/fe_import.h"

namespace mimbre::app {
namespace {

using Motion = fe::Interface::Motion;
constexpr std::array motion_words{"x", "y", "z", "rx", "ry", "rz"};

/// The name before the equals sign and what is behind it.
struct Assignment {
  std::string name, value;
};

Assignment assignment(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {text, ""};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream rest(text);
  for (std::string word; std::getline(rest, word, ',');) list.push_back(word);
  return list;
}

/// Three or six numbers; `example` shows how they are written.
std::vector<double> numbers(const std::string& option, const std::string& text, std::size_t most,
                            const char* example) {
  std::vector<double> values;
  for (const std::string& word : words(assignment(text).value)) try {
      std::size_t used = 0;
      values.push_back(std::stod(word, &used));
      if (used != word.size()) throw std::invalid_argument(word);
    } catch (const std::exception&) {
      throw UsageError(fmt::format("{} '{}': '{}' is not a number", option, text, word));
    }
  if (values.size() != 3 && values.size() != most)
    throw UsageError(fmt::format("{} '{}': {} is needed", option, text, example));
  return values;
}

/// Columns: the axes with the given z, and x as near as can be to the wanted one.
Eigen::Matrix3d axes_of(const std::string& text) {
  const std::vector<double> v = numbers("--axes", text, 6, "NAME=zx,zy,zz or NAME=zx,zy,zz,xx,xy,xz");
  Eigen::Matrix3d axes;
  axes.col(2) = Eigen::Vector3d(v[0], v[1], v[2]).normalized();
  Eigen::Vector3d x = v.size() == 6 ? Eigen::Vector3d(v[3], v[4], v[5]) : Eigen::Vector3d::UnitX();
  if (v.size() == 3 && axes.col(2).cross(x).norm() < 0.1) x = Eigen::Vector3d::UnitY();
  axes.col(1) = axes.col(2).cross(x);
  if (!(axes.col(1).norm() > 1e-6 * x.norm()) || !axes.allFinite())
    throw UsageError(fmt::format("--axes '{}': z must have a direction, x another one", text));
  axes.col(1).normalize();
  axes.col(0) = axes.col(1).cross(axes.col(2));
  return axes;
}

void set_motions(const std::string& option, const std::string& text, Motion motion,
                 fe::Interface& interface) {
  const std::string value = assignment(text).value;
  for (const std::string& word : words(value.empty() ? "x,y,z,rx,ry,rz" : value)) {
    const auto found = std::find(motion_words.begin(), motion_words.end(), word);
    if (found == motion_words.end())
      throw UsageError(
          fmt::format("{} '{}': '{}' is no motion; there are x, y, z, rx, ry, rz", option, text, word));
    Motion& own = interface.motions[static_cast<std::size_t>(found - motion_words.begin())];
    if (own != Motion::retained && own != motion)
      throw UsageError(fmt::format("{} '{}': {} is free and held at once", option, text, word));
    own = motion;
  }
}

}  // namespace

std::vector<int> nodes_of(const std::string& selection, const fe::SolidMesh& mesh,
                          const std::vector<fe::Dof>& dofs, double length_unit) try {
  return fe::select_nodes(selection, mesh, dofs, length_unit);
} catch (const std::invalid_argument& error) {
  throw UsageError(error.what());
}

std::vector<fe::Interface> read_interfaces(const InterfaceOptions& options, const fe::SolidMesh& mesh,
                                           const std::vector<fe::Dof>& dofs, double length_unit) {
  std::vector<fe::Interface> interfaces;
  for (const std::string& text : options.interfaces) {
    const auto [name, selection] = assignment(text);
    if (name.empty() || selection.empty())
      throw UsageError(fmt::format("--interface '{}': NAME=SELECTION is needed, as ball=group:ball", text));
    fe::Interface interface;
    interface.name = name;
    interface.nodes = nodes_of(selection, mesh, dofs, length_unit);
    interface.point = fe::centre_of(mesh, interface.nodes);
    interfaces.push_back(std::move(interface));
  }
  const auto find = [&](const std::string& text, const char* option) -> fe::Interface& {
    const std::string name = assignment(text).name;
    for (fe::Interface& interface : interfaces)
      if (interface.name == name) return interface;
    throw UsageError(fmt::format("{}: there is no interface '{}'", option, name));
  };
  for (const std::string& text : options.means) find(text, "--mean").tie = fe::Interface::Tie::mean;
  for (const std::string& text : options.points) {
    const std::vector<double> p = numbers("--point", text, 3, "NAME=x,y,z");
    find(text, "--point").point = length_unit * Eigen::Vector3d(p[0], p[1], p[2]);
  }
  for (const std::string& text : options.axes) find(text, "--axes").axes = axes_of(text);
  for (const std::string& text : options.freed)
    set_motions("--free", text, Motion::free, find(text, "--free"));
  for (const std::string& text : options.held)
    set_motions("--hold", text, Motion::held, find(text, "--hold"));
  return interfaces;
}

void add_interface_options(Parser& parser, InterfaceOptions& options) {
  parser
      .add_option(
          "--interface", options.interfaces,
          "Where joints and forces take hold: group:NAME, set:NAME, nodes:FILE, "
          "box(x0,y0,z0, x1,y1,z1), cylinder(px,py,pz, ax,ay,az, r). The body frame of a tangent frame "
          "moves with the first. Once for each interface, or several after one option")
      .required()
      .take_all()
      .type_name("NAME=SELECTION");
  const auto add = [&](const char* name, std::vector<std::string>& values, const char* about,
                       const char* type) {
    parser.add_option(name, values, about).repeated().type_name(type);
  };
  add("--mean", options.means, "Interface that moves as its nodes do in the mean (RBE3), not rigidly (RBE2)",
      "NAME");
  add("--point", options.points, "Reference point of an interface; default: the mean of its nodes",
      "NAME=x,y,z");
  add("--axes", options.axes,
      "Axes of an interface: its z, and where it matters its x; default: those of the model",
      "NAME=zx,zy,zz[,xx,xy,xz]");
  add("--free", options.freed,
      "Motions of an interface, in its axes, that a joint leaves free: no static modes, the dynamic ones "
      "have "
      "them; default: all",
      "NAME=x,y,z,rx,ry,rz");
  add("--hold", options.held, "Motions of an interface that never happen: no static modes; default: all",
      "NAME=x,y,z,rx,ry,rz");
}

}  // namespace mimbre::app
