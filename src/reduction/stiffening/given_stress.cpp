#include "reduction/stiffening/given_stress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <unordered_map>

namespace mimbre::fe {

using Eigen::Index;
using Eigen::MatrixXd;

void require(const StressMatrix& stress, const SolidMesh& mesh, const FeMatrices& matrices) {
  const auto rows = 6 * static_cast<Index>(stress.nodes.size());
  const auto columns = static_cast<Index>(matrices.dofs.size());
  if (stress.matrix.rows() != rows || stress.matrix.cols() != columns)
    throw std::invalid_argument(
        fmt::format("the stress matrix is {} x {}, {} x {} is needed for {} nodes and {} dofs",
                    stress.matrix.rows(), stress.matrix.cols(), rows, columns, stress.nodes.size(), columns));
  std::set<int> seen;
  for (const int node : stress.nodes)
    if (node < 0 || node >= mesh.nodes.cols() || !seen.insert(node).second)
      throw std::invalid_argument(
          fmt::format("the stress matrix has the node {}, which is not there or twice", node));
  for (Index c = 0; c < columns; ++c)
    for (Eigen::SparseMatrix<double>::InnerIterator it(stress.matrix, c); it; ++it)
      if (!std::isfinite(it.value()))
        throw std::invalid_argument("the stress matrix has entries that are not finite");
}

Surface at_nodes(const StressMatrix& stress, const Surface& surface) {
  Surface out;
  std::unordered_map<int, int> by_node;
  for (const int node : stress.nodes) {
    by_node.emplace(node, static_cast<int>(out.points.size()));
    out.points.push_back({node, Eigen::Vector3d::Zero()});
  }
  const auto keep = [&](const auto& from, auto& into) {
    for (auto corners : from) {
      const bool all = std::all_of(corners.begin(), corners.end(), [&](int& corner) {
        const SurfacePoint& point = surface.points[static_cast<std::size_t>(corner)];
        const auto found = point.offset.isZero(0) ? by_node.find(point.node) : by_node.end();
        if (found == by_node.end()) return false;
        corner = found->second;
        return true;
      });
      if (all) into.push_back(corners);
    }
  };
  keep(surface.lines, out.lines);
  keep(surface.triangles, out.triangles);
  return out;
}

Check check_rigid(const StressMatrix& stress, const MatrixXd& R) {
  const MatrixXd largest = stress.matrix.cwiseAbs() * R.cwiseAbs();
  const double of = largest.size() > 0 ? largest.maxCoeff() : 0;
  const double left = of > 0 ? MatrixXd(stress.matrix * R).cwiseAbs().maxCoeff() / of : 0;
  return {"stress matrix", left < 1e-5,
          fmt::format("{} nodes; stress of rigid motions: {:.1g} of what single dofs cause",
                      stress.nodes.size(), left)};
}

}  // namespace mimbre::fe
