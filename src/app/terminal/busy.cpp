#include "app/terminal/busy.h"

#include <fmt/format.h>

#include <bit>
#include <chrono>
#include <cstdio>
#include <utility>

#include "app/terminal/terminal_line.h"
#include "mimbre/text.h"

namespace mimbre::app {

Busy::Busy(std::string what, bool wanted) : what_(std::move(what)) {
  if (wanted) watcher_ = std::thread([this] { watch(); });
}

Busy::~Busy() {
  if (!watcher_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  ended_.notify_one();
  watcher_.join();
}

void Busy::now(std::string what) {
  const std::lock_guard lock(mutex_);
  what_ = std::move(what);
}

void Busy::watch() {
  constexpr std::chrono::seconds second{1};
  constexpr int first_line = 30;  // s
  const bool terminal = has_terminal_line();
  const auto start = std::chrono::steady_clock::now();
  bool shown = false;
  std::unique_lock lock(mutex_);
  for (int seconds = 1; !ended_.wait_until(lock, start + seconds * second, [this] { return end_; });
       ++seconds) {
    if (!terminal) {
      if (seconds % first_line == 0 && std::has_single_bit(static_cast<unsigned>(seconds / first_line)))
        fmt::print(stderr, "mimbre: note: {} takes {} s so far\n", printable(what_), seconds);
      continue;
    }
    show_terminal_line(fmt::format("{} … {} s (Ctrl-C stops it)", what_, seconds));
    shown = true;
  }
  if (shown) clear_terminal_line();
}

}  // namespace mimbre::app
