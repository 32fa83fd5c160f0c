#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/method_arguments.h"
#include "mimbre/model.h"

namespace mimbre::python {

/// A compiled model with what was said while it was read.
struct LoadedModel {
  std::shared_ptr<const Model> model;
  std::vector<Diagnostic> warnings;
  std::vector<std::string> other_files;           ///< that were read with it
  std::map<std::string, std::string> parameters;  ///< that were replaced
};

/// How a run is computed: what was asked for, checked.
struct MethodChoice {
  RunOptions asked;

  /// For a model whose file says `given`. Throws UsageError where they do not fit together.
  RunOptions options(const spec::Simulation& given) const;
};

}  // namespace mimbre::python
