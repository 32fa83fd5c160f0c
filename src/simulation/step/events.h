#pragma once
#include <vector>

#include "dynamics/state_transfer.h"
#include "mimbre/simulation.h"
#include "simulation/step/signal_state.h"
#include "simulation/watch/range_watch.h"

namespace mimbre {

/// The events of a mechanism in motion: on which side of zero the value of each is, and what follows when it
/// is on the other side. A value of exactly zero is on neither, and leaving it is no crossing. Continuous
/// relays are events too, which nobody receives: they switch themselves where a step ends.
class Events {
 public:
  /// `ranges` receives what events set, and outlives them.
  Events(const Compiled& model, RangeWatch& ranges);
  bool none() const { return events_.empty() && relays_.empty(); }
  /// What has to be evaluated for them.
  Channels::Needs needs() const { return needs_; }

  /// Takes the values as they are, without anything happening.
  void start(const Channels& channels, relative::RelativeSystem& system, const State& seen);
  /// Where a part of a step begins: which relays are high.
  void see_relays(const relative::RelativeSystem& system);
  /// Evaluates them. True where one has crossed in the direction that it waits for.
  bool look(const Channels& channels, relative::RelativeSystem& system, const State& seen);
  /// The values of the last look() are those at an end of the interval in which the first crossing is.
  enum class End { before, beyond };
  void keep(End end);
  /// Which share of that interval lies before the first crossing, on straight lines between the values there,
  /// each of which counts by its weight.
  double first_share(double before_weight, double beyond_weight) const;

  /// Whether what has crossed in the last look() sets anything, switches, or stops the run.
  bool acts() const;
  /// Lets what has crossed in the last look() happen at the state's time. True where that stops the run.
  bool happen(const Channels& channels, relative::RelativeSystem& system, const State& seen, double step,
              State& state);

  /// What has crossed in other directions is on its other side from now on.
  void pass();

  const std::vector<EventRecord>& records() const { return records_; }
  void transfer(StateTransfer& transfer);

 private:
  struct Event {
    const spec::Event* spec;
    Seen when;
    std::vector<Seen> values;  ///< of what it sets
    int side = 0;              ///< −1, 0, 1
  };
  /// A hysteresis, whose value is how far it is beyond the threshold that would switch it.
  struct Relay {
    const SignalsData::Block* block;
    bool high = false;
    double value = 0, before = 0, beyond = 0;
  };
  bool crossed(std::size_t event, double value) const;

  const Compiled& model_;
  RangeWatch& ranges_;
  Channels::Needs needs_ = Channels::Needs::forces;
  std::vector<Event> events_;
  std::vector<Relay> relays_;
  std::vector<double> values_, before_, beyond_, set_to_;
  std::vector<EventRecord> records_;
};

}  // namespace mimbre
