#include "spec/road_height.h"

#include <utility>

namespace mimbre {

Function road_height(std::vector<double> x, std::vector<double> z, std::optional<double> period) {
  // A table goes on with the slopes of its ends, and is level beyond a jump there.
  const std::size_t n = x.size();
  if (n > 1 && n == z.size()) {
    const bool before = !period && x[0] < x[1] && z[0] != z[1],
               behind = (!period || *period > (x[n - 1] - x[0]) * (1 + 1e-12)) && x[n - 2] < x[n - 1] &&
                        z[n - 2] != z[n - 1];
    if (behind) {
      x.push_back(x.back());
      z.push_back(z.back());
    }
    if (before) {
      x.insert(x.begin(), x.front());
      z.insert(z.begin(), z.front());
    }
  }
  const double start = n > 0 ? x.front() : 0;
  const Function height = Function::table(std::move(x), std::move(z), Function::Interpolation::linear);
  return period ? height.repeated(start, *period) : height;
}

}  // namespace mimbre
