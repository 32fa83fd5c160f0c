#include "reduction/bases/load_modes.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

namespace mimbre::fe {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd load_forces(const FeMatrices& matrices, const std::vector<SpreadLoad>& loads) {
  const bool reduced = !matrices.all_dofs.empty();
  const std::vector<Dof>& dofs = reduced ? matrices.all_dofs : matrices.dofs;
  int nodes = 0;
  for (const Dof& dof : dofs) nodes = std::max(nodes, dof.node + 1);
  std::vector<std::array<Index, 3>> rows(static_cast<std::size_t>(nodes), {-1, -1, -1});
  for (std::size_t r = 0; r < dofs.size(); ++r)
    if (const Dof& dof = dofs[r]; dof.direction < 3)
      rows[static_cast<std::size_t>(dof.node)][static_cast<std::size_t>(dof.direction)] =
          static_cast<Index>(r);
  MatrixXd forces = MatrixXd::Zero(static_cast<Index>(dofs.size()), static_cast<Index>(loads.size()));
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const SpreadLoad& load = loads[l];
    for (std::size_t k = 0; k < l; ++k)
      if (loads[k].name == load.name)
        throw std::invalid_argument(fmt::format("two loads are called '{}'", load.name));
    if (load.nodes.empty()) throw std::invalid_argument(fmt::format("the load '{}' has no nodes", load.name));
    if (!load.force.allFinite() || load.force.isZero(0))
      throw std::invalid_argument(fmt::format("the load '{}' has no force", load.name));
    const Eigen::Vector3d part = load.force / static_cast<double>(load.nodes.size());
    for (const int node : load.nodes)
      for (int i = 0; i < 3; ++i) {
        if (part[i] == 0) continue;
        const Index row = node >= 0 && node < nodes
                              ? rows[static_cast<std::size_t>(node)][static_cast<std::size_t>(i)]
                              : -1;
        if (row < 0)
          throw std::invalid_argument(
              fmt::format("the load '{}' pulls at a node where the model has no displacement", load.name));
        forces(row, static_cast<Index>(l)) += part[i];
      }
  }
  if (reduced) return matrices.expansion.transpose() * forces;
  return forces;
}

std::vector<std::string> load_names(const std::vector<SpreadLoad>& loads) {
  std::vector<std::string> names;
  for (const SpreadLoad& load : loads) names.push_back("load " + load.name);
  return names;
}

Shapes load_shapes(const TiedModel& tied, const FeMatrices& matrices,
                   const std::vector<Interface>& interfaces, const std::vector<SpreadLoad>& loads) {
  const MatrixXd x = tied.solve(tied.restrict(load_forces(matrices, loads)));
  Shapes shapes = held_shapes(tied, interfaces, x, "load");
  shapes.names = load_names(loads);
  return shapes;
}

std::vector<Check> load_checks(const std::vector<SpreadLoad>& loads, const std::vector<double>& fresh) {
  std::vector<Check> checks;
  for (std::size_t k = 0; k < loads.size(); ++k) {
    const std::string name = "load " + loads[k].name;
    if (fresh[k] > 0)
      checks.push_back({name, true,
                        fmt::format("{:.3g} % of the strain energy of its deflection was beyond the other "
                                    "modes; now a mode",
                                    100 * fresh[k])});
    else
      checks.push_back({name, true, "left out: its deflection is one of the other modes already"});
  }
  return checks;
}

}  // namespace mimbre::fe
