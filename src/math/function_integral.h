#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/array.h"
#include "math/quadrature.h"

namespace mimbre {

struct FunctionParts;

/// ∫ f from 0 to x of a function known by its values only, for an inner loop: the integrals up to the edges
/// of panels that were halved until halves and whole agree, and Gauss–Legendre (10 points) from the last edge
/// to x. Error about 1e-13 of ∫|f| within [0, end], for kinks and jumps too. Beyond, panels of mean width, at
/// most 10 000; before 0 one rule of 80 points.
class IntegralTable {
 public:
  IntegralTable() = default;
  template <class F>
  IntegralTable(F&& f, double end) {
    if (!(end > 0)) return;
    const auto magnitude = [&](double x) { return std::abs(f(x)); };
    double size = 0;
    for (int k = 0; k < first_panels; ++k)
      size += quadrature::panel(magnitude, end * k / first_panels, end * (k + 1) / first_panels);
    for (int k = 0; k < first_panels; ++k)
      add(f, end * k / first_panels, end * (k + 1) / first_panels, 1e-14 * size, deepest);
  }

  template <class F>
  double value(F&& f, double x) const {
    if (!(x >= 0)) return quadrature::integral(f, 0, x);
    const double end = edges_.back();
    if (x <= end) {
      const auto k =
          static_cast<std::size_t>(std::upper_bound(edges_.begin(), edges_.end(), x) - edges_.begin()) - 1;
      return values_[k] + (x > edges_[k] ? quadrature::panel(f, edges_[k], x) : 0);
    }
    const double panels = end > 0 ? std::ceil((x - end) / end * static_cast<double>(edges_.size() - 1)) : 8;
    const int n = static_cast<int>(std::clamp(panels, 1.0, 10000.0));
    double sum = values_.back();
    for (int k = 0; k < n; ++k)
      sum += quadrature::panel(f, end + (x - end) * k / n, end + (x - end) * (k + 1) / n);
    return sum;
  }

  /// The edges of the panels and the integrals up to them, for code that does the same elsewhere.
  struct Arrays {
    const Array<double>&edges, &values;
  };
  Arrays arrays() const { return {edges_, values_}; }

 private:
  friend FunctionParts;
  static constexpr int first_panels = 256, deepest = 40;
  static constexpr std::size_t most_panels = 200000;

  template <class F>
  void add(F&& f, double a, double b, double enough, int depth) {
    const double middle = 0.5 * (a + b);
    const double whole = quadrature::panel(f, a, b),
                 halves = quadrature::panel(f, a, middle) + quadrature::panel(f, middle, b);
    // Where it is not finite, halving does not help.
    if (depth > 0 && std::abs(whole - halves) > enough && edges_.size() < most_panels) {
      add(f, a, middle, enough, depth - 1);
      add(f, middle, b, enough, depth - 1);
      return;
    }
    edges_.push_back(b);
    values_.push_back(values_.back() + halves);
  }

  Array<double> edges_{0.0}, values_{0.0};
};

}  // namespace mimbre
