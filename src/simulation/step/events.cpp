#include "simulation/step/events.h"

#include <algorithm>
#include <cmath>

#include "compile/signals/compile_signals.h"
#include "signals/blocks/table.h"

namespace mimbre {
namespace {

int side_of(double value) { return (value > 0) - (value < 0); }

bool is_relay(const SignalsData::Block& b) { return block_info(b.type).relay && !(b.every > 0); }

}  // namespace

Events::Events(const Compiled& m, RangeWatch& ranges) : model_(m), ranges_(ranges) {
  const auto needs = [&](const SignalsData::Seen& seen) {
    for (const SignalsData::Seen::Argument& a : seen.arguments)
      if (a.sensor >= 0)
        needs_ = std::max(needs_, output_info(m.spec().sensors[static_cast<std::size_t>(a.sensor)]).needs);
  };
  std::size_t most = 0;
  for (const spec::Event& spec : m.spec().events) {
    const auto seen = [&](const spec::Law& law) {
      SignalsData::Seen data = seen_of(m, law);
      needs(data);
      return Seen(m, std::move(data));
    };
    Event event{&spec, seen(spec.when), {}};
    for (const spec::Event::Set& set : spec.sets) event.values.push_back(seen(set.value));
    most = std::max(most, event.values.size());
    events_.push_back(std::move(event));
    EventRecord record;
    record.name = spec.name;
    record.stops = spec.stop;
    records_.push_back(std::move(record));
  }
  for (const SignalsData::Block& b : m.signals.blocks)
    if (is_relay(b)) relays_.push_back({&b});
  for (auto* values : {&values_, &before_, &beyond_}) values->resize(events_.size());
  set_to_.resize(most);
}

void Events::start(const Channels& channels, relative::RelativeSystem& system, const State& seen) {
  for (Event& event : events_) event.side = side_of(event.when.value(channels, system, seen));
}

void Events::see_relays(const relative::RelativeSystem& system) {
  const SignalValues<double>& s = system.workspace().signals;
  for (Relay& relay : relays_) {
    const BlockInputs<double> in = block_inputs(*relay.block, s);
    BlockCall<double> call = block_call(model_.signals, *relay.block, s);
    call.in = in.data();
    relay.high = (call.begun ? call.before[0] : blocks::hysteresis::decided(call)) > 0.5;
  }
}

void Events::keep(End end) {
  (end == End::before ? before_ : beyond_) = values_;
  for (Relay& relay : relays_) (end == End::before ? relay.before : relay.beyond) = relay.value;
}

bool Events::crossed(std::size_t k, double value) const {
  using Direction = spec::Event::Direction;
  const int now = side_of(value), side = events_[k].side;
  if (now == 0 || side == 0 || now == side) return false;
  return events_[k].spec->direction == Direction::either ||
         (events_[k].spec->direction == Direction::rising) == (now > 0);
}

bool Events::look(const Channels& channels, relative::RelativeSystem& system, const State& seen) {
  bool any = false;
  for (std::size_t k = 0; k < events_.size(); ++k) {
    values_[k] = events_[k].when.value(channels, system, seen);
    any = any || crossed(k, values_[k]);
  }
  namespace relay_numbers = blocks::hysteresis;
  for (Relay& relay : relays_) {
    const double* numbers = model_.signals.numbers.data() + relay.block->numbers;
    const double in = block_inputs(*relay.block, system.workspace().signals)[0];
    relay.value = relay.high ? numbers[relay_numbers::falls_at] - in : in - numbers[relay_numbers::rises_at];
    any = any || relay.value > 0;
  }
  return any;
}

double Events::first_share(double before_weight, double beyond_weight) const {
  double first = 1;
  const auto cross = [&](double before, double beyond) {
    const double from = before_weight * before, to = beyond_weight * beyond;
    first = std::min(first, from / (from - to));
  };
  for (std::size_t k = 0; k < events_.size(); ++k)
    if (crossed(k, beyond_[k])) cross(before_[k], beyond_[k]);
  for (const Relay& relay : relays_)
    if (relay.beyond > 0) cross(relay.before, relay.beyond);
  return std::isfinite(first) ? std::clamp(first, 0.0, 1.0) : 0.5;
}

bool Events::acts() const {
  for (std::size_t k = 0; k < events_.size(); ++k)
    if (crossed(k, values_[k]) && (events_[k].spec->stop || !events_[k].values.empty())) return true;
  return std::any_of(relays_.begin(), relays_.end(), [](const Relay& relay) { return relay.value > 0; });
}

void Events::pass() {
  for (std::size_t k = 0; k < events_.size(); ++k)
    if (const int now = side_of(values_[k]); now != 0) events_[k].side = now;
}

bool Events::happen(const Channels& channels, relative::RelativeSystem& system, const State& seen,
                    double step, State& state) {
  bool stops = false;
  for (std::size_t k = 0; k < events_.size(); ++k) {
    Event& event = events_[k];
    const bool happens = crossed(k, values_[k]);
    if (const int now = side_of(values_[k]); now != 0) event.side = now;
    if (!happens) continue;
    EventRecord& record = records_[k];
    if (record.count == 0) record.first = state.time;
    record.last = state.time;
    ++record.count;
    stops = stops || event.spec->stop;
    // What one sets does not change what it sets others to.
    for (std::size_t j = 0; j < event.values.size(); ++j)
      set_to_[j] = event.values[j].value(channels, system, seen);
    for (std::size_t j = 0; j < event.values.size(); ++j)
      if (std::isfinite(set_to_[j])) {
        ranges_.set(event.spec->sets[j].input, set_to_[j], state.time);
        set_held_input(model_, event.spec->sets[j].input, set_to_[j], step, state);
        state.started = false;
      }
  }
  return stops;
}

void Events::transfer(StateTransfer& transfer) {
  for (std::size_t k = 0; k < events_.size(); ++k)
    transfer(events_[k].side, records_[k].count, records_[k].first, records_[k].last);
}

}  // namespace mimbre
