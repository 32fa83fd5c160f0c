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

/// What a label can be: the name without blanks, the number alone of `node 12`.
std::string label_of(const std::string& name) {
  if (name.starts_with("node ") && to_integer(name.substr(5))) return name.substr(5);
  std::string label;
  for (const char c : name) label += c == ' ' || c == '\t' ? '_' : c;
  return label;
}

void write_matrix(OutputFile& out, const Eigen::MatrixXd& matrix) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) out.print(" {:.16e}", matrix(i, j));
    out.print("\n");
  }
}

void write_group(OutputFile& out, int number, const char* title) {
  out.print("**\n** RECORD GROUP {}, {}\n", number, title);
}

void write_stiffening(OutputFile& out, const FrameForceStiffness& stiffening) {
  if (!stiffening.any()) return;
  std::vector<const Eigen::MatrixXd*> matrices;
  for (const int load : kStiffeningLoads)
    matrices.push_back(&stiffening.inertia[static_cast<std::size_t>(load)]);
  for (const Eigen::MatrixXd& matrix : stiffening.forces) matrices.push_back(&matrix);
  write_group(out, 19, "MODAL STRESS STIFFENING MATRIX");
  out.print("{}\n", std::count_if(matrices.begin(), matrices.end(),
                                  [](const Eigen::MatrixXd* matrix) { return matrix->size() > 0; }));
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    if (matrices[i]->size() == 0) continue;
    out.print("{}\n", i + 1);
    write_matrix(out, *matrices[i]);
  }
}

}  // namespace

void write_mbdyn_fem(const ReducedBody& body, const std::string& path) {
  if (body.ancf)
    throw std::invalid_argument(
        "a beam by absolute nodal coordinates is not linear and has no place in .fem");
  if (body.frames.empty())
    throw std::invalid_argument("a body without frames cannot be written as .fem: its nodes are the frames");
  const int n = body.modes;
  const FrameForceStiffness stiffening = by_frame_forces(body);
  OutputFile out(path);
  out.print("** MBDyn MODAL DATA FILE\n** RECORD GROUP 1, HEADER\n");
  out.print("**   REVISION,  NODE,  NORMAL, ATTACHMENT, CONSTRAINT, REJECTED MODES.\n");
  out.print("      REV0 {} {} 0 0 0\n", body.frames.size(), n);
  write_group(out, 2, "FINITE ELEMENT NODE LIST");
  for (const BodyFrame& frame : body.frames) out.print(" {}\n", label_of(frame.name));
  for (const int number : {3, 4}) {
    write_group(out, number, number == 3 ? "INITIAL MODAL DISPLACEMENTS" : "INITIAL MODAL VELOCITIES");
    for (int m = 0; m < n; ++m) out.print(" 0");
    out.print("\n");
  }
  for (int axis = 0; axis < 3; ++axis) {
    const char* titles[] = {"NODAL X COORDINATES", "NODAL Y COORDINATES", "NODAL Z COORDINATES"};
    write_group(out, 5 + axis, titles[axis]);
    for (const BodyFrame& frame : body.frames) out.print(" {:.16e}\n", frame.position(axis));
  }
  write_group(out, 8, "MODE SHAPES");
  for (int m = 0; m < n; ++m) {
    out.print("**    NORMAL MODE SHAPE #  {}\n", m + 1);
    for (const BodyFrame& frame : body.frames) {
      Eigen::RowVectorXd shape(6);
      shape << frame.X.col(m).transpose(), frame.X_theta.col(m).transpose();
      write_matrix(out, shape);
    }
  }
  write_group(out, 9, "MODAL MASS MATRIX");
  write_matrix(out, body.mass_matrix);
  write_group(out, 10, "MODAL STIFFNESS MATRIX");
  write_matrix(out, body.stiffness);
  write_group(out, 12, "GLOBAL INERTIA PROPERTIES");
  const Eigen::Vector3d centre = body.first_moment / body.mass;
  out.print(" {:.16e}\n", body.mass);
  write_matrix(out, centre.transpose());
  write_matrix(out, inertia_of(body.second_moment - body.mass * centre * centre.transpose()));
  write_group(out, 13, "MODAL DAMPING MATRIX");
  write_matrix(out, body.damping);
  write_group(out, 14, "INVARIANT 3");
  write_matrix(out, body.S);
  write_group(out, 15, "INVARIANT 4");
  write_matrix(out, angular_coupling(body));
  Eigen::MatrixXd I8(3, 3 * n), I5(3, n * n), I9(3, 3 * n * n);
  for (int j = 0; j < n; ++j) {
    I8.middleCols<3>(3 * j) = inertia_of(position_integral(body, j));
    for (int k = 0; k < n; ++k) {
      const Eigen::Matrix3d A = mode_integral(body, j, k);
      I5.col(j * n + k) << A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0);
      I9.middleCols<3>(3 * (j * n + k)) = A.transpose() - A.trace() * Eigen::Matrix3d::Identity();
    }
  }
  write_group(out, 16, "INVARIANT 8");
  write_matrix(out, I8);
  write_group(out, 17, "INVARIANT 5");
  write_matrix(out, I5);
  write_group(out, 18, "INVARIANT 9");
  write_matrix(out, I9);
  write_stiffening(out, stiffening);
  out.finish();
}

}  // namespace mimbre::fe
