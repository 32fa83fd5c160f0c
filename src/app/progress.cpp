#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace mimbre::app {
namespace {

constexpr int bar_width = 30;
constexpr std::chrono::milliseconds least_interval{100};

}  // namespace

Progress::Progress(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) == 1) {}
Progress::~Progress() { clear(); }

void Progress::update(double time, double end, double cpu_seconds) {
  if (!shown_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + least_interval;
  drawn_ = true;
  const double part = end > 0 ? std::clamp(time / end, 0.0, 1.0) : 1.0;
  const int filled = static_cast<int>(part * bar_width);
  fmt::print(stderr, "\r[{}{}] {:3.0f} %  t = {:.3f} s", std::string(filled, '#'),
             std::string(bar_width - filled, ' '), 100 * part, time);
  if (cpu_seconds > 0) fmt::print(stderr, "  {:.3g} x real time", time / cpu_seconds);
  fmt::print(stderr, "\033[K");
  std::fflush(stderr);
}

void Progress::update(const std::string& stage, double done) {
  if (!shown_) return;
  drawn_ = true;
  const int filled = static_cast<int>(std::clamp(done, 0.0, 1.0) * bar_width);
  fmt::print(stderr, "\r[{}{}] {}\033[K", std::string(filled, '#'), std::string(bar_width - filled, ' '),
             stage);
  std::fflush(stderr);
}

void Progress::clear() {
  if (drawn_) fmt::print(stderr, "\r\033[K");
  drawn_ = false;
}

}  // namespace mimbre::app
