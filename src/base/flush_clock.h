#pragma once
#include <chrono>

namespace mimbre {

/// When what waits in memory is to be written, so that a program that is killed loses at most a second.
class FlushClock {
 public:
  bool due() const { return std::chrono::steady_clock::now() - last_ >= longest_wait; }
  void reset() { last_ = std::chrono::steady_clock::now(); }

 private:
  static constexpr std::chrono::milliseconds longest_wait{500};
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace mimbre
