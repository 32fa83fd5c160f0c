#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

namespace mimbre {

/// How often which time was measured, s: in bins whose edges grow by 1 % from 10 ns to some 130 s, and the
/// extremes exactly. One thread adds; others may read meanwhile, without locks.
class Timings {
 public:
  /// Allocates nothing. What is negative counts as 0.
  void add(double seconds);

  /// What others measured, too.
  void add(const Timings& others);

  std::int64_t count() const;
  double worst() const;
  double mean() const;
  /// The least time that at least this share (0 to 1) of the measured ones do not exceed, at most 1 % too
  /// large and never too small. 0 where nothing was measured.
  double quantile(double share) const;
  /// How many lie between each two of the edges (ascending, s), as far as the bins resolve that.
  std::vector<std::int64_t> between(std::span<const double> edges) const;

 private:
  static constexpr int bins = 2340;
  std::array<std::atomic<std::int64_t>, bins> counts_{};
  std::atomic<std::int64_t> count_{0};
  std::atomic<double> sum_{0}, worst_{0};
};

}  // namespace mimbre
