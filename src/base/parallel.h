#pragma once
#include <algorithm>
#include <exception>
#include <thread>
#include <vector>

/// Loops over std::thread.
namespace mimbre {

/// As many threads as the machine runs at once.
inline int hardware_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

/// Calls body(begin, end) for the consecutive ranges between `bounds`, each in a thread of its own. Of the
/// exceptions thrown that of the first range comes out.
template <class Body>
void parallel_ranges(const std::vector<int>& bounds, const Body& body) {
  const int ranges = static_cast<int>(bounds.size()) - 1;
  std::vector<std::exception_ptr> errors(std::max(ranges, 0));
  const auto guarded = [&](int r) {
    try {
      body(bounds[r], bounds[r + 1]);
    } catch (...) {
      errors[r] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int r = 1; r < ranges; ++r) threads.emplace_back(guarded, r);
    if (ranges > 0) guarded(0);
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

/// 0..count in `ranges` parts of about the same length.
inline std::vector<int> even_bounds(int count, int ranges) {
  std::vector<int> bounds;
  for (int r = 0; r <= ranges; ++r)
    bounds.push_back(static_cast<int>(static_cast<long long>(count) * r / ranges));
  return bounds;
}

}  // namespace mimbre
