#pragma once
#include <functional>
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "mimbre/function.h"

/// Drives that no step can follow.
namespace mimbre {

/// A jump of a function, or of its slope.
struct Break {
  enum class Kind { none, jump, kink } kind = Kind::none;
  double at = 0;    ///< s
  double size = 0;  ///< of the change, of the value or of the slope
};

/// The largest one from 0 to `end`, a jump before a kink. Looks at 4000 places and then closely where the
/// curvature is largest; smooth laws, however sharp down to a microsecond, have none.
Break largest_break(const Function& law, double end);
Break largest_break(const std::function<double(double)>& law, double end);

/// A warning for each driven coordinate with one: velocities or positions cannot change at once without a
/// impact, which no row of the results shows.
std::vector<std::string> drive_warnings(const Compiled& model, double end);

}  // namespace mimbre
