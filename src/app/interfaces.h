#pragma once
#include <memory>
#include <string>
#include <vector>

#include "app/common.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::app {

/// What the options of `mimbre reduce` say of the interfaces.
struct InterfaceOptions {
  std::vector<std::string> interfaces, means, points, axes, freed, held;
};
void add_interface_options(CLI::App& parser, InterfaceOptions& options);

/// The interfaces of a model. Arguments as of select_nodes. Throws UsageError that says what is wrong.
std::vector<fe::Interface> read_interfaces(const InterfaceOptions& options, const fe::SolidMesh& mesh,
                                           const std::vector<fe::Dof>& dofs, double length_unit);

}  // namespace mimbre::app
