#pragma once
#include <stdexcept>

namespace mimbre {

/// Options that do not fit together, or text that is no option's value. The message names options as the
/// command line does.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace mimbre
