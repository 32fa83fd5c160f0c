#include "live/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "live/road_stretch.h"
#include "live/timings_json.h"
#include "mimbre/diagnostics.h"
#include "mimbre/report.h"
#include "results/report_json.h"

namespace mimbre::live {
namespace {

using results::Json;

constexpr std::size_t most_channels = 64, longest_name = 40, most_points = 1'000'000;
constexpr int most_shown = 4;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

[[noreturn]] void wrong(const std::string& message) { throw InputError(Mark{}, message); }

/// Ten bins to a decade, from a microsecond to a second.
std::vector<double> histogram_edges() {
  std::vector<double> edges;
  for (int k = 0; k <= 60; ++k) edges.push_back(1e-6 * std::pow(10, 0.1 * k));
  return edges;
}

const char* name_of(RealTimeLoop::State state) {
  static constexpr const char* names[] = {"running", "paused", "ended", "failed"};
  return names[static_cast<std::size_t>(state)];
}

const char* name_of(Overrun policy) {
  static constexpr const char* names[] = {"catch_up", "skip_output", "slow_down", "stop"};
  return names[static_cast<std::size_t>(policy)];
}

int input_named(const std::string& name, const std::vector<spec::Input>& inputs) {
  const auto found =
      std::find_if(inputs.begin(), inputs.end(), [&](const spec::Input& i) { return i.name == name; });
  if (found == inputs.end()) wrong(fmt::format("there is no input '{}'", name.substr(0, 100)));
  return static_cast<int>(found - inputs.begin());
}

double finite(const Json& value, const std::string& of) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    wrong(fmt::format("{} is no finite number", of));
  return value.get<double>();
}

const Json& part(const Json& of, const char* key) {
  const auto found = of.find(key);
  if (found == of.end()) wrong(fmt::format("'{}' is missing", key));
  return *found;
}

bool flag(const Json& of, const char* key) {
  const Json& value = part(of, key);
  if (!value.is_boolean()) wrong(fmt::format("'{}' is neither true nor false", key));
  return value.get<bool>();
}

std::vector<int> channels_of(const Json& list, int channels) {
  if (!list.is_array() || list.size() > most_channels)
    wrong(fmt::format("'indices' must be a list of at most {} places", most_channels));
  std::vector<int> places;
  for (const Json& place : list) {
    if (!place.is_number_integer() || place < 0 || place >= channels)
      wrong(fmt::format("a channel's place is a whole number from 0 to {}", channels - 1));
    places.push_back(place.get<int>());
  }
  return places;
}

InputTracks tracks_of(const Json& given, const std::vector<spec::Input>& inputs) {
  if (!given.is_object()) wrong("'tracks' must have a table for each input's name");
  InputTracks tracks;
  for (const auto& [name, table] : given.items()) {
    InputTrack track;
    track.input = input_named(name, inputs);
    if (!table.is_object()) wrong(fmt::format("the table of '{}' must have times and values", name));
    const Json &times = part(table, "times"), &values = part(table, "values");
    if (!times.is_array() || !values.is_array() || times.size() != values.size() || times.empty() ||
        times.size() > most_points)
      wrong(fmt::format("the table of '{}' must have as many times as values, 1 to {}", name, most_points));
    for (std::size_t k = 0; k < times.size(); ++k) {
      track.times.push_back(finite(times[k], "a time of '" + name + "'"));
      track.values.push_back(finite(values[k], "a value of '" + name + "'"));
      if (k > 0 && track.times[k] < track.times[k - 1])
        wrong(fmt::format("the times of '{}' must ascend", name));
    }
    tracks.push_back(std::move(track));
  }
  return tracks;
}

Json patches_of(const spec::Road& road) {
  Json patches = Json::array();
  for (const spec::Road::Patch& patch : road.patches)
    patches.push_back({{"x", {patch.low.x(), patch.high.x()}},
                       {"y", {patch.low.y(), patch.high.y()}},
                       {"friction", patch.friction}});
  return patches;
}

}  // namespace

