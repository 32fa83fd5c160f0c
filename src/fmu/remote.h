#pragma once
#include <sys/types.h>

#include <memory>
#include <string>

#include "fmu/package.h"
#include "fmu/process/protocol.h"
#include "mimbre/outside_block.h"

namespace mimbre::fmu {

/// An instance in a process of its own (src/fmu/process), which ends with it. What does not answer in time is
/// ended.
class RemoteInstance : public OutsideInstance {
 public:
  /// `timeout`: s of the clock, of each call.
  RemoteInstance(std::shared_ptr<const Package> package, double timeout, int inputs, int outputs);
  ~RemoteInstance() override;

  bool open(const Plan& plan);
  bool exchange(const Instant& instant) override;
  bool save(std::vector<std::byte>& state) override;
  bool restore(std::span<const std::byte> state) override;
  std::string message() const override { return message_; }
  std::string warning() const override;

 private:
  bool start();
  bool fail(const std::string& what);
  /// Ends the process; how it ended, for people.
  std::string stop(bool kill_it) const;
  bool ask(Request request, const char* during, std::size_t expected) const;
  bool transmit(const void* bytes, std::size_t count) const;
  bool receive(void* bytes, std::size_t count, double until) const;

  std::shared_ptr<const Package> package_;
  const double timeout_;
  const int inputs_, outputs_;
  mutable std::string message_;
  mutable int socket_ = -1;
  mutable pid_t child_ = 0;
  mutable bool late_ = false;
  mutable std::vector<char> sent_, answer_;
};

}  // namespace mimbre::fmu
