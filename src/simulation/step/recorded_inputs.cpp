#include "mimbre/recorded_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mimbre/diagnostics.h"

namespace mimbre {

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
  // Times are sums of steps: a point that is at the time but for rounding is at it.
  const double rounding = 1e-9 * (1 + std::abs(time));
  if (t[track.at] > time + rounding) track.at = 0;  // a simulation that was put back
  while (track.at + 1 < t.size() && t[track.at + 1] <= time + rounding) ++track.at;
  const std::size_t k = track.at;
  if (!track.linear || time <= t[k] || k + 1 == t.size()) return track.values[k];
  return track.values[k] + (track.values[k + 1] - track.values[k]) * (time - t[k]) / (t[k + 1] - t[k]);
}

void RecordedInputs::set(Simulation& simulation) {
  for (Track& track : tracks_)
    simulation.set_input(track.input,
                         value(track, simulation.time() + (track.linear ? simulation.step_size() : 0)));
}

}  // namespace mimbre
