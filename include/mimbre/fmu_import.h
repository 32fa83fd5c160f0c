#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/outside_block.h"

/// Functional mock-up units (FMI 2.0 and 3.0, https://fmi-standard.org) for co-simulation as blocks of
/// signals.
namespace mimbre {

/// What a model chooses of an FMU.
struct FmuSettings {
  std::string file;
  /// Names of variables, in the order of the block's values. An element of an array of FMI 3 is `name[2]` or
  /// `name[2,3]`, counted from 1.
  std::vector<std::string> inputs, outputs;
  /// Start values of parameters and other variables, as text: "1.5", "true", "name".
  std::map<std::string, std::string> parameters;
  /// Of which inputs the FMU's step from t − h to t is made: those of t − h, or (true) those of t.
  bool inputs_of_the_end = false;
  bool process = false;  ///< it runs in a process of its own
  double timeout = 30;   ///< s of the clock, that a call in another process may take
};

/// Reads the FMU's description and takes what is asked for from it; nothing of its code is loaded before an
/// instance is made. Throws InputError: where the file is no FMU or damaged, has no co-simulation, has no
/// variable of a name, or a value is not of its type.
std::shared_ptr<const OutsideBlock> load_fmu(const FmuSettings& settings);

}  // namespace mimbre
