#pragma once
#include <memory>
#include <string>

#include "mimbre/real_time.h"
#include "mimbre/real_time_recorder.h"

namespace mimbre {

struct LiveServerOptions {
  /// Numeric, of IPv4 or IPv6. Only what is not the loopback interface is reached from other machines.
  std::string address = "127.0.0.1";
  int port = 0;  ///< 0: one that is free
  /// What a viewer must know; empty: nothing, but where others can reach it a random one is made.
  std::string token;
  RealTimeRecorder* recorder = nullptr;  ///< that a viewer may switch on and off
};

/// Shows a loop to any number of viewers, of whom one may have control, by HTTP and WebSocket
/// (docs/live-protocol.md). A thread of its own serves them: whatever they do, the loop does not wait. It
/// must live as long as the loop runs, and be made before.
class LiveServer {
 public:
  /// Takes part in the loop. Throws InputError where the address is none, std::runtime_error where it cannot
  /// be listened at.
  LiveServer(Simulation& simulation, RealTimeLoop& loop, const LiveServerOptions& options);
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// Of the page, with the token where there is one.
  std::string url() const;
  int port() const;
  /// Whether the page was built in; without it there is the protocol alone.
  static bool has_page();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre
