#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "portable/program.h"

/// Exact derivatives of recorded phases along a direction.
namespace mimbre::portable {

/// Where it is kept how a number varies. Memory::count: it does not. Nothing: it does, and that is not known.
using VariationOf = std::optional<Memory> (*)(Memory);
/// Of an instant, whose motion varies.
std::optional<Memory> variation_of(Memory memory);
/// Of what is looked at while the motion does not vary: by inputs and the time alone. How second derivatives
/// of signals by the time vary is not known.
std::optional<Memory> variation_at_rest(Memory memory);

/// For each phase, by name and in this order, another one, `d_NAME`, of how what it stores varies with how
/// what it reads does; what is stored without a variation of its own is left out. Each is made after `after`,
/// and after those of this list that come before it. `fixed`: nodes that do not vary. Throws NotRecordable
/// where a function's derivatives are not known that far.
void differentiate(Program& program, const std::vector<std::string>& phases, const std::vector<int>& after,
                   VariationOf of = variation_of, const std::vector<int>& fixed = {});

}  // namespace mimbre::portable