std::vector<int> shown_at_first(const Simulation& simulation) {
  std::vector<int> shown;
  for (int k = 0; k < std::min(simulation.output_count(), most_shown); ++k) shown.push_back(k);
  return shown;
}

std::string scene_text(Simulation& simulation, const RealTimeLoop& loop, const RealTimeRecorder* recorder) {
  Results start;
  start.header = simulation.header("");
  start.header.roads.clear();
  Json patches = Json::array();
  for (const spec::Road& road : simulation.model().spec().roads) {
    if (road.over == spec::Road::Over::distance)
      start.header.roads.push_back(road_stretch(road));
    else if (road.over == spec::Road::Over::grid && !road.patches.empty())
      start.header.roads.push_back({road.name, {}});  // it is of the ground's surface
    else
      continue;
    patches.push_back(patches_of(road));
  }
  ResultsRow row;
  simulation.sample(row);
  start.time = Eigen::VectorXd::Constant(1, row.time);
  start.channels = row.channels.transpose();
  start.poses = {row.poses};
  start.modes = row.modes.transpose();
  Json channels = Json::array(), inputs = Json::array();
  for (const ChannelInfo& channel : simulation.channels())
    channels.push_back({{"name", channel.name}, {"unit", channel.unit}, {"meaning", channel.meaning}});
  for (std::size_t k = 0; k < simulation.inputs().size(); ++k) {
    const spec::Input& input = simulation.inputs()[k];
    Json entry{{"name", input.name},
               {"unit", input.unit},
               {"start", input.start},
               {"value", simulation.input_value(static_cast<int>(k))},
               {"tunable", input.tunable}};
    if (std::isfinite(input.min)) entry["min"] = input.min;
    if (std::isfinite(input.max)) entry["max"] = input.max;
    inputs.push_back(std::move(entry));
  }
  Json scene{{"format", "mimbre-live-1"},
             {"title", start.header.title},
             {"step", loop.step()},
             {"speed", loop.options().speed},
             {"model", start.header.model_text},
             {"channels", channels},
             {"outputs", simulation.output_count()},
             {"shown", shown_at_first(simulation)},
             {"inputs", inputs},
             {"policy", name_of(loop.options().overrun)},
             {"recording", recorder && recorder->recording()}};
  if (recorder) scene["record"] = recorder->path();
  scene.update(results::scene_json(start, 1));
  for (std::size_t k = 0; k < patches.size(); ++k) scene["roads"][k]["patches"] = patches[k];
  return text_of(scene);
}

std::string status_text(const RealTimeLoop& loop, const RealTimeRecorder* recorder, std::size_t viewers,
                        bool say) {
  static const std::vector<double> edges = histogram_edges();
  const RealTimeMonitor& m = loop.monitor();
  const RealTimeGrants granted = loop.granted();
  const auto steps = m.steps.load();
  Json overruns{{"count", m.overrun_count()}};
  for (int k = 0; k < overrun_causes; ++k)
    overruns[mimbre::name_of(static_cast<OverrunCause>(k))] = m.overruns[static_cast<std::size_t>(k)].load();
  overruns["late_steps"] = m.late.load();
  overruns["skipped_outputs"] = m.skipped_outputs.load();
  overruns["lag"] = m.lag.load();
  Json status;
  if (say) status["say"] = "status";
  status.update(
      {{"time", loop.time()},
       {"steps", steps},
       {"state", name_of(loop.state())},
       {"message", loop.message()},
       {"step", loop.step()},
       {"speed", loop.options().speed},
       {"viewers", viewers},
       {"recording", recorder && recorder->recording()},
       {"clock",
        {{"scheduling", granted.scheduling}, {"memory", granted.memory}, {"cpu", granted.processor}}},
       {"computation", timings_json(m.computation)},
       {"cpu", timings_json(m.cpu)},
       {"latency", timings_json(m.latency)},
       {"overruns", overruns},
       {"histogram",
        {{"edges", edges},
         {"computation", m.computation.between(edges)},
         {"latency", m.latency.between(edges)}}},
       {"iterations",
        {{"mean", steps > 0 ? static_cast<double>(m.iterations) / static_cast<double>(steps) : 0.0},
         {"most", m.most_iterations.load()},
         {"most_parts", m.most_parts.load()}}},
       {"unconverged_steps", m.unconverged.load()},
       {"page_faults", m.page_faults.load()},
       {"preemptions", m.preemptions.load()},
       {"worst_case", loop.worst_case()}});
  if (recorder && !recorder->failure().empty()) status["record_failure"] = recorder->failure();
  if (recorder) status["lost_rows"] = recorder->lost_rows();
  return text_of(status);
}

