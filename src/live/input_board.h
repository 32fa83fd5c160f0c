#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "live/mailbox.h"
#include "mimbre/real_time.h"

namespace mimbre::live {

/// Values of an input over time, s from the beginning of their playback.
struct InputTrack {
  int input = -1;
  std::vector<double> times, values;
  std::size_t next = 0;  ///< the first point that is after now
};
using InputTracks = std::vector<InputTrack>;

/// An input was set. `input` −1: the simulation was put elsewhere, and what follows are the values there.
struct InputChange {
  double time = 0;  ///< s, of the simulation
  int input = -1;
  double value = 0;
};

/// Inputs that another thread sets, or that are played from tables; what they were is available to it.
class InputBoard : public RealTimePart {
 public:
  explicit InputBoard(const Simulation& simulation);
  ~InputBoard() override;

  // Of the other thread.
  void set(int input, double value);
  /// Before the simulation is asked to be put elsewhere: what was set until now and not taken by a step is of
  /// no account there.
  void drop() { dropped_.store(version_.load(std::memory_order_relaxed), std::memory_order_release); }
  /// From the next step on; null ends what is being played. False where too many are asked for at once.
  bool play(std::unique_ptr<InputTracks> tracks);
  /// How often something has begun to be played: one that is over already has been played, too. To be asked
  /// for before playing().
  std::uint32_t played() const { return begun_.load(std::memory_order_acquire); }
  bool playing() const { return playing_.load(std::memory_order_relaxed); }
  /// The oldest change that it has not received yet; null where there is none. Then pop_change().
  const InputChange* change() { return changes_.front(); }
  void pop_change() { changes_.pop(); }
  /// Deletes what was played.
  void tidy();

  void before(Simulation& simulation) override;
  void rests(Simulation& simulation) override;
  void moved(Simulation& simulation) override;

 private:
  struct Wanted {
    std::atomic<double> value{0};
    std::atomic<std::uint32_t> version{0};  ///< of the board when it was set
    std::uint32_t taken = 0;
  };
  void put(Simulation& simulation, int input, double value);
  void take_played(Simulation& simulation);
  void tell_all(Simulation& simulation);

  std::vector<std::unique_ptr<Wanted>> wanted_;
  std::atomic<std::uint32_t> version_{0}, dropped_{0};
  std::uint32_t taken_ = 0, since_version_ = 0;  ///< since then, where the simulation was put elsewhere
  Queue<InputTracks*> to_play_{8}, played_{16};
  InputTracks* tracks_ = nullptr;
  double since_ = 0;  ///< s, when they began
  std::atomic<bool> playing_{false};
  std::atomic<std::uint32_t> begun_{0};
  Queue<InputChange> changes_{1 << 14};
  bool told_ = false;
};

}  // namespace mimbre::live
