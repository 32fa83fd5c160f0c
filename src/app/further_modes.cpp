#include "app/further_modes.h"

#include <fmt/format.h>

#include <cstdlib>

#include "app/commands/interfaces.h"

namespace mimbre::app {

std::vector<fe::SpreadLoad> loads_of(const std::vector<std::string>& texts, const fe::SolidMesh& mesh,
                                     const std::vector<fe::Dof>& dofs, double length_unit) {
  std::vector<fe::SpreadLoad> loads;
  for (const std::string& text : texts) {
    const auto bad = [&]() -> UsageError {
      return UsageError(
          fmt::format("--load '{}': NAME=SELECTION,fx,fy,fz is needed, as seat=group:seat,0,0,-1", text));
    };
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) throw bad();
    fe::SpreadLoad load;
    load.name = text.substr(0, equals);
    // A selection may have commas: the force is the last three fields.
    std::string rest = text.substr(equals + 1);
    for (int i = 2; i >= 0; --i) {
      const std::size_t comma = rest.rfind(',');
      if (comma == std::string::npos) throw bad();
      const std::string field = rest.substr(comma + 1);
      char* end = nullptr;
      load.force[i] = std::strtod(field.c_str(), &end);
      if (field.empty() || *end != '\0') throw bad();
      rest.resize(comma);
    }
    if (!load.force.allFinite() || load.force.isZero(0))
      throw UsageError(fmt::format("--load '{}': the force must be finite and not zero", text));
    load.nodes = nodes_of(rest, mesh, dofs, length_unit);
    loads.push_back(std::move(load));
  }
  return loads;
}

}  // namespace mimbre::app
