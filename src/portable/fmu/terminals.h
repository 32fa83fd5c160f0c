#pragma once
#include <string>
#include <utility>
#include <vector>

#include "mimbre/fmu.h"
#include "mimbre/spec.h"

/// Terminals: variables of an FMU that belong together, by the parts of the model.
namespace mimbre::portable {

struct Terminal {
  std::string name;
  std::string
      rule;  ///< how members find those of another terminal: "plug" (all by name), "bus" (those there)
  std::string kind;
  std::string meaning;
  std::vector<std::pair<std::string, std::string>> members{};  ///< name in the terminal, and of the variable
  std::vector<Terminal> inner{};                               ///< vectors, each by its components
  bool takes = false;                                          ///< it has inputs
};

/// One for each part of the model that has outputs, or inputs that act on it alone, in the order of the
/// variables. A vector with all its components is a terminal within it, or where it is an array a member.
std::vector<Terminal> fmu_terminals(const FmuCode& fmu, const spec::Model& model);

/// terminalsAndIcons.xml of FMI 3.0, which FMI 2.0 takes over. The icons are fmu_icon's and terminal_icon's.
std::string terminals_description(const std::vector<Terminal>& terminals);

}  // namespace mimbre::portable
