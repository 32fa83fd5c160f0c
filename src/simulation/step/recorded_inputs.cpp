#include "mimbre/recorded_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/hash64.h"
#include "mimbre/diagnostics.h"

namespace mimbre {

namespace {

/// Times are sums of steps: a point that is at the time but for rounding is at it.
bool reached(double point, double time) { return point <= time + 1e-9 * (1 + std::abs(time)); }

}  // namespace

void RecordedInputs::add(const std::string& name, std::vector<double> times, std::vector<double> values) {
  const auto bad = [&](const std::string& what) {
    return InputError(Mark{}, fmt::format("input '{}': {}", name, what));
  };
  if (times.empty() || times.size() != values.size())
    throw bad(fmt::format("{} times and {} values; each time needs a value", times.size(), values.size()));
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!std::isfinite(times[k]) || !std::isfinite(values[k]))
      throw bad(fmt::format("entry {}: ({}, {}) is no finite number", k, times[k], values[k]));
    if (k > 0 && times[k] <= times[k - 1])
      throw bad(fmt::format("the times do not increase: {} comes after {}", times[k], times[k - 1]));
  }
  tracks_.push_back({name, std::move(times), std::move(values)});
}

bool RecordedInputs::contains(const std::string& name) const {
  return std::any_of(tracks_.begin(), tracks_.end(), [&](const Track& track) { return track.name == name; });
}

std::map<std::string, std::uint64_t> RecordedInputs::fingerprints() const {
  std::map<std::string, std::uint64_t> result;
  for (const Track& track : tracks_) {
    Hash64 hash;
    for (std::size_t k = 0; k < track.times.size(); ++k) {
      hash.add(track.times[k]);
      hash.add(track.values[k]);
    }
    result[track.name] = hash.value();
  }
  return result;
}

std::map<std::string, double> RecordedInputs::start() {
  std::map<std::string, double> values;
  for (Track& track : tracks_) values[track.name] = value(track, 0);
  return values;
}

void RecordedInputs::attach(const Simulation& simulation) {
  for (Track& track : tracks_) {
    track.input = simulation.input(track.name);
    track.linear =
        simulation.inputs()[static_cast<std::size_t>(track.input)].hold == spec::Input::Hold::linear;
  }
}

double RecordedInputs::value(Track& track, double time) {
  const auto& t = track.times;
  if (!reached(t[track.at], time)) track.at = 0;  // a simulation that was put back
  while (track.at + 1 < t.size() && reached(t[track.at + 1], time)) ++track.at;
  const std::size_t k = track.at;
  if (!track.linear || time <= t[k] || k + 1 == t.size()) return track.values[k];
  return track.values[k] + (track.values[k + 1] - track.values[k]) * (time - t[k]) / (t[k + 1] - t[k]);
}

/// When the step before this one began. A simulation that was put elsewhere had one of full length.
double RecordedInputs::last_step(const Simulation& simulation) const {
  const double now = simulation.time(), since = now - last_;
  return since > 0 && since < 1.5 * simulation.step_size() ? last_ : now - simulation.step_size();
}

void RecordedInputs::set(Simulation& simulation) {
  const double now = simulation.time(), end = now + simulation.step_size();
  const double before = std::max(last_step(simulation), 0.0);  // a simulation starts with what is due at 0
  for (Track& track : tracks_) {
    const double of = value(track, track.linear ? end : now), point = track.times[track.at];
    const bool due = track.linear ? reached(track.times.front(), end) && !reached(track.times.back(), now)
                                  : reached(point, now) && !reached(point, before);
    if (due) simulation.set_input(track.input, of);
  }
  last_ = now;
}

}  // namespace mimbre
