#include "analysis/equilibria/growing_loads.h"

#include <fmt/format.h>

#include <algorithm>

#include "mimbre/diagnostics.h"
#include "mimbre/unknown_name.h"

namespace mimbre {

GrowingLoads growing_loads(const spec::Model& spec, const std::vector<std::string>& wanted) {
  GrowingLoads growing;
  std::vector<std::string> names;
  for (const spec::Load& load : spec.loads) names.push_back(load.name);
  for (std::size_t k = 0; k < names.size() && wanted.empty(); ++k) growing.loads.push_back(k);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const std::string& name = wanted[k];
    if (std::find(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(k), name) !=
        wanted.begin() + static_cast<std::ptrdiff_t>(k))
      throw InputError(Mark{}, fmt::format("load '{}' is named twice", name));
    const auto at = std::find(names.begin(), names.end(), name);
    if (name == "gravity" && at == names.end())
      growing.weight = true;
    else if (at == names.end())
      throw UnknownName(Mark{}, fmt::format("there is no load '{}'{}", name, did_you_mean(name, names)));
    else
      growing.loads.push_back(static_cast<std::size_t>(at - names.begin()));
  }
  if (wanted.empty() && growing.loads.empty()) growing.weight = true;
  if (growing.weight && spec.gravity.isZero())
    throw InputError({spec.file, 0, 0},
                     "nothing loads the model: it has no gravity, and no loads that could grow");
  for (const std::size_t k : growing.loads) growing.names.push_back(names[k]);
  if (growing.weight) growing.names.emplace_back("gravity");
  return growing;
}

std::shared_ptr<const Model> loaded_by(const spec::Model& given, const GrowingLoads& growing, double factor) {
  spec::Model spec = given;
  for (const std::size_t k : growing.loads) {
    spec.loads[k].force *= factor;
    spec.loads[k].moment *= factor;
  }
  if (growing.weight) spec.gravity *= factor;
  return Model::compile(std::move(spec));
}

}  // namespace mimbre
