#pragma once
#include <limits>
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/state_transfer.h"

namespace mimbre {

/// Counts the values of inputs that were cut to the input's range. Allocates only when made, and when asked.
class RangeWatch {
 public:
  explicit RangeWatch(const Compiled& model);
  void start();
  /// `value` is set at `time`, s. The same value, set again and again, counts once.
  void set(int input, double value, double time);
  void transfer(StateTransfer& transfer);
  /// One for each input of which a value was cut.
  std::vector<std::string> warnings() const;

 private:
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  struct Watched {
    int input;
    int count = 0;
    double first = 0;     ///< s, when
    double farthest = 0;  ///< the value
    double last = none;   ///< the last value that was set, where it was cut
  };

  const Compiled& model_;
  std::vector<Watched> watched_;  ///< inputs with a range, in their order
};

}  // namespace mimbre
