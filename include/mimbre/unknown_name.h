#pragma once
#include "mimbre/diagnostics.h"

namespace mimbre {

/// Thrown where something is asked for by a name that is not there. The message contains the nearest name.
class UnknownName : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace mimbre
