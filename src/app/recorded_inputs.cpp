#include "app/recorded_inputs.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "app/common.h"
#include "mimbre/diagnostics.h"
#include "mimbre/input_table.h"

namespace mimbre::app {

RecordedInputs::RecordedInputs(const std::vector<std::string>& given,
                               const std::vector<spec::Input>& inputs) {
  for (const std::string& text : given) {
    const auto equals = text.find('=');
    const bool named = equals != std::string::npos && text.find('/') >= equals;  // which no name has
    const std::string name = named ? text.substr(0, equals) : "";
    const std::string path = named ? text.substr(equals + 1) : text;
    if (path.empty() || (named && name.empty()))
      throw UsageError(fmt::format("--input {}: NAME=FILE.csv or FILE.csv is needed", text));
    std::error_code failed;
    if (!std::filesystem::exists(path, failed))
      throw InputError({path, 0, 0}, fmt::format("there is no such file with {} values",
                                                 named ? "the input's" : "inputs'"));
    for (RecordedInput& input : read_input_table(path, inputs, name)) {
      Track track{inputs[static_cast<std::size_t>(input.input)].name, std::move(input.times),
                  std::move(input.values)};
      for (const Track& other : tracks_)
        if (other.name == track.name) throw UsageError(fmt::format("--input {}: is given twice", track.name));
      tracks_.push_back(std::move(track));
    }
    files_.push_back(path);
  }
}

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

void add_input_option(Parser& command, std::vector<std::string>& inputs) {
  command
      .add_option("--input", inputs,
                  "Plays an input, or a tunable parameter, from a table with the columns t and value,\n"
                  "or without NAME all inputs that the table's header names; may be repeated")
      .type_name("[NAME=]FILE.csv");
}

}  // namespace mimbre::app
