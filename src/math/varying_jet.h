#pragma once
#include <cmath>

#include "math/jet.h"

/// A jet with its derivative by one parameter: the third derivatives of a formula, exact.
namespace mimbre {

struct VaryingJet {
  Jet at, by;  ///< the jet, and its derivative
};

inline bool varies(const VaryingJet& x) {
  return varies(x.at) || x.by.value != 0 || x.by.first != 0 || x.by.second != 0;
}
inline double value_of(const VaryingJet& x) { return x.at.value; }
inline void set_constant(VaryingJet& x, double value) { x = {{value, 0, 0}, {0, 0, 0}}; }
inline VaryingJet mean(const VaryingJet& a, const VaryingJet& b) {
  const Jet at = mean(a.at, b.at), by = mean(a.by, b.by);
  return {at, {0.5 * (a.by.value + b.by.value), by.first, by.second}};
}

/// A slope times a derivative, which is 0 where nothing varies, however steep the function is there.
inline Jet along(const Jet& slope, const Jet& derivative) {
  return derivative.value == 0 && derivative.first == 0 && derivative.second == 0 ? Jet{0, 0, 0}
                                                                                  : slope * derivative;
}

inline VaryingJet operator+(const VaryingJet& a, const VaryingJet& b) { return {a.at + b.at, a.by + b.by}; }
inline VaryingJet operator-(const VaryingJet& a, const VaryingJet& b) { return {a.at - b.at, a.by - b.by}; }
inline VaryingJet operator-(const VaryingJet& a) { return {-a.at, -a.by}; }
inline VaryingJet operator*(const VaryingJet& a, const VaryingJet& b) {
  return {a.at * b.at, along(a.at, b.by) + along(b.at, a.by)};
}
inline VaryingJet operator/(const VaryingJet& a, const VaryingJet& b) {
  const Jet q = a.at / b.at;
  return {q, (a.by - along(q, b.by)) / b.at};
}

}  // namespace mimbre
