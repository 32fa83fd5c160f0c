#include "live/host.h"

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#ifdef __linux__
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#endif

#include "base/cpu_time.h"

namespace mimbre::live {

#ifdef __linux__

namespace {

constexpr std::int64_t second = 1'000'000'000;

std::int64_t nanoseconds(const timespec& t) { return second * t.tv_sec + t.tv_nsec; }

std::int64_t read_clock(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return nanoseconds(t);
}

std::string refused(const char* what, const char* remedy) {
  return fmt::format("{}: {} ({})", what, std::strerror(errno), remedy);
}

/// Pages of the stack are given when they are first touched.
void touch_stack() {
  constexpr std::size_t bytes = 256 * 1024;
  [[maybe_unused]] volatile char pages[bytes];
  for (std::size_t k = 0; k < bytes; k += 1024) pages[k] = 0;
}

}  // namespace

std::int64_t clock_now() { return read_clock(CLOCK_MONOTONIC); }

std::int64_t thread_cpu_now() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

void sleep_until(std::int64_t time) {
  const timespec t{static_cast<time_t>(time / second), static_cast<long>(time % second)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

ThreadUsage thread_usage() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_minflt + usage.ru_majflt, usage.ru_nivcsw};
}

struct RealTimeThread::Before {
  bool locked = false, scheduled = false, placed = false;
  int policy = SCHED_OTHER;
  sched_param parameters{};
  cpu_set_t processors{};
};

RealTimeThread::RealTimeThread(bool lock, int priority, int processor) : before_(std::make_unique<Before>()) {
  granted_.memory = "not locked";
  if (lock) {
    before_->locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    granted_.memory = before_->locked
                          ? "locked"
                          : refused("not locked", "the limit `ulimit -l`, or the capability CAP_IPC_LOCK");
  }
  touch_stack();

  before_->policy = sched_getscheduler(0);
  sched_getparam(0, &before_->parameters);
  granted_.scheduling = "as other programs";
  if (priority > 0) {
    sched_param asked{};
    asked.sched_priority = priority;
    before_->scheduled = sched_setscheduler(0, SCHED_FIFO, &asked) == 0;
    granted_.scheduling =
        before_->scheduled
            ? fmt::format("SCHED_FIFO, priority {}", priority)
            : refused("as other programs: SCHED_FIFO was refused",
                      "the limit `ulimit -r`, or the capability CAP_SYS_NICE; priorities are 1 to 99");
  }

  sched_getaffinity(0, sizeof before_->processors, &before_->processors);
  granted_.processor = "any";
  if (processor >= 0) {
    cpu_set_t one;
    CPU_ZERO(&one);
    if (processor < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(processor), &one);
    before_->placed = sched_setaffinity(0, sizeof one, &one) == 0;
    granted_.processor =
        before_->placed ? fmt::format("number {} alone", processor)
                        : refused("any", fmt::format("there is no processor {} here", processor).c_str());
  }
}

RealTimeThread::~RealTimeThread() {
  if (before_->placed) sched_setaffinity(0, sizeof before_->processors, &before_->processors);
  if (before_->scheduled) sched_setscheduler(0, before_->policy, &before_->parameters);
  if (before_->locked) munlockall();
}

#else

std::int64_t clock_now() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::int64_t thread_cpu_now() { return static_cast<std::int64_t>(1e9 * thread_cpu_seconds()); }

void sleep_until(std::int64_t time) {
  std::this_thread::sleep_until(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(time)));
}

ThreadUsage thread_usage() { return {}; }

struct RealTimeThread::Before {};

RealTimeThread::RealTimeThread(bool, int, int) {
  granted_ = {"not locked: this system has no such call here", "as other programs", "any"};
}

RealTimeThread::~RealTimeThread() = default;

#endif

}  // namespace mimbre::live
