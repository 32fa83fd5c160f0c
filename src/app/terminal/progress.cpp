#include "app/terminal/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "app/terminal/terminal_line.h"

namespace mimbre::app {
namespace {

constexpr int bar_width = 30;
constexpr std::chrono::milliseconds least_interval{100};

}  // namespace

Progress::Progress(bool wanted) : shown_(wanted && has_terminal_line()) {}
Progress::~Progress() { clear(); }

void Progress::update(double time, double end, double cpu_seconds) {
  if (!shown_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + least_interval;
  drawn_ = true;
  const double part = end > 0 ? std::clamp(time / end, 0.0, 1.0) : 1.0;
  const int filled = static_cast<int>(part * bar_width);
  std::string line = fmt::format("[{}{}] {:3.0f} %  t = {:.3f} s", std::string(filled, '#'),
                                 std::string(bar_width - filled, ' '), 100 * part, time);
  if (cpu_seconds > 0) line += fmt::format("  {:.3g} x real time", time / cpu_seconds);
  show_terminal_line(line);
}

void Progress::update(const std::string& stage, double done) {
  if (!shown_) return;
  drawn_ = true;
  const int filled = static_cast<int>(std::clamp(done, 0.0, 1.0) * bar_width);
  show_terminal_line(
      fmt::format("[{}{}] {}", std::string(filled, '#'), std::string(bar_width - filled, ' '), stage));
}

void Progress::clear() {
  if (drawn_) clear_terminal_line();
  drawn_ = false;
}

}  // namespace mimbre::app
