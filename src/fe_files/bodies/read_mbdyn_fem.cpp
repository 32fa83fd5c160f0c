#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "fe_files/bodies/cross_integrals.h"
#include "fe_files/bodies/frame_force_stiffness.h"
#include "fe_files/bodies/mbdyn_terms.h"
#include "fe_files/bodies/reduced_files.h"
#include "fe_files/text.h"
#include "mimbre/reduced_body.h"
#include "reduction/shape_integrals.h"

namespace mimbre::fe {
namespace {

constexpr int kGroups = 19;

struct Group {
  std::vector<double> values;
  Mark mark;
};

struct Fem {
  TextFile& file;
  std::int64_t nodes = 0, modes = 0;
  std::vector<std::string> labels;
  std::map<int, Group> groups;

  bool has(int group) const { return groups.count(group) > 0; }
  const std::vector<double>& values(int group) const { return groups.at(group).values; }
};

/// The number in "** RECORD GROUP 12, ..."; 0: another comment.
int group_number(std::string_view line, const TextFile& file) {
  const std::string text = lower(line);
  const std::size_t at = text.find("record group");
  if (at == std::string::npos) return 0;
  std::string_view rest = std::string_view(text).substr(at + 12);
  std::string_view word = next_word(rest);
  while (!word.empty() && (word.back() == ',' || word.back() == ':' || word.back() == '.'))
    word.remove_suffix(1);
  const auto number = to_integer(word);
  if (!number || *number < 1 || *number > kGroups)
    file.fail(fmt::format("record group '{}' is not one of 1 to {}", shown(word), kGroups));
  return static_cast<int>(*number);
}

void read_head(std::string_view line, Fem& fem) {
  next_word(line);  // the revision
  std::array<std::int64_t, 5> counts{};
  for (std::int64_t& count : counts) {
    const std::string_view word = next_word(line);
    const auto value = word.empty() ? std::optional<std::int64_t>(0) : to_integer(word);
    if (!value || *value < 0 || *value > 10'000'000)
      fem.file.fail(fmt::format("'{}' is no count of nodes or modes", shown(word)));
    count = *value;
  }
  fem.nodes = counts[0];
  fem.modes = counts[1] + counts[2] + counts[3] - counts[4];
  if (fem.nodes < 1)
    fem.file.fail("has no nodes: the head is 'REV0 nodes normal attachment constraint rejected'");
  if (fem.modes < 0) fem.file.fail("has more rejected modes than modes");
}

Fem read_groups(TextFile& file) {
  Fem fem{file, 0, 0, {}, {}};
  std::string_view line;
  int group = 0;
  bool head = false;
  while (file.next(line)) {
    line = trimmed(line);
    if (line.empty()) continue;
    if (line.starts_with("**")) {
      const int number = group_number(line, file);
      if (number == 0) continue;
      group = number;
      if (!fem.groups.emplace(group, Group{{}, file.mark()}).second)
        file.fail(fmt::format("record group {} is there twice", group));
      continue;
    }
    if (group == 0) file.fail("is no .fem file: '** RECORD GROUP 1' must stand before the first numbers");
    if (group == 1) {
      if (!head) read_head(line, fem);
      head = true;
      continue;
    }
    while (true) {
      const std::string_view word = next_word(line);
      if (word.empty()) break;
      if (group == 2) {
        fem.labels.emplace_back(word);
        continue;
      }
      const auto value = to_real(word);
      if (!value) file.fail(fmt::format("'{}' in record group {} is no finite number", shown(word), group));
      fem.groups[group].values.push_back(*value);
    }
  }
  if (!head) file.fail("has no record group 1");
  return fem;
}

/// Numbers of each matrix of record group 19, with its index.
std::int64_t stiffening_size(const Fem& fem) { return 1 + fem.modes * fem.modes; }

void check_stiffening(const Fem& fem) {
  const Group& group = fem.groups.at(19);
  const auto fail = [&](const std::string& message) {
    throw InputError(group.mark, "record group 19 " + message);
  };
  const auto whole = [](double value, double most) {
    return value >= 0 && value <= most && value == std::floor(value);
  };
  if (group.values.empty() || !whole(group.values[0], 12.0 + 6.0 * static_cast<double>(fem.nodes)))
    fail("must begin with the number of its matrices, one of each load at most");
  const auto count = static_cast<std::int64_t>(group.values[0]);
  const auto size = static_cast<std::int64_t>(group.values.size());
  if (size != 1 + count * stiffening_size(fem))
    fail(fmt::format("has {} numbers, {} are needed", size, 1 + count * stiffening_size(fem)));
  std::set<std::int64_t> indices;
  for (std::int64_t k = 0; k < count; ++k) {
    const double index = group.values[static_cast<std::size_t>(1 + k * stiffening_size(fem))];
    if (!whole(index, 12.0 + 6.0 * static_cast<double>(fem.nodes)) || index == 0)
      fail(fmt::format("has the index {}: 1 to 12 are loads of inertia, then come six of each node", index));
    if (!indices.insert(static_cast<std::int64_t>(index)).second)
      fail(fmt::format("has the index {} twice", index));
  }
}

void check_groups(const Fem& fem) {
  const std::int64_t n = fem.modes;
  const std::map<int, std::int64_t> sizes = {
      {5, fem.nodes},  {6, fem.nodes}, {7, fem.nodes},      {8, 6 * n * fem.nodes},
      {9, n * n},      {10, n * n},    {11, 6 * fem.nodes}, {12, 13},
      {13, n * n},     {14, 3 * n},    {15, 3 * n},         {16, 9 * n},
      {17, 3 * n * n}, {18, 9 * n * n}};
  for (const int group : {2, 5, 6, 7, 8, 9, 10})
    if (!fem.has(group)) fem.file.fail(fmt::format("ends without record group {}", group));
  if (static_cast<std::int64_t>(fem.labels.size()) != fem.nodes)
    throw InputError(fem.groups.at(2).mark, fmt::format("record group 2 has {} nodes, the head has {}",
                                                        fem.labels.size(), fem.nodes));
  if (fem.has(19)) check_stiffening(fem);
  for (const auto& [group, size] : sizes)
    if (fem.has(group) && static_cast<std::int64_t>(fem.values(group).size()) != size)
      throw InputError(fem.groups.at(group).mark, fmt::format("record group {} has {} numbers, {} are needed",
                                                              group, fem.values(group).size(), size));
  if (!fem.has(11) && !fem.has(12)) fem.file.fail("has no mass: record group 11 or 12 is needed");
  std::set<std::string> labels;
  for (const std::string& label : fem.labels)
    if (!labels.insert(label).second)
      throw InputError(fem.groups.at(2).mark, fmt::format("node {} is there twice", shown(label)));
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
Eigen::MatrixXd matrix(const Fem& fem, int group, Eigen::Index rows, Eigen::Index columns) {
  return Eigen::Map<const RowMajor>(fem.values(group).data(), rows, columns);
}

/// Positions and modes of the nodes, as frames and for drawing.
void read_nodes(const Fem& fem, ReducedBody& body) {
  const auto nodes = static_cast<Eigen::Index>(fem.nodes);
  body.nodes.resize(3, nodes);
  body.node_shapes.resize(3 * nodes, body.modes);
  for (Eigen::Index i = 0; i < nodes; ++i) {
    BodyFrame frame;
    const std::string& label = fem.labels[static_cast<std::size_t>(i)];
    frame.name = to_integer(label) ? "node " + label : label;
    for (int axis = 0; axis < 3; ++axis)
      body.nodes(axis, i) = fem.values(5 + axis)[static_cast<std::size_t>(i)];
    frame.position = body.nodes.col(i);
    frame.X.resize(3, body.modes);
    frame.X_theta.resize(3, body.modes);
    for (int m = 0; m < body.modes; ++m) {
      const auto shape = Eigen::Map<const Eigen::VectorXd>(fem.values(8).data() + 6 * (m * nodes + i), 6);
      frame.X.col(m) = shape.head<3>();
      frame.X_theta.col(m) = shape.tail<3>();
    }
    body.node_shapes.middleRows<3>(3 * i) = frame.X;
    body.frames.push_back(std::move(frame));
  }
}

/// Everything from masses at the nodes; returns their modal mass matrix.
Eigen::MatrixXd add_lumped(const Fem& fem, ReducedBody& body) {
  clear_shape_integrals(body, body.modes);
  Eigen::MatrixXd modal = Eigen::MatrixXd::Zero(body.modes, body.modes);
  for (std::size_t i = 0; i < static_cast<std::size_t>(fem.nodes); ++i) {
    const BodyFrame& frame = body.frames[i];
    const double* lumped = fem.values(11).data() + 6 * i;
    const Eigen::Vector3d J(lumped[3], lumped[4], lumped[5]);
    add_mass_point(body, lumped[0], frame.position, frame.X);
    modal += lumped[0] * frame.X.transpose() * frame.X +
             frame.X_theta.transpose() * J.asDiagonal() * frame.X_theta;
    body.second_moment += second_moment_of(J.asDiagonal());
    const Eigen::Matrix3Xd turning = J.asDiagonal() * frame.X_theta;
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      body.S_position[static_cast<std::size_t>(a)].row(b) += 0.5 * turning.row(k);
      body.S_position[static_cast<std::size_t>(b)].row(a) -= 0.5 * turning.row(k);
    }
  }
  complete_shape_integrals(body);
  return modal;
}

void read_rigid(const Fem& fem, ReducedBody& body) {
  const std::vector<double>& values = fem.values(12);
  body.mass = values[0];
  const Eigen::Vector3d centre(values[1], values[2], values[3]);
  const Eigen::Matrix3d central =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data() + 4);
  body.first_moment = body.mass * centre;
  body.second_moment = second_moment_of(central) + body.mass * centre * centre.transpose();
}

/// I5_jk without I9: what its antisymmetric part determines.
Eigen::Matrix3d from_cross(const Eigen::Vector3d& cross) {
  Eigen::Matrix3d result;
  result << 0, cross.z(), -cross.y(), -cross.z(), 0, cross.x(), cross.y(), -cross.x(), 0;
  return 0.5 * result;
}

/// Record group 19; what of it could not be taken.
std::string read_stiffening(const Fem& fem, ReducedBody& body) {
  FrameForceStiffness given;
  given.forces.resize(6 * body.frames.size());
  const std::vector<double>& values = fem.values(19);
  for (std::size_t at = 1; at < values.size(); at += static_cast<std::size_t>(stiffening_size(fem))) {
    const auto index = static_cast<std::size_t>(values[at]) - 1;
    (index < 12 ? given.inertia[static_cast<std::size_t>(kStiffeningLoads[index])]
                : given.forces[index - 12]) =
        Eigen::Map<const RowMajor>(values.data() + at + 1, body.modes, body.modes);
  }
  return take_frame_forces(given, body);
}

void read_invariants(const Fem& fem, ReducedBody& body, std::vector<Diagnostic>& warnings) {
  const int n = body.modes;
  if (fem.has(14)) body.S = matrix(fem, 14, 3, n);
  std::vector<Eigen::Matrix3d> position;
  for (int m = 0; m < n; ++m) position.push_back(position_integral(body, m));
  Eigen::Matrix3Xd coupling = angular_coupling(body);
  if (fem.has(16)) {
    const Eigen::MatrixXd I8 = matrix(fem, 16, 3, 3 * n);
    for (int m = 0; m < n; ++m) {
      const Eigen::Matrix3d block = I8.middleCols<3>(3 * m);
      // I8 = tr(A) I − A with A = ∫ φ uᵀ dm
      position[static_cast<std::size_t>(m)] = 0.5 * block.trace() * Eigen::Matrix3d::Identity() - block;
    }
  }
  if (fem.has(15)) coupling = matrix(fem, 15, 3, n);
  set_position_integrals(position, coupling, body);
  if (fem.has(18)) {
    const Eigen::MatrixXd I9 = matrix(fem, 18, 3, 3 * n * n);
    // φ_j~ φ_k~ = φ_k φ_jᵀ − (φ_j · φ_k) I
    const auto integral = [&](int k, int j) -> Eigen::Matrix3d {
      const Eigen::Matrix3d block = I9.middleCols<3>(3 * (j * n + k));
      return block - 0.5 * block.trace() * Eigen::Matrix3d::Identity();
    };
    set_mode_integrals(n, integral, body);
  } else if (fem.has(17) && !fem.has(11)) {
    const Eigen::MatrixXd I5 = matrix(fem, 17, 3, n * n);
    set_mode_integrals(
        n, [&](int j, int k) { return from_cross(I5.col(j * n + k)); }, body);
    warnings.push_back({{fem.file.name(), 0, 0},
                        "has no record group 18: the inertia tensor has no products of amplitudes"});
  }
}

}  // namespace

