#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/model.h"

/// Loads of a model that grow together, by one factor.
namespace mimbre {

struct GrowingLoads {
  std::vector<std::size_t> loads;  ///< of the spec
  bool weight = false;
  std::vector<std::string> names;  ///< of the loads, then "gravity"
};

/// Those that are wanted by name, or "gravity"; none: all of the model, or its weight where it has none.
/// Throws UnknownName, and InputError for a model that nothing loads.
GrowingLoads growing_loads(const spec::Model& spec, const std::vector<std::string>& wanted);

/// The model with these loads times the factor.
std::shared_ptr<const Model> loaded_by(const spec::Model& spec, const GrowingLoads& growing, double factor);

}  // namespace mimbre
