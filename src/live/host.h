#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "mimbre/real_time.h"

/// What the operating system gives to a thread that has to be in time. Only here does the code know of Linux;
/// elsewhere there is the clock alone.
namespace mimbre::live {

/// ns of a clock that only goes forward.
std::int64_t clock_now();
/// CPU time of the calling thread, ns.
std::int64_t thread_cpu_now();
/// Sleeps until the clock is there; does nothing when it is past.
void sleep_until(std::int64_t time);

/// Counted since the calling thread began.
struct ThreadUsage {
  std::int64_t page_faults = 0;
  std::int64_t preemptions = 0;  ///< it was taken from the processor though it could have gone on
};
ThreadUsage thread_usage();

/// For the calling thread, as long as this lives: the whole process's memory stays in place (`lock`),
/// SCHED_FIFO with `priority` (0: as it was), one processor (negative: any). Touches the stack.
class RealTimeThread {
 public:
  RealTimeThread(bool lock, int priority, int processor);
  ~RealTimeThread();
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;
  const RealTimeGrants& granted() const { return granted_; }

 private:
  struct Before;  ///< what is put back
  RealTimeGrants granted_;
  std::unique_ptr<Before> before_;
};

}  // namespace mimbre::live
