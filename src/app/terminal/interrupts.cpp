#include "app/terminal/interrupts.h"

#include <signal.h>

#include <atomic>

namespace mimbre::app {
namespace {

std::atomic<bool> stop_wanted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal's handler sets it");

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_wanted.store(true, std::memory_order_relaxed); };
  sigemptyset(&action.sa_mask);
  // Writes that are under way go on; a second signal finds the default action.
  action.sa_flags = SA_RESTART | SA_RESETHAND;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(number, nullptr, &before);
    // What the caller has ignored, as nohup does with hang-ups, stays ignored.
    if (before.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);
  }
}

bool interrupted() { return stop_wanted.load(std::memory_order_relaxed); }

}  // namespace mimbre::app
