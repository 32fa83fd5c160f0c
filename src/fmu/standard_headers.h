#pragma once
#include <span>

namespace mimbre::fmu {

struct StandardHeader {
  const char *name, *text;
};

/// The headers of FMI 2 and FMI 3 by their names: types and functions of both interfaces, as the standards
/// declare them, for sources of FMUs that do not bring them along.
std::span<const StandardHeader> standard_headers();

}  // namespace mimbre::fmu
