#pragma once
#include <fmt/format.h>

#include <limits>
#include <string>
#include <string_view>

namespace mimbre {

/// A number of a law, a constraint or a block by its key in the model file.
struct LawNumber {
  static constexpr double none = std::numeric_limits<double>::infinity();
  std::string_view key = {};
  std::string_view unit = {};  ///< "m|rad": the second on an angle
  std::string_view about = {};
  double otherwise = std::numeric_limits<double>::quiet_NaN();  ///< where it is not given; NaN: it must be
  double above = -none;                                         ///< it has to be more than this,
  double least = -none, most = none;                            ///< and may be these

  constexpr bool allows(double x) const { return x > above && x >= least && x <= most; }
};

/// Why it does not allow x.
inline std::string wrong_number(const LawNumber& number, double x) {
  if (!(x > number.above)) return fmt::format("is {}; it has to be above {}", x, number.above);
  if (!(x >= number.least)) return fmt::format("is {}; it cannot be below {}", x, number.least);
  return fmt::format("is {}; it can be at most {}", x, number.most);
}

}  // namespace mimbre