std::string inputs_text(const std::vector<spec::Input>& inputs, const std::vector<InputHistory>& histories) {
  Json tracks = Json::object();
  for (std::size_t k = 0; k < inputs.size(); ++k)
    tracks[inputs[k].name] = {{"times", histories[k].times}, {"values", histories[k].values}};
  return text_of({{"format", "mimbre-inputs-1"}, {"tracks", tracks}});
}

Asked understood(const std::string& text, const std::vector<spec::Input>& inputs, int channels) {
  int depth = 0;
  // No message has tables in tables in tables: what is deeper is not read.
  for (const char c : text) {
    depth += (c == '{' || c == '[') - (c == '}' || c == ']');
    if (depth > 8) wrong("the message is nested too deeply");
  }
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) wrong("the message is no JSON object");
  const Json& what = part(message, "do");
  if (!what.is_string()) wrong("'do' must be a word");
  Asked asked;
  asked.what = what.get<std::string>();
  const auto is = [&](const char* name) { return asked.what == name; };
  if (is("channels")) {
    asked.channels = channels_of(part(message, "indices"), channels);
  } else if (is("control")) {
    asked.on = flag(message, "take");
  } else if (is("record")) {
    asked.on = flag(message, "on");
  } else if (is("inputs")) {
    const Json& values = part(message, "values");
    if (!values.is_object()) wrong("'values' must have a number for each input's name");
    for (const auto& [name, value] : values.items())
      asked.values.emplace_back(input_named(name, inputs), finite(value, "the value of '" + name + "'"));
  } else if (is("snapshot") || is("restore")) {
    const Json& name = part(message, "name");
    if (!name.is_string() || name.get<std::string>().empty() || name.get<std::string>().size() > longest_name)
      wrong(fmt::format("'name' must have 1 to {} characters", longest_name));
    asked.name = name.get<std::string>();
  } else if (is("play")) {
    if (message.contains("tracks")) asked.tracks = tracks_of(message["tracks"], inputs);
  } else if (!is("pause") && !is("resume") && !is("step") && !is("reset")) {
    wrong(fmt::format("there is no action '{}'", asked.what.substr(0, 100)));
  }
  return asked;
}

std::string hello_text(int viewer, bool control, const std::vector<int>& channels) {
  return text_of({{"say", "hello"}, {"viewer", viewer}, {"control", control}, {"channels", channels}});
}
std::string control_text(bool yours, bool taken) {
  return text_of({{"say", "control"}, {"yours", yours}, {"taken", taken}});
}
std::string asked_text(int viewer) { return text_of({{"say", "asked"}, {"viewer", viewer}}); }
std::string channels_text(const std::vector<int>& channels, std::uint32_t choice) {
  return text_of({{"say", "channels"}, {"indices", channels}, {"choice", choice}});
}
std::string snapshots_text(const std::vector<std::string>& names) {
  return text_of({{"say", "snapshots"}, {"names", names}});
}
std::string recording_text(bool on, const std::string& file) {
  return text_of({{"say", "recording"}, {"on", on}, {"file", file}});
}
std::string played_text(bool on) { return text_of({{"say", "played"}, {"on", on}}); }
std::string error_text(const std::string& message) {
  return text_of({{"say", "error"}, {"message", message}});
}

}  // namespace mimbre::live
