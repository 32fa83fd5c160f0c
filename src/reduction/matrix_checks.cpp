#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fe/elements/mass_points.h"
#include "fe/node_label.h"
#include "fe/skin.h"
#include "math/elementary.h"
#include "mimbre/fe_reduce.h"
#include "reduction/bases/rigid_shapes.h"
#include "reduction/material_oddity.h"
#include "reduction/matrix_checks.h"
#include "reduction/tied_model.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

bool all_finite(const Eigen::SparseMatrix<double>& m) {
  return Eigen::Map<const Eigen::VectorXd>(m.valuePtr(), m.nonZeros()).allFinite();
}

double largest(const Eigen::SparseMatrix<double>& m) {
  return m.nonZeros() > 0
             ? Eigen::Map<const Eigen::VectorXd>(m.valuePtr(), m.nonZeros()).cwiseAbs().maxCoeff()
             : 0;
}

/// What is odd about the materials of a mesh: of many, as layers have, the first few.
std::string oddities(const SolidMesh& mesh) {
  constexpr int most = 5;
  std::string odd;
  int count = 0;
  for (const NamedMaterial& named : mesh.materials)
    if (const std::string what = oddity(named.material); !what.empty() && ++count <= most)
      odd += fmt::format("{}'{}': {}", odd.empty() ? "" : "; ", named.name, what);
  if (count > most) odd += fmt::format("; and {} more", count - most);
  return odd;
}

/// Nothing where the model came as matrices.
void add_materials_check(const SolidMesh& mesh, std::vector<Check>& checks) {
  if (mesh.materials.empty()) return;
  const std::string odd = oddities(mesh);
  checks.push_back({"materials", odd.empty(), odd.empty() ? "in the range of what parts are made of" : odd});
}

std::string at_dof(const SolidMesh& mesh, const std::vector<Dof>& dofs, Index row) {
  const Dof& dof = dofs[static_cast<std::size_t>(row)];
  return fmt::format(", of the {} {} of node {}", dof.direction < 3 ? "displacement along" : "rotation about",
                     "xyz"[dof.direction % 3], label_of(mesh, dof.node));
}

double point_mass(const SolidMesh& mesh) {
  double mass = 0;
  for (const PointMass& point : mesh.point_masses) mass += point.mass;
  return mass;
}

/// Mass over the volume of the box around the model shows units that do not fit: real parts fill between a
/// hundredth and all of it, at 100 to 25 000 kg/m³. Where the material is in SI but the mesh in millimetres
/// that is in order, and only the size shows it: nobody moves parts of a thousand tonnes. Shells and beams
/// fill as little of their box as they are thin: of their elements the volume is known.
Check units_check(const SolidMesh& mesh, const FeMatrices& matrices, double mass) {
  Vector3d low = Vector3d::Constant(INFINITY), high = -low;
  for (const Dof& dof : matrices.dofs) {
    low = low.cwiseMin(mesh.nodes.col(dof.node));
    high = high.cwiseMax(mesh.nodes.col(dof.node));
  }
  const Vector3d size = high - low;
  const double longest = size.maxCoeff();
  const bool thin = matrices.of_mesh && has_rotating_mass(mesh);
  const double own = thin ? element_volume(mesh) : 0;
  const double volume = own > 0 ? own : size.cwiseMax(1e-3 * longest).prod();
  const double density = (own > 0 ? mass - point_mass(mesh) : mass) / volume;
  std::string detail = fmt::format("{:.4g} m long, {:.4g} kg, {:.3g} kg per m³ of {}", longest, mass, density,
                                   own > 0 ? "its elements" : "the box around it");
  const bool filled = density > 0.5 && density < 30000,
             sound = filled && longest > 1e-4 && longest < 300 && mass < 1e6;
  if (!sound) {
    // mm–t–s taken for SI: lengths 1e3 too large, masses 1e-3 of what they are.
    const double tonne_millimetre = density * 1e12;
    if (tonne_millimetre > 0.5 && tonne_millimetre < 30000 && longest < 2)
      detail +=
          "; the size is that of a part, the mass is not: is the density in kg/m³, and Young's modulus in "
          "Pa? "
          "A --material is in SI whatever the file's units are";
    else if (tonne_millimetre > 0.5 && tonne_millimetre < 30000)
      detail +=
          "; in millimetres, tonnes and seconds it would be sound: --units mm (a --material is in SI always)";
    else if (filled && longest > 1)
      detail += fmt::format(
          "; is the mesh in millimetres? With --units mm it is {:.3g} m long and weighs {:.3g} kg",
          1e-3 * longest, 1e-9 * mass);
    else
      detail += "; are these metres, kilograms and seconds? See --units";
  }
  return {"units", sound, detail};
}

}  // namespace

MatrixXd rigid_shapes(const SolidMesh& mesh, const FeMatrices& matrices) {
  MatrixXd shapes = MatrixXd::Zero(static_cast<Index>(matrices.dofs.size()), 6);
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r) {
    const Dof& dof = matrices.dofs[r];
    const auto row = static_cast<Index>(r);
    if (dof.direction >= 3) {
      shapes(row, dof.direction) = 1;
      continue;
    }
    const Vector3d position = mesh.nodes.col(dof.node);
    shapes(row, dof.direction) = 1;
    for (int k = 0; k < 3; ++k)
      shapes(row, 3 + k) = Vector3d(Vector3d::Unit(k)).cross(position)[dof.direction];
  }
  return shapes;
}

std::vector<Check> check_matrices(const SolidMesh& mesh, const FeMatrices& matrices) {
  return check_matrices(mesh, matrices, {});
}

