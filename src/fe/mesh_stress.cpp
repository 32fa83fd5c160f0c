#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <unordered_map>

#include "fe/elements/cell_elements.h"
#include "fe/elements/solid_stress.h"
#include "mimbre/fe_mesh.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Matrix6x3 = Eigen::Matrix<double, 6, 3>;

/// Row of each node's six dofs, −1: none.
std::vector<std::array<int, 6>> rows_of(const SolidMesh& mesh, const std::vector<Dof>& dofs) {
  std::vector<std::array<int, 6>> rows(static_cast<std::size_t>(mesh.nodes.cols()), {-1, -1, -1, -1, -1, -1});
  for (std::size_t r = 0; r < dofs.size(); ++r) {
    const auto [node, direction] = dofs[r];
    if (node < 0 || node >= mesh.nodes.cols() || direction < 0 || direction > 5)
      throw std::invalid_argument(fmt::format("row {} is no dof of the mesh", r));
    rows[static_cast<std::size_t>(node)][static_cast<std::size_t>(direction)] = static_cast<int>(r);
  }
  return rows;
}

/// From in-plane components in the columns' axes (strains with engineering shear) to all six in body axes.
Matrix6x3 to_body(const Eigen::Matrix3d& axes, double normal_share, bool strain) {
  Matrix6x3 out;
  for (int k = 0; k < 3; ++k) {
    Eigen::Matrix3d local = Eigen::Matrix3d::Zero();
    if (k < 2)
      local(k, k) = 1, local(2, 2) = normal_share;
    else
      local(0, 1) = local(1, 0) = strain ? 0.5 : 1;
    const Eigen::Matrix3d t = axes * local * axes.transpose();
    const double shear = strain ? 2 : 1;
    out.col(k) << t(0, 0), t(1, 1), t(2, 2), shear * t(0, 1), shear * t(1, 2), shear * t(2, 0);
  }
  return out;
}

/// Of the contraction across a shell.
double cell_poisson(const SolidMesh& mesh, const CellView& cell) {
  return mesh.materials[static_cast<std::size_t>(cell.group->material)].material.poisson;
}

/// The points at each node.
std::unordered_multimap<int, Index> points_of_nodes(const SolidMesh& mesh,
                                                    const std::vector<SurfacePoint>& points) {
  std::unordered_multimap<int, Index> at_node;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (points[k].node < 0 || points[k].node >= mesh.nodes.cols())
      throw std::invalid_argument(
          fmt::format("point {} is at node {} of {}", k, points[k].node, mesh.nodes.cols()));
    at_node.emplace(points[k].node, static_cast<Index>(k));
  }
  return at_node;
}

/// Displacements of a cell's dofs, one column per field. `rows`: of each node's directions, −1: none.
MatrixXd displacements_of(const CellView& cell, const std::vector<std::array<int, 6>>& rows,
                          const Eigen::Ref<const MatrixXd>& displacements) {
  const int per_node = cell.node_dofs();
  MatrixXd u = MatrixXd::Zero(cell.dofs(), displacements.cols());
  for (int k = 0; k < cell.node_count; ++k)
    for (int d = 0; d < per_node; ++d)
      if (const int row = rows[static_cast<std::size_t>(cell.nodes[k])][static_cast<std::size_t>(d)];
          row >= 0)
        u.row(per_node * k + d) = displacements.row(row);
  return u;
}

}  // namespace

Recovery recover(const SolidMesh& mesh, const std::vector<SurfacePoint>& points, const std::vector<Dof>& dofs,
                 const Eigen::Ref<const MatrixXd>& displacements) {
  if (displacements.rows() != static_cast<Index>(dofs.size()))
    throw std::invalid_argument(
        fmt::format("{} displacements given of {} dofs", displacements.rows(), dofs.size()));
  const auto rows = rows_of(mesh, dofs);
  const Index fields = displacements.cols();
  const auto at_node = points_of_nodes(mesh, points);
  Recovery out{MatrixXd::Zero(6 * static_cast<Index>(points.size()), fields),
               MatrixXd::Zero(6 * static_cast<Index>(points.size()), fields)};
  std::vector<int> parts(points.size(), 0);

  const MeshCells cells = mesh_cells(mesh);
  for (int number = 0; number < cells.size(); ++number) {
    const CellView cell = view(mesh, cells, number);
    if (cell.group == nullptr) continue;
    bool wanted = false;
    for (int k = 0; k < cell.node_count; ++k) wanted = wanted || at_node.contains(cell.nodes[k]);
    if (!wanted) continue;

    const MatrixXd u = displacements_of(cell, rows, displacements);
    const auto add = [&](Index point, const auto& stress, const auto& strain) {
      out.stress.middleRows<6>(6 * point) += stress;
      out.strain.middleRows<6>(6 * point) += strain;
      ++parts[static_cast<std::size_t>(point)];
    };
    naming(cell, [&] {
      const ElementMaterial material = material_of(mesh, cell);
      if (cell.solid()) {
        const SolidGeometry geometry = geometry_of(mesh, cell);
        const MatrixXd strain = nodal_strain_operator(geometry, material) * u;
        for (int k = 0; k < cell.node_count; ++k) {
          const auto [begin, end] = at_node.equal_range(cell.nodes[k]);
          for (auto it = begin; it != end; ++it)
            if (points[static_cast<std::size_t>(it->second)].offset.isZero(0)) {
              const auto here = strain.middleRows<6>(6 * k);
              const Matrix6 elastic = material.at(geometry.nodes.col(k));
              add(it->second, elastic * here, here);
            }
        }
        return;
      }
      const ShellGeometry geometry = shell_of(mesh, cell);
      const ShellStrains shell = shell_strains(geometry, material);
      const MatrixXd membrane = shell.membrane * u, curvature = shell.curvature * u;
      for (int k = 0; k < cell.node_count; ++k) {
        const auto [begin, end] = at_node.equal_range(cell.nodes[k]);
        for (auto it = begin; it != end; ++it) {
          const Eigen::Vector3d& offset = points[static_cast<std::size_t>(it->second)].offset;
          if (offset.isZero(0)) continue;
          const Eigen::Matrix3d& axes = shell.axes[static_cast<std::size_t>(k)];
          const SheetElasticity elastic = material.sheet_at(geometry.nodes.col(k), axes);
          const double nu = cell_poisson(mesh, cell);
          const Matrix6x3 strains = to_body(axes, -nu / (1 - nu), true),
                          stresses = to_body(axes, 0, false) * elastic.plane;
          const double z = 0.5 * (offset.dot(axes.col(2)) < 0 ? -geometry.thickness : geometry.thickness);
          const MatrixXd here = membrane.middleRows<3>(3 * k) + z * curvature.middleRows<3>(3 * k);
          add(it->second, stresses * here, strains * here);
        }
      }
    });
  }
  for (std::size_t k = 0; k < points.size(); ++k)
    if (parts[k] > 1) {
      out.stress.middleRows<6>(6 * static_cast<Index>(k)) /= parts[k];
      out.strain.middleRows<6>(6 * static_cast<Index>(k)) /= parts[k];
    }
  return out;
}

}  // namespace mimbre::fe
