#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre::python {

/// A force law that is a function, and the signals that it takes.
struct UserLaw {
  std::shared_ptr<const spec::UserLaw> law;
  std::vector<std::string> signals;  ///< or inputs
};

/// Where a model has one: in place of the actuator or bushing that stands for it in the model's text.
struct PlacedLaw {
  std::string section;   ///< "actuator" or "bushing"
  std::string instance;  ///< "front_left.", of which names mean its own things first; empty: the model
  std::string name;      ///< there
  UserLaw law;
};

/// Throws InputError where a signal is not there.
void put_laws(spec::Model& model, const std::vector<PlacedLaw>& laws);

}  // namespace mimbre::python
