#pragma once
#include <string>
#include <vector>

#include "app/options.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::app {

/// What the options of `mimbre reduce` say of the interfaces.
struct InterfaceOptions {
  std::vector<std::string> interfaces, means, points, axes, freed, held;
};
void add_interface_options(Parser& parser, InterfaceOptions& options);

/// fe::select_nodes for a selection of the command line. Throws UsageError that says what is wrong.
std::vector<int> nodes_of(const std::string& selection, const fe::SolidMesh& mesh,
                          const std::vector<fe::Dof>& dofs, double length_unit);

/// The interfaces of a model. Arguments as of nodes_of. Throws UsageError that says what is wrong.
std::vector<fe::Interface> read_interfaces(const InterfaceOptions& options, const fe::SolidMesh& mesh,
                                           const std::vector<fe::Dof>& dofs, double length_unit);

}  // namespace mimbre::app
