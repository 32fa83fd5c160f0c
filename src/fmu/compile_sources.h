#pragma once
#include <string>

#include "fmu/description.h"

namespace mimbre::fmu {

/// Compiles the sources of an FMU that are in `folder`/sources by the system's C compiler, `cc` or what the
/// environment variable CC names, into a shared library beside them; its path. The headers of the standard
/// are there for those that do not bring them along. Throws InputError that has the compiler's first
/// messages; `file`: the FMU, for these.
std::string compile_sources(const std::string& folder, const Description& description,
                            const std::string& file);

}  // namespace mimbre::fmu
