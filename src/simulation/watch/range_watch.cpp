#include "simulation/watch/range_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mimbre {
namespace {

/// How far a value lies beyond the range; 0 or less: it does not.
double beyond(const spec::Input& input, double value) {
  return std::max(input.min - value, value - input.max);
}

}  // namespace

RangeWatch::RangeWatch(const Compiled& model) : model_(model) {
  const std::vector<spec::Input>& inputs = model.spec().inputs;
  for (std::size_t k = 0; k < inputs.size(); ++k)
    if (std::isfinite(inputs[k].min) || std::isfinite(inputs[k].max))
      watched_.push_back({static_cast<int>(k)});
}

void RangeWatch::start() {
  for (Watched& w : watched_) w = {w.input};
}

void RangeWatch::set(int input, double value, double time) {
  const auto found = std::lower_bound(watched_.begin(), watched_.end(), input,
                                      [](const Watched& w, int i) { return w.input < i; });
  if (found == watched_.end() || found->input != input) return;
  Watched& w = *found;
  const spec::Input& info = model_.spec().inputs[static_cast<std::size_t>(input)];
  const double by = beyond(info, value);
  if (!(by > 0)) {
    w.last = none;
    return;
  }
  if (value == w.last) return;
  w.last = value;
  if (w.count == 0) w.first = time;
  if (w.count == 0 || by > beyond(info, w.farthest)) w.farthest = value;
  ++w.count;
}

void RangeWatch::transfer(StateTransfer& transfer) {
  for (Watched& w : watched_) transfer(w.count, w.first, w.farthest, w.last);
}

std::vector<std::string> RangeWatch::warnings() const {
  std::vector<std::string> all;
  for (const Watched& w : watched_) {
    if (w.count == 0) continue;
    const spec::Input& input = model_.spec().inputs[static_cast<std::size_t>(w.input)];
    all.push_back(
        fmt::format("input '{}': {} beyond its range [{}, {}] and cut to it, the first at t = {:.6g} s; the "
                    "farthest was {:.6g}",
                    input.name, w.count == 1 ? "1 value was" : fmt::format("{} values were", w.count),
                    input.min, input.max, w.first, w.farthest));
  }
  return all;
}

}  // namespace mimbre
