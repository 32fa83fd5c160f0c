#pragma once
#include <fmt/format.h>

#include <string>
#include <vector>

#include "compile/element_name.h"
#include "dynamics/natural/system.h"
#include "integrate/stepper.h"
#include "mimbre/unknown_name.h"
#include "simulation/step/energy.h"

/// What numbers of the step are called, for messages.
namespace mimbre {

/// Where a velocity coordinate belongs: "joint 'x'", "mode 2 of body 'arm'"; in natural coordinates (given
/// `natural`) the body. "the model" when the number is none.
std::string coordinate_name(const Compiled& model, const natural::NaturalSystem* natural, int coordinate);

/// The joint, drive or body that must stay rigid that a constraint equation belongs to.
std::string equation_name(const Compiled& model, const natural::NaturalSystem* natural, int equation);

/// The constraint that an equation belongs to; null: it is of a joint, a drive or a body.
const ConstraintData* constraint_of(const Compiled& model, const natural::NaturalSystem* natural,
                                    int equation);

/// What stores energy.
std::string place_name(const Compiled& model, const EnergyMeter::Place& place);

/// Place of the item of that name. Throws UnknownName, with a name that is like it, where there is none.
template <class Items>
int find_by_name(const Items& items, const std::string& name, const char* what) {
  for (std::size_t k = 0; k < items.size(); ++k)
    if (items[k].name == name) return static_cast<int>(k);
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  throw UnknownName(Mark{}, fmt::format("there is no {} '{}'{}", what, name, did_you_mean(name, names)));
}

}  // namespace mimbre
