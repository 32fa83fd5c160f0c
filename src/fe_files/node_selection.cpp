
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <unordered_map>

#include "fe_files/text_file.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {
namespace {

using Eigen::Vector3d;

/// The numbers between the brackets of `name(…)`; nothing when the text is something else.
std::optional<std::vector<double>> arguments(const std::string& text, const std::string& name,
                                             std::size_t count) {
  if (text.rfind(name + "(", 0) != 0) return {};
  if (text.back() != ')') throw std::invalid_argument(fmt::format("'{}' lacks its closing bracket", text));
  std::vector<double> numbers;
  const char *at = text.data() + name.size() + 1, *end = text.data() + text.size() - 1;
  while (at < end) {
    if (*at == ' ' || *at == ',') {
      ++at;
      continue;
    }
    double x = 0;
    const auto [next, error] = std::from_chars(*at == '+' ? at + 1 : at, end, x);
    if (error != std::errc() || !std::isfinite(x))
      throw std::invalid_argument(
          fmt::format("'{}': a number is needed at '{}'", text, std::string(at, end)));
    numbers.push_back(x);
    at = next;
  }
  if (numbers.size() != count)
    throw std::invalid_argument(
        fmt::format("'{}': {} needs {} numbers, there are {}", text, name, count, numbers.size()));
  return numbers;
}

Vector3d vector(const std::vector<double>& numbers, std::size_t first, double unit) {
  return unit * Vector3d(numbers[first], numbers[first + 1], numbers[first + 2]);
}

std::vector<int> from_set(const std::string& name, const SolidMesh& mesh) {
  std::vector<std::string> known;
  for (const NodeSet& set : mesh.node_sets) {
    if (set.name == name) return set.nodes;
    known.push_back(set.name);
  }
  // Names of input files count without regard to capitals.
  const auto lower = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
  };
  for (const NodeSet& set : mesh.node_sets)
    if (lower(set.name) == lower(name)) return set.nodes;
  throw std::invalid_argument(
      fmt::format("the model has no group or set '{}'; it has: {}", name,
                  known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
}

std::vector<int> from_file(const std::string& path, const SolidMesh& mesh) {
  TextFile file(path);
  std::unordered_map<std::int64_t, int> index;
  for (std::size_t k = 0; k < mesh.labels.size(); ++k) index[mesh.labels[k]] = static_cast<int>(k);
  std::vector<int> nodes;
  for (std::string_view text; file.next(text);) {
    const int number = file.line_number();
    std::string line(text);
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::string word;
    while (words >> word) {
      std::int64_t label = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), label);
      if (error != std::errc() || end != word.data() + word.size())
        throw std::invalid_argument(fmt::format("{}:{}: '{}' is not a node's number", path, number, word));
      const auto found = index.find(label);
      if (found == index.end())
        throw std::invalid_argument(fmt::format("{}:{}: the model has no node {}", path, number, label));
      nodes.push_back(found->second);
    }
  }
  return nodes;
}

}  // namespace

std::vector<int> select_nodes(const std::string& text, const SolidMesh& mesh, const std::vector<Dof>& dofs,
                              double length_unit) {
  std::vector<int> nodes;
  const auto where = [&](const auto& inside) {
    for (const Dof& dof : dofs)
      if (dof.direction == 0 && inside(Vector3d(mesh.nodes.col(dof.node)))) nodes.push_back(dof.node);
  };
  if (text.rfind("group:", 0) == 0)
    nodes = from_set(text.substr(6), mesh);
  else if (text.rfind("set:", 0) == 0)
    nodes = from_set(text.substr(4), mesh);
  else if (text.rfind("nodes:", 0) == 0)
    nodes = from_file(text.substr(6), mesh);
  else if (const auto box = arguments(text, "box", 6)) {
    const double margin = 1e-6 * (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
    const Vector3d a = vector(*box, 0, length_unit), b = vector(*box, 3, length_unit);
    const Vector3d low = a.cwiseMin(b).array() - margin, high = a.cwiseMax(b).array() + margin;
    where([&](const Vector3d& r) {
      return (r.array() >= low.array()).all() && (r.array() <= high.array()).all();
    });
  } else if (const auto cylinder = arguments(text, "cylinder", 7)) {
    const Vector3d point = vector(*cylinder, 0, length_unit), axis = vector(*cylinder, 3, 1);
    const double radius = length_unit * cylinder->back();
    if (!(axis.norm() > 0) || !(radius > 0))
      throw std::invalid_argument(
          fmt::format("'{}': the axis needs a length and the radius must be positive", text));
    where([&](const Vector3d& r) {
      return std::abs((r - point).cross(axis.normalized()).norm() - radius) <= 0.01 * radius;
    });
  } else {
    throw std::invalid_argument(
        fmt::format("'{}' selects nothing: use group:NAME, set:NAME, nodes:FILE, "
                    "box(x0,y0,z0, x1,y1,z1) or cylinder(px,py,pz, ax,ay,az, r)",
                    text));
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  if (nodes.empty()) throw std::invalid_argument(fmt::format("'{}': no node of the model is there", text));
  return nodes;
}

}  // namespace mimbre::fe
