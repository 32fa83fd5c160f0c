#pragma once
#include <vector>

#include "compile/compiled.h"

namespace mimbre {

/// How the motion that an element measures comes back to it by way of signals, as force: what lies between
/// the sensors of that motion and the signal of the element's law. Slots are those of SignalValues.
struct FeedbackPath {
  struct Own {
    int slot;
    bool is_rate;
  };
  std::vector<Own> own;       ///< sensors of the element's motion
  std::vector<int> given;     ///< slots that the path takes and that do not go by this motion
  std::vector<int> computed;  ///< places in SignalsData::moving, in their order
  bool closed = false;        ///< the motion does come back
};

/// Those of all elements, by their places in Compiled::elements. What a block makes in a loop that it closes
/// counts as given before it is made: it is of the order of the step.
std::vector<FeedbackPath> feedback_paths(const Compiled& m);

}  // namespace mimbre
