#pragma once
#include <string>
#include <vector>

#include "app/options.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::app {

/// The options of `mimbre reduce` for interfaces.
struct InterfaceOptions {
  std::vector<std::string> interfaces, means, points, axes, freed, held;
};
void add_interface_options(Parser& parser, InterfaceOptions& options);

/// fe::select_nodes for a selection of the command line. Throws UsageError that names the mistake.
std::vector<int> nodes_of(const std::string& selection, const fe::SolidMesh& mesh,
                          const std::vector<fe::Dof>& dofs, double length_unit);

/// The interfaces of a model. Arguments as of nodes_of. Throws UsageError that names the mistake.
std::vector<fe::Interface> read_interfaces(const InterfaceOptions& options, const fe::SolidMesh& mesh,
                                           const std::vector<fe::Dof>& dofs, double length_unit);

}  // namespace mimbre::app
