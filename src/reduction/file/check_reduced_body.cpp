#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <set>
#include <string_view>

#include "math/once/decompositions.h"
#include "mimbre/reduced_body.h"
#include "reduction/file/check_arrays.h"
#include "reduction/stiffening/stretching_states.h"

namespace mimbre {
namespace {

constexpr double kRelative = 1e-8;  // what round-off, also of data written with nine digits, may leave

/// Collects what is wrong. The first stage asks for sizes and finite numbers; the others may then compute.
class Report {
 public:
  void require(bool sound, std::string message) {
    if (!sound) messages_.push_back(std::move(message));
  }
  template <typename Derived>
  void matrix(const std::string& what, const Eigen::DenseBase<Derived>& value, Eigen::Index rows,
              Eigen::Index columns) {
    if (value.rows() != rows || value.cols() != columns)
      messages_.push_back(
          fmt::format("{} must be {} x {}, is {} x {}", what, rows, columns, value.rows(), value.cols()));
    else
      require(value.derived().allFinite(), what + " must be finite");
  }
  bool sound() const { return messages_.empty(); }
  std::vector<std::string> messages() && { return std::move(messages_); }

 private:
  std::vector<std::string> messages_;
};

double largest(const Eigen::MatrixXd& matrix) { return matrix.size() > 0 ? matrix.cwiseAbs().maxCoeff() : 0; }

bool equal(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return largest(a - b) <= kRelative * std::max(largest(a), largest(b));
}

/// Lowest eigenvalue after scaling the diagonal to one, so that units do not matter.
double lowest_scaled_eigenvalue(const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return 1;
  Eigen::VectorXd scale(matrix.rows());
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    scale[i] =
        matrix(i, i) > 0 ? 1 / std::sqrt(matrix(i, i)) : 1 / std::sqrt(std::max(largest(matrix), 1e-300));
  const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  return symmetric_eigenvalues(scaled)[0];
}

/// Square, finite, in a full and compressed storage.
void check_sparse(const std::string& what, const Eigen::SparseMatrix<double>& matrix, Eigen::Index size,
                  Report& report) {
  if (matrix.rows() != size || matrix.cols() != size)
    return report.require(
        false, fmt::format("{} must be {} x {}, is {} x {}", what, size, size, matrix.rows(), matrix.cols()));
  report.require(matrix.isCompressed(), what + " must be compressed");
  report.require(matrix.coeffs().isFinite().all(), what + " must be finite");
}

void check_mesh_sizes(const ReducedBody& body, Report& report) {
  const MeshInertia& mesh = *body.mesh_inertia;
  report.require(mesh.dofs_per_node == 3 || mesh.dofs_per_node == 6,
                 fmt::format("mesh inertia: dofs_per_node must be 3 or 6, is {}", mesh.dofs_per_node));
  const Eigen::Index dofs = body.nodes.cols() * mesh.dofs_per_node;
  report.matrix("mesh inertia: shapes", mesh.shapes, dofs, body.modes);
  check_sparse("mesh inertia: mass", mesh.mass, dofs, report);
  if (mesh.nodal_mass.size() > 0)
    check_sparse("mesh inertia: nodal_mass", mesh.nodal_mass, body.nodes.cols(), report);
}

void check_geometric_stiffness(const ReducedBody& body, Report& report) {
  const GeometricStiffness& g = *body.geometric;
  report.require(
      !body.second_order && !body.ancf,
      "geometric stiffness: a body that knows of large deflections otherwise must not have it too");
  report.matrix("geometric stiffness: boundary_loads", g.boundary_loads, g.boundary_loads.rows(), body.modes);
  report.require(
      g.stiffness.size() == g.loads.size(),
      fmt::format("geometric stiffness: there must be one matrix for each of {} loads, there are {}",
                  g.loads.size(), g.stiffness.size()));
  const Eigen::Index end = GeometricStiffness::boundary + g.boundary_loads.rows();
  for (std::size_t k = 0; k < g.loads.size(); ++k) {
    report.require(g.loads[k] >= 0 && g.loads[k] < end,
                   fmt::format("geometric stiffness: load {} must be from 0 to {}", g.loads[k], end - 1));
    report.require(k == 0 || g.loads[k] > g.loads[k - 1],
                   fmt::format("geometric stiffness: loads must ascend, {} comes late", g.loads[k]));
  }
  for (const Eigen::MatrixXd& k : g.stiffness)
    report.matrix("geometric stiffness: stiffness", k, body.modes, body.modes);
}

void check_stretching(const ReducedBody& body, Report& report) {
  const Stretching& s = *body.stretching;
  const Eigen::Index motions = s.places.cols();
  report.matrix("stretching: places", s.places, static_cast<Eigen::Index>(s.forms.size()), motions);
  report.matrix("stretching: stiffness", s.stiffness, motions, motions);
  for (const Eigen::MatrixXd& form : s.forms)
    report.matrix("stretching: forms", form, body.modes + 3, body.modes + 3);
  report.require(s.forms.size() <= most_stretching_states,
                 fmt::format("stretching: there must be at most {} forms, there are {}",
                             most_stretching_states, s.forms.size()));
  report.require(motions % 6 == 0, "stretching: a place has six motions");
  report.require(s.place_of_frame.size() == body.frames.size(),
                 fmt::format("stretching: place_of_frame must be {}, are {}", body.frames.size(),
                             s.place_of_frame.size()));
  for (const int place : s.place_of_frame)
    report.require(place >= 0 && 6 * place < motions, fmt::format("stretching: there is no place {}", place));
}

void check_second_order(const ReducedBody& body, Report& report) {
  const SecondOrder& s = *body.second_order;
  for (const auto& [a, b] : s.products)
    report.require(a >= 0 && a <= b && b < body.modes,
                   fmt::format("second order: product ({}, {}) must be of modes in ascending order", a, b));
  const Eigen::Index e = body.modes + static_cast<Eigen::Index>(s.products.size());
  report.matrix("second order: S", s.S, 3, e);
  for (int i = 0; i < 3; ++i) {
    report.matrix(fmt::format("second order: S_position[{}]", i), s.S_position[i], 3, e);
    for (int j = 0; j < 3; ++j)
      report.matrix(fmt::format("second order: S_modes[{}][{}]", i, j), s.S_modes[i][j], e, e);
  }
  report.matrix("second order: mass_matrix", s.mass_matrix, e, e);
  report.matrix("second order: stiffness", s.stiffness, e, e);
  report.require(s.frame_shapes.size() == body.frames.size(),
                 fmt::format("second order: frame_shapes must be {}, are {}", body.frames.size(),
                             s.frame_shapes.size()));
  for (const Eigen::Matrix3Xd& X : s.frame_shapes) report.matrix("second order: frame_shapes", X, 3, e);
  report.matrix("second order: node_shapes", s.node_shapes, 3 * body.nodes.cols(), e);
  if (body.mesh_inertia)
    report.matrix("second order: mesh_shapes", s.mesh_shapes,
                  body.mesh_inertia->dofs_per_node * body.nodes.cols(), e);
}

void check_sizes(const ReducedBody& body, Report& report) {
  const Eigen::Index n = body.modes;
  report.require(std::isfinite(body.mass), "mass must be finite");
  report.require(std::isfinite(body.line_radius) && body.line_radius >= 0,
                 "line_radius must not be negative");
  report.require(body.mode_names.size() == static_cast<std::size_t>(n),
                 fmt::format("mode_names must be {}, are {}", n, body.mode_names.size()));
  report.matrix("first_moment", body.first_moment, 3, 1);
  report.matrix("second_moment", body.second_moment, 3, 3);
  report.matrix("S", body.S, 3, n);
  for (int i = 0; i < 3; ++i) {
    report.matrix(fmt::format("S_position[{}]", i), body.S_position[i], 3, n);
    for (int j = 0; j < 3; ++j) report.matrix(fmt::format("S_modes[{}][{}]", i, j), body.S_modes[i][j], n, n);
  }
  report.matrix("mass_matrix", body.mass_matrix, n, n);
  report.matrix("stiffness", body.stiffness, n, n);
  report.matrix("damping", body.damping, n, n);
  report.matrix("user_from_modal", body.user_from_modal, n, n);
  if (body.eigenfrequencies.size() > 0) report.matrix("eigenfrequencies", body.eigenfrequencies, n, 1);
  report.matrix("nodes", body.nodes, 3, body.nodes.cols());
  report.matrix("node_shapes", body.node_shapes, 3 * body.nodes.cols(), n);
  if (body.stress.size() > 0) report.matrix("stress", body.stress, 6 * body.nodes.cols(), n);
  if (body.strain.size() > 0) report.matrix("strain", body.strain, 6 * body.nodes.cols(), n);
  report.require(
      body.node_labels.empty() || static_cast<Eigen::Index>(body.node_labels.size()) == body.nodes.cols(),
      fmt::format("node_labels must be {}, are {}", body.nodes.cols(), body.node_labels.size()));
  if (body.mesh_inertia) check_mesh_sizes(body, report);
  if (body.geometric) check_geometric_stiffness(body, report);
  if (body.stretching) check_stretching(body, report);
  if (body.second_order) check_second_order(body, report);
  for (const BodyFrame& frame : body.frames) {
    report.matrix(fmt::format("frame '{}': position", frame.name), frame.position, 3, 1);
    report.matrix(fmt::format("frame '{}': rotation", frame.name), frame.rotation, 3, 3);
    report.matrix(fmt::format("frame '{}': X", frame.name), frame.X, 3, n);
    report.matrix(fmt::format("frame '{}': X_theta", frame.name), frame.X_theta, 3, n);
  }
}

void check_geometry(const ReducedBody& body, Report& report) {
  std::set<std::string> names;
  for (const BodyFrame& frame : body.frames) {
    report.require(names.insert(frame.name).second, fmt::format("frame name '{}' is used twice", frame.name));
    const Eigen::Matrix3d& R = frame.rotation;
    report.require(
        (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6 && R.determinant() > 0,
        fmt::format("frame '{}': rotation must be orthonormal and right-handed", frame.name));
  }
  for (const auto& line : body.lines)
    for (int node : line)
      report.require(node >= 0 && node < body.nodes.cols(),
                     fmt::format("line end {} is no node, there are {}", node, body.nodes.cols()));
  for (const auto& triangle : body.triangles)
    for (int node : triangle)
      report.require(
          node >= 0 && node < body.nodes.cols(),
          fmt::format("corner {} of a triangle is no node, there are {}", node, body.nodes.cols()));
}

/// The inertia about the centre of mass of a real body obeys Jxx + Jyy ≥ Jzz and so on: tr(P̄)/2 is no less
/// than any eigenvalue of J̄, that is, P̄ about the centre of mass has no negative eigenvalue.
void check_rigid_inertia(const ReducedBody& body, Report& report) {
  const Eigen::Vector3d centre = body.first_moment / body.mass;
  const Eigen::Matrix3d central = body.second_moment - body.mass * centre * centre.transpose();
  const Eigen::Vector3d values = eigenvalues3(central);
  const double limit = kRelative * std::max(body.second_moment.trace(), 0.0);
  report.require(
      values[0] >= -limit,
      fmt::format("inertia about the centre of mass violates the triangle inequality: second_moment there "
                  "has the eigenvalue {:g}",
                  values[0]));
}

/// Mass matrix of a unit linear and angular velocity (about the body frame's origin) and the modes,
/// undeformed.
Eigen::MatrixXd whole_mass_matrix(const ReducedBody& body) {
  const Eigen::Index n = body.modes;
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(6 + n, 6 + n);
  M.topLeftCorner<3, 3>() = body.mass * Eigen::Matrix3d::Identity();
  M.block<3, 3>(3, 3) = body.second_moment.trace() * Eigen::Matrix3d::Identity() - body.second_moment;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    M(i, 3 + j) = body.first_moment[k];  // −m̄~
    M(j, 3 + i) = -body.first_moment[k];
    M.block(3 + k, 6, 1, n) = body.S_position[i].row(j) - body.S_position[j].row(i);
  }
  M.block(0, 6, 3, n) = body.S;
  M.bottomRightCorner(n, n) = body.mass_matrix;
  return M.selfadjointView<Eigen::Upper>();
}

/// Every mode has a stiffness, and the frequencies in the file are those of its matrices.
void check_frequencies(const ReducedBody& body, Report& report) {
  report.require((body.stiffness.diagonal().array() > 0).all(),
                 "stiffness must hold every mode: a diagonal entry is 0");
  if (!report.sound() || body.eigenfrequencies.size() == 0) return;
  const Eigen::VectorXd squares = symmetric_eigen(body.stiffness, body.mass_matrix).values;
  const double top = squares[squares.size() - 1];
  for (Eigen::Index k = 0; k < squares.size(); ++k) {
    const double stated = body.eigenfrequencies[k] * body.eigenfrequencies[k];
    if (std::abs(squares[k] - stated) <= 1e-4 * stated + kRelative * top) continue;
    report.require(false, fmt::format("eigenfrequency {} is {:g} rad/s, but stiffness and mass_matrix give "
                                      "{:g}: one of them was changed",
                                      k + 1, body.eigenfrequencies[k], std::sqrt(std::max(0.0, squares[k]))));
    return;
  }
}

void check_symmetry(const ReducedBody& body, Report& report) {
  const auto symmetric = [&](const char* what, const Eigen::MatrixXd& matrix) {
    report.require(equal(matrix, matrix.transpose()), std::string(what) + " must be symmetric");
  };
  symmetric("second_moment", body.second_moment);
  symmetric("mass_matrix", body.mass_matrix);
  symmetric("stiffness", body.stiffness);
  symmetric("damping", body.damping);
  if (body.geometric)
    for (const Eigen::MatrixXd& k : body.geometric->stiffness) symmetric("geometric stiffness", k);
  if (body.stretching) {
    for (const Eigen::MatrixXd& form : body.stretching->forms) symmetric("stretching: forms", form);
    symmetric("stretching: stiffness", body.stretching->stiffness);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      report.require(equal(body.S_modes[j][i], body.S_modes[i][j].transpose()),
                     fmt::format("S_modes[{}][{}] must be the transpose of S_modes[{}][{}]", j, i, i, j));
}

void check_matrices(const ReducedBody& body, Report& report) {
  check_symmetry(body, report);
  if (!report.sound()) return;

  report.require(lowest_scaled_eigenvalue(body.mass_matrix) > 0, "mass_matrix must be positive definite");
  report.require(lowest_scaled_eigenvalue(whole_mass_matrix(body)) > -kRelative,
                 "the mass matrix of rigid motion and modes together must not be indefinite");
  report.require(lowest_scaled_eigenvalue(body.stiffness) > -kRelative, "stiffness must not be indefinite");
  report.require(lowest_scaled_eigenvalue(body.damping) > -kRelative,
                 "damping must not be indefinite: it would feed energy in");
  if (report.sound() && body.modes > 0 && !body.ancf) check_frequencies(body, report);
}

/// The mesh's matrices are symmetric and have the mass and the modes' mass matrix of the body.
void check_mesh_inertia(const ReducedBody& body, Report& report) {
  const MeshInertia& mesh = *body.mesh_inertia;
  const auto symmetric = [&](const char* what, const Eigen::SparseMatrix<double>& matrix) {
    const Eigen::SparseMatrix<double> difference = matrix - Eigen::SparseMatrix<double>(matrix.transpose());
    if (matrix.nonZeros() > 0)
      report.require(difference.coeffs().abs().maxCoeff() <= kRelative * matrix.coeffs().abs().maxCoeff(),
                     fmt::format("mesh inertia: {} must be symmetric", what));
  };
  symmetric("mass", mesh.mass);
  symmetric("nodal_mass", mesh.nodal_mass);
  constexpr double close = 1e-6;
  const auto same_mass = [&](const char* what, double mass) {
    report.require(
        std::abs(mass - body.mass) <= close * body.mass,
        fmt::format("mesh inertia: {} has a mass of {:g}, the body of {:g}", what, mass, body.mass));
  };
  Eigen::MatrixXd translations = Eigen::MatrixXd::Zero(mesh.mass.rows(), 3);
  for (Eigen::Index dof = 0; dof < mesh.mass.rows(); ++dof)
    if (dof % mesh.dofs_per_node < 3) translations(dof, dof % mesh.dofs_per_node) = 1;
  same_mass("mass", (translations.transpose() * (mesh.mass * translations)).trace() / 3);
  if (mesh.nodal_mass.size() > 0) same_mass("nodal_mass", mesh.nodal_mass.sum());
  const Eigen::MatrixXd modal = mesh.shapes.transpose() * (mesh.mass * mesh.shapes);
  report.require(largest(modal - body.mass_matrix) <= close * largest(body.mass_matrix),
                 "mesh inertia: mass and shapes do not give mass_matrix");
}

void check_sizes_and_mass(const ReducedBody& body, Report& report) {
  report.require(body.modes >= 0, fmt::format("modes must not be negative, is {}", body.modes));
  if (report.sound()) check_sizes(body, report);
  if (report.sound()) report.require(body.mass > 0, fmt::format("mass must be positive, is {}", body.mass));
}

/// The validation report begins its line of the mass with it: six digits.
void check_certified_mass(const ReducedBody& body, Report& report) {
  for (const Check& line : body.checks) {
    if (line.name != "mass") continue;
    double stated = 0;
    const auto [end, error] =
        std::from_chars(line.detail.data(), line.detail.data() + line.detail.size(), stated);
    if (error != std::errc{} || !std::string_view(end).starts_with(" kg")) continue;
    report.require(std::abs(body.mass - stated) <= 1e-5 * std::abs(stated),
                   fmt::format("mass is {:.6g} kg, but the validation report has {:.6g}: it was changed",
                               body.mass, stated));
  }
}

}  // namespace

int ReducedBody::find_frame(const std::string& frame_name) const {
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].name == frame_name) return static_cast<int>(i);
  return -1;
}

std::vector<std::string> check_arrays(const ReducedBody& body) {
  Report report;
  check_sizes_and_mass(body, report);
  if (report.sound()) {
    check_geometry(body, report);
    check_symmetry(body, report);
  }
  if (report.sound())
    report.require(body.modes == 0 || is_positive_definite(body.mass_matrix),
                   "mass_matrix must be positive definite");
  return std::move(report).messages();
}

std::vector<std::string> check(const ReducedBody& body) {
  Report report;
  check_sizes_and_mass(body, report);
  if (report.sound()) {
    check_certified_mass(body, report);
    check_geometry(body, report);
    check_rigid_inertia(body, report);
    check_matrices(body, report);
  }
  if (report.sound() && body.mesh_inertia) check_mesh_inertia(body, report);
  return std::move(report).messages();
}

}  // namespace mimbre