std::vector<Check> check_matrices(const SolidMesh& mesh, const FeMatrices& matrices,
                                  const std::vector<Interface>& interfaces) {
  std::vector<Check> checks;
  const Index n = matrices.stiffness.rows();
  const bool sizes = matrices.stiffness.cols() == n && matrices.mass.rows() == n &&
                     matrices.mass.cols() == n && static_cast<Index>(matrices.dofs.size()) == n && n > 0;
  checks.push_back({"sizes", sizes,
                    fmt::format("stiffness {} × {}, mass {} × {}, {} dofs", n, matrices.stiffness.cols(),
                                matrices.mass.rows(), matrices.mass.cols(), matrices.dofs.size())});
  if (!sizes) return checks;
  const bool finite = all_finite(matrices.stiffness) && all_finite(matrices.mass) && mesh.nodes.allFinite();
  checks.push_back({"finite numbers", finite, finite ? "all are" : "there are numbers that are not finite"});
  if (!finite) return checks;

  std::vector<char> tied(static_cast<std::size_t>(mesh.nodes.cols()), 0);
  for (const Interface& interface : interfaces)
    for (const int node : interface.nodes)
      if (interface.tie == Interface::Tie::rigid && node >= 0 && node < mesh.nodes.cols())
        tied[static_cast<std::size_t>(node)] = 1;
  Eigen::VectorXd springs = matrices.stiffness.diagonal();
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    if (tied[static_cast<std::size_t>(matrices.dofs[r].node)] && springs[static_cast<Index>(r)] == 0)
      springs[static_cast<Index>(r)] = INFINITY;
  Index light = 0, soft = 0;
  const double least = matrices.mass.diagonal().minCoeff(&light), stiff = springs.minCoeff(&soft);
  const bool positive = least >= 0 && stiff > 0;
  checks.push_back({"positive diagonals", positive,
                    fmt::format("smallest of mass {:.3g}, of stiffness {:.3g}{}", least, stiff,
                                positive ? "" : at_dof(mesh, matrices.dofs, stiff > 0 ? light : soft))});

  const MatrixXd R = rigid_shapes(mesh, matrices);
  const MatrixXd momenta = symmetric_times(matrices.mass, R);
  const double mass = R.leftCols(3).cwiseProduct(momenta.leftCols(3)).sum() / 3;
  const MatrixXd inertia = R.transpose() * momenta;
  const double spread = (inertia.topLeftCorner(3, 3) - mass * MatrixXd::Identity(3, 3)).cwiseAbs().maxCoeff();
  checks.push_back({"mass", mass > 0 && spread < 1e-6 * mass,
                    fmt::format("{:.6g} kg, the same in all directions to {:.1g}", mass,
                                spread / std::max(mass, 1e-300))});
  const MatrixXd forces = symmetric_times(matrices.stiffness, R);
  const double largest_entry = largest(matrices.stiffness);
  const double length = std::max(1e-300, R.rightCols(3).cwiseAbs().maxCoeff());
  const double translation = forces.leftCols(3).cwiseAbs().maxCoeff() / largest_entry,
               rotation = forces.rightCols(3).cwiseAbs().maxCoeff() / (largest_entry * length);
  checks.push_back(
      {"rigid motions", translation < 1e-6 && rotation < 1e-6,
       fmt::format(
           "six motions without force: {:.1g} (translations) and {:.1g} (rotations) of the "
           "largest entry{}",
           translation, rotation,
           translation < 1e-6 && rotation < 1e-6 ? "" : "; is the model held somewhere, or in other axes?")});
  if (mass > 0) checks.push_back(units_check(mesh, matrices, mass));
  add_materials_check(mesh, checks);

  // The geometry's own mass, where it has one material and nothing but solids.
  const Skin outside = skin(mesh);
  if (outside.closed && mass > 0 && mesh.point_masses.empty()) {
    double density = -1;
    for (const ElementGroup& group : mesh.groups) {
      if (group.material < 0) continue;
      const double own = mesh.materials[static_cast<std::size_t>(group.material)].material.density;
      density = density < 0 || density == own ? own : NAN;
    }
    const Enclosed geometry = enclosed(mesh, outside);
    if (density > 0 && geometry.volume > 0) {
      const double relative = mass / (density * geometry.volume) - 1;
      const Vector3d moment(inertia(1, 5), inertia(2, 3), inertia(0, 4));  // m (x, y, z)
      const double off = (moment / mass - geometry.centre).norm() / mimbre::cbrt(geometry.volume);
      checks.push_back({"geometry", std::abs(relative) < 0.03 && off < 0.03,
                        fmt::format("the mass differs by {:.2g} % from density times the volume inside the "
                                    "skin's flat facets, the centre by {:.2g} % of its size",
                                    100 * relative, 100 * off)});
    }
  }
  return checks;
}

Check lumped_check(const FeMatrices& consistent, const FeMatrices& lumped, const Eigen::MatrixXd& R) {
  const auto inertia = [&](const FeMatrices& matrices) {
    const Eigen::MatrixXd m = R.transpose() * symmetric_times(matrices.mass, R);
    // About the origin m.bottomRight; its translations couple by −m c~.
    return Eigen::Matrix3d(m.bottomRightCorner(3, 3) -
                           m.bottomLeftCorner(3, 3) * m.topRightCorner(3, 3) / m(0, 0));
  };
  const Eigen::Matrix3d exact = inertia(consistent), found = inertia(lumped);
  return {
      "lumped masses", true,
      fmt::format("at the nodes, with the same centre of mass; moments of inertia differ by up to {:.2g} % "
                  "of the largest from those of consistent masses",
                  100 * (found - exact).cwiseAbs().maxCoeff() / exact.diagonal().maxCoeff())};
}

}  // namespace mimbre::fe
