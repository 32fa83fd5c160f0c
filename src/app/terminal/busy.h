#pragma once
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace mimbre::app {

/// Reports on the terminal what is being done once that has taken a second, and for how long. Where stderr is
/// no terminal, a line each after half a minute, one, two, four, … For work whose progress is not known.
class Busy {
 public:
  explicit Busy(std::string what, bool wanted = true);
  ~Busy();
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;
  /// The next thing that is being done.
  void now(std::string what);

 private:
  void watch();

  std::mutex mutex_;
  std::condition_variable ended_;
  std::string what_;
  bool end_ = false;
  std::thread watcher_;  ///< the last member: it uses the others
};

}  // namespace mimbre::app
