#include "mimbre/timings.h"

#include <algorithm>
#include <cmath>

#include "live/mailbox.h"

namespace mimbre {
namespace {

using live::increase;

constexpr double least = 1e-8, growth = 1.01;

/// Where bin k ends.
double edge(int k) { return least * std::pow(growth, k); }

}  // namespace

void Timings::add(double seconds) {
  static const double scale = 1 / std::log(growth);
  const double place = seconds > least ? std::ceil(scale * std::log(seconds / least)) : 0;
  increase<std::int64_t>(counts_[static_cast<std::size_t>(std::min<double>(place, bins - 1))], 1);
  increase<std::int64_t>(count_, 1);
  increase(sum_, std::max(seconds, 0.0));
  if (seconds > worst_.load(std::memory_order_relaxed)) worst_.store(seconds, std::memory_order_relaxed);
}

void Timings::add(const Timings& others) {
  for (std::size_t k = 0; k < counts_.size(); ++k)
    increase<std::int64_t>(counts_[k], others.counts_[k].load(std::memory_order_relaxed));
  increase<std::int64_t>(count_, others.count());
  increase(sum_, others.sum_.load(std::memory_order_relaxed));
  if (others.worst() > worst()) worst_.store(others.worst(), std::memory_order_relaxed);
}

std::int64_t Timings::count() const { return count_.load(std::memory_order_relaxed); }
double Timings::worst() const { return worst_.load(std::memory_order_relaxed); }
double Timings::mean() const { return count() > 0 ? sum_.load(std::memory_order_relaxed) / count() : 0; }

double Timings::quantile(double share) const {
  std::int64_t all = 0;
  for (const auto& bin : counts_) all += bin.load(std::memory_order_relaxed);
  const double wanted = std::clamp(share, 0.0, 1.0) * static_cast<double>(all);
  std::int64_t so_far = 0;
  for (int k = 0; k < bins && all > 0; ++k) {
    so_far += counts_[static_cast<std::size_t>(k)].load(std::memory_order_relaxed);
    if (so_far > 0 && static_cast<double>(so_far) >= wanted)
      return k == bins - 1 ? worst() : std::min(edge(k), worst());
  }
  return worst();
}

std::vector<std::int64_t> Timings::between(std::span<const double> edges) const {
  std::vector<std::int64_t> counts(edges.empty() ? 0 : edges.size() - 1, 0);
  for (int k = 0; k < bins; ++k) {
    const std::int64_t here = counts_[static_cast<std::size_t>(k)].load(std::memory_order_relaxed);
    if (here == 0) continue;
    const auto above = std::lower_bound(edges.begin(), edges.end(), edge(k) * (1 - 1e-9));
    if (above == edges.begin() || above == edges.end()) continue;
    counts[static_cast<std::size_t>(above - edges.begin() - 1)] += here;
  }
  return counts;
}

}  // namespace mimbre
