#include "app/recorded_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "app/common.h"
#include "mimbre/diagnostics.h"

namespace mimbre::app {
namespace {

constexpr std::uintmax_t largest_file = 1u << 30;

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// The number that a cell is, and nothing else.
std::optional<double> number(const std::string& cell) {
  const std::string text = trimmed(cell);
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

}  // namespace

RecordedInputs::RecordedInputs(const std::vector<std::string>& given) {
  for (const std::string& text : given) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
      throw UsageError(fmt::format("--input {}: NAME=FILE.csv is needed", text));
    Track track;
    track.name = text.substr(0, equals);
    const std::string path = text.substr(equals + 1);
    for (const Track& other : tracks_)
      if (other.name == track.name) throw UsageError(fmt::format("--input {}: is given twice", track.name));
    std::error_code failed;
    if (!std::filesystem::is_regular_file(path, failed))
      throw InputError({path, 0, 0}, "there is no such file with the input's values");
    if (std::filesystem::file_size(path, failed) > largest_file)
      throw InputError({path, 0, 0}, "is larger than 1 GiB; an input's table has a line per change");
    std::ifstream file(path);
    std::string line;
    for (int row = 1; std::getline(file, line); ++row) {
      if (row == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
      if (trimmed(line).empty() || trimmed(line)[0] == '#') continue;
      const auto separator = line.find_first_of(",;\t");
      const auto time = number(line.substr(0, separator));
      const auto value = separator == std::string::npos ? std::nullopt : number(line.substr(separator + 1));
      if (!time || !value) {
        if (track.times.empty() && row <= 2) continue;  // names, units
        throw InputError({path, row, 1}, fmt::format("'{}' is not a time and a value, for example 0.5, 12",
                                                     trimmed(line).substr(0, 60)));
      }
      if (!track.times.empty() && *time <= track.times.back())
        throw InputError({path, row, 1}, fmt::format("the times do not ascend: {} comes after {}", *time,
                                                     track.times.back()));
      track.times.push_back(*time);
      track.values.push_back(*value);
    }
    if (track.times.empty()) throw InputError({path, 0, 0}, "has no line with a time and a value");
    files_.push_back(path);
    tracks_.push_back(std::move(track));
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
      throw bad(fmt::format("the times do not ascend: {} comes after {}", times[k], times[k - 1]));
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
                  "Plays an input, or a tunable parameter, from a table with the columns t and value; may be "
                  "given several times")
      .type_name("NAME=FILE.csv");
}

}  // namespace mimbre::app
