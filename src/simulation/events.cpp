#include "simulation/events.h"

#include <algorithm>
#include <cmath>

#include "model/compile_signals.h"

namespace mimbre {
namespace {

int side_of(double value) { return (value > 0) - (value < 0); }

}  // namespace

Events::Events(const Compiled& m) : model_(m) {
  const auto needs = [&](const SignalsData::Seen& seen) {
    for (const SignalsData::Seen::Argument& a : seen.arguments)
      if (a.sensor >= 0)
        needs_ =
            std::max(needs_, Channels::needs_of(m.spec().sensors[static_cast<std::size_t>(a.sensor)].kind));
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
  for (auto* values : {&values_, &before_, &beyond_}) values->resize(events_.size());
  set_to_.resize(most);
}

void Events::start(const Channels& channels, relative::RelativeSystem& system, const State& seen) {
  for (Event& event : events_) event.side = side_of(event.when.value(channels, system, seen));
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
  return any;
}

double Events::first_share(double before_weight, double beyond_weight) const {
  double first = 1;
  for (std::size_t k = 0; k < events_.size(); ++k) {
    if (!crossed(k, beyond_[k])) continue;
    const double from = before_weight * before_[k], to = beyond_weight * beyond_[k];
    first = std::min(first, from / (from - to));
  }
  return std::isfinite(first) ? std::clamp(first, 0.0, 1.0) : 0.5;
}

bool Events::acts() const {
  for (std::size_t k = 0; k < events_.size(); ++k)
    if (crossed(k, values_[k]) && (events_[k].spec->stop || !events_[k].values.empty())) return true;
  return false;
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
