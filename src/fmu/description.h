#pragma once
#include <optional>
#include <string>
#include <vector>

#include "fmu/plan.h"

namespace mimbre::fmu {

struct Variable {
  std::string name;
  std::uint32_t reference = 0;
  Type type = Type::other;
  std::string type_name;  ///< as the file has it: Real, Float64, …
  std::string causality, variability, initial;
  /// Of an array of FMI 3; empty: a scalar. Sizes that structural parameters decide are those of their start
  /// values.
  std::vector<std::uint64_t> dimensions;
  std::optional<std::vector<std::string>> start;

  std::uint64_t size() const;  ///< elements
};

/// What modelDescription.xml says of the co-simulation.
struct Description {
  int version = 2;  ///< of FMI
  std::string model_name, token, identifier;
  bool once_per_process = false, saves_state = false;
  bool needs_tool = false;  ///< another program computes it
  std::vector<Variable> variables;
  std::vector<std::string> sources;  ///< of FMI 2, in its folder `sources`

  const Variable* find(const std::string& name) const;
  std::vector<std::string> names(const std::string& causality) const;
};

/// Reads it. `file`: for messages. Throws InputError.
Description read_description(const std::string& xml, const std::string& file);

/// What buildDescription.xml has for a model identifier.
struct Sources {
  std::vector<std::string> files, definitions, include_folders, libraries;
};
/// Throws InputError.
Sources read_build_description(const std::string& xml, const std::string& identifier,
                               const std::string& file);

}  // namespace mimbre::fmu