ImportedBody parse_mbdyn_fem(TextFile& file) {
  const Fem fem = read_groups(file);
  check_groups(fem);
  const Mark mark{file.name(), 0, 0};
  ImportedBody result;
  const int n = static_cast<int>(fem.modes);
  result.body = empty_body(n);
  ReducedBody& body = result.body;
  read_nodes(fem, body);
  body.mass_matrix = matrix(fem, 9, n, n);
  body.stiffness = matrix(fem, 10, n, n);
  if (fem.has(13)) body.damping = matrix(fem, 13, n, n);
  if (fem.has(11)) {
    const Eigen::MatrixXd lumped = add_lumped(fem, body);
    if (n > 0 && body.mass_matrix.isZero(0)) {
      body.mass_matrix = lumped;
      result.warnings.push_back(
          {mark, "record group 9 is zero: the modal mass is that of the lumped masses"});
    }
  } else if (n > 0 && !(fem.has(14) && fem.has(15))) {
    result.warnings.push_back(
        {mark,
         "has neither lumped masses (record group 11) nor invariants (14, 15): modes and rigid "
         "motion are not coupled by inertia"});
  }
  if (fem.has(12)) read_rigid(fem, body);
  read_invariants(fem, body, result.warnings);
  for (std::string& message : finish_body(file.name(), body))
    result.warnings.push_back({mark, std::move(message)});
  if (fem.has(19))
    if (std::string left_out = read_stiffening(fem, body); !left_out.empty())
      result.warnings.push_back({fem.groups.at(19).mark, std::move(left_out)});
  return result;
}

ImportedBody read_mbdyn_fem(const std::string& path) {
  TextFile file(path);
  return parse_mbdyn_fem(file);
}

}  // namespace mimbre::fe
