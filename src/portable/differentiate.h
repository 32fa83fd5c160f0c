#pragma once
#include <string>
#include <utility>
#include <vector>

#include "portable/program.h"

/// Exact derivatives of recorded phases along a direction.
namespace mimbre::portable {

/// Where it is kept how a number varies; Memory::count: it does not.
Memory variation_of(Memory memory);

/// For each phase, by name and in this order, another one, `d_NAME`, of how what it stores varies with how
/// what it reads does; what is stored without a variation of its own is left out. Each is made after `after`,
/// and after those of this list that come before it. Throws NotRecordable where a function's derivatives are
/// not known that far.
void differentiate(Program& program, const std::vector<std::string>& phases, const std::vector<int>& after);

}  // namespace mimbre::portable
