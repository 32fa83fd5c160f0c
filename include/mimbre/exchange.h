#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/real_time.h"

/// Another program takes part in a loop: it gets channels after each step, and sets inputs before it
/// (docs/exchange.md, exchange_layout.h).
namespace mimbre {

struct ExchangeOptions {
  /// Names of channels that it is given; empty: the model's outputs.
  std::vector<std::string> outputs;
  /// Names of inputs that it sets; empty: all that are no tunable parameters.
  std::vector<std::string> inputs;
};

struct UdpOptions : ExchangeOptions {
  std::string address = "127.0.0.1";  ///< numeric, where packets are taken
  int port = 0;                       ///< 0: one that is free
  /// s: so long at most a step waits for the inputs that answer the last outputs, once a peer is there. 0: it
  /// takes what has come.
  double wait = 0;
};

/// By UDP: a program that sends a hello receives the names, and a packet after each step.
class UdpExchange : public RealTimePart {
 public:
  /// Throws UnknownName for names that the simulation does not have, InputError where there are too many or
  /// the address is none, std::runtime_error where the port cannot be had.
  UdpExchange(const Simulation& simulation, const UdpOptions& options);
  ~UdpExchange() override;
  void before(Simulation& simulation) override;
  void after(Simulation& simulation, const StepReport& report, bool output) override;
  void rests(Simulation& simulation) override;

  int port() const;
  /// From when outputs were sent until the inputs that answer them arrived, s.
  const Timings& round_trips() const;
  /// Packets that were none of ours, or of another layout.
  std::int64_t refused() const;
  /// Answers that a step waited for in vain.
  std::int64_t missed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// In shared memory of the name `/NAME` (shm_open), which is gone when this is.
class SharedMemoryExchange : public RealTimePart {
 public:
  /// Throws as UdpExchange, and std::runtime_error where there is such memory already or none can be had.
  SharedMemoryExchange(const Simulation& simulation, const std::string& name, const ExchangeOptions& options);
  ~SharedMemoryExchange() override;
  void before(Simulation& simulation) override;
  void after(Simulation& simulation, const StepReport& report, bool output) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre
