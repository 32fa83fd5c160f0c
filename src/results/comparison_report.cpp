#include <map>
#include <set>

#include "mimbre/diagnostics.h"
#include "results/common_instants.h"
#include "results/report_json.h"
#include "results/report_page.h"
#include "results/run_labels.h"

namespace mimbre {
namespace {

using Eigen::Index;
using results::Json;

/// A channel that at least two runs have, and its column in each run; -1 where it has none.
struct Shared {
  ChannelInfo channel;
  std::vector<Index> columns;
};

/// Same name and same unit: metres are not laid over radians.
using Key = std::pair<std::string, std::string>;

Key key(const ChannelInfo& channel) { return {channel.name, channel.unit}; }

/// In the order of the first run, then of what the others have besides.
std::vector<Shared> shared_channels(const std::vector<ComparedRun>& runs) {
  std::vector<std::map<Key, Index>> columns(runs.size());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    Index column = 0;
    for (const ChannelInfo& channel : runs[r].results.header.channels)
      columns[r].emplace(key(channel), column++);
  }
  std::set<Key> seen;
  std::vector<Shared> shared;
  for (const ComparedRun& run : runs)
    for (const ChannelInfo& channel : run.results.header.channels) {
      if (!seen.insert(key(channel)).second) continue;
      Shared candidate{channel, {}};
      int have = 0;
      for (const auto& of_run : columns) {
        const auto found = of_run.find(key(channel));
        candidate.columns.push_back(found == of_run.end() ? -1 : found->second);
        have += found != of_run.end();
      }
      if (have > 1) shared.push_back(std::move(candidate));
    }
  return shared;
}

Eigen::VectorXd difference(const Results& first, Index of_first, const Results& run, Index of_run,
                           const results::CommonInstants& instants) {
  Eigen::VectorXd values(static_cast<Index>(instants.time.size()));
  for (std::size_t k = 0; k < instants.time.size(); ++k)
    values(static_cast<Index>(k)) = results::interpolate(run, of_run, instants.in_b[k]).value -
                                    results::interpolate(first, of_first, instants.in_a[k]).value;
  return values;
}

/// The curves of run `r` and what it differs from the first by; each channel gets the run's entry.
Json run_json(const std::vector<ComparedRun>& runs, std::size_t r, const std::vector<Shared>& shared,
              const ReportOptions& options, std::vector<Json>& curves, std::vector<Json>& deviations) {
  const Results& first = runs.front().results;
  const Results& run = runs[r].results;
  const results::Samples samples = results::sampling(run.time.size(), options.max_samples);
  results::CommonInstants instants;
  if (r > 0 && first.time.size() > 0 && run.time.size() > 0) instants = results::common_instants(first, run);
  const results::Samples common =
      results::sampling(static_cast<Index>(instants.time.size()), options.max_samples);
  std::vector<float> values, differences;
  for (std::size_t k = 0; k < shared.size(); ++k) {
    const Index own = shared[k].columns[r], of_first = shared[k].columns.front();
    if (own < 0) continue;
    const double offset = results::typical(run.channels.col(own));
    results::append_samples(run.channels.col(own), offset, samples, values);
    curves[k].push_back({{"run", r}, {"offset", offset}});
    if (of_first < 0 || instants.time.empty()) continue;
    const Eigen::VectorXd apart = difference(first, of_first, run, own, instants);
    const double level = results::typical(apart);
    results::append_samples(apart, level, common, differences);
    const ChannelDifference numbers = results::channel_difference(first, of_first, run, own, instants);
    deviations[k].push_back({{"run", r},
                             {"offset", level},
                             {"mean", numbers.mean_difference},
                             {"largest", numbers.max_difference},
                             {"at", numbers.at_time},
                             {"amplitude", numbers.amplitude}});
  }
  const Eigen::Map<const Eigen::VectorXd> common_time(instants.time.data(),
                                                      static_cast<Index>(instants.time.size()));
  return {{"file", runs[r].file},
          {"title", run.header.title},
          {"step", run.header.step},
          {"instants", run.time.size()},
          {"model", run.header.model_text},
          {"options", results::parsed(run.header.options_json)},
          {"summary", results::parsed(run.summary_json)},
          {"time", results::array_of(results::sample_times(run.time, samples))},
          {"values", results::array_of(values)},
          {"commonTime", results::array_of(results::sample_times(common_time, common))},
          {"differences", results::array_of(differences)}};
}

Json data_json(const std::vector<ComparedRun>& runs, const ReportOptions& options) {
  const std::vector<Shared> shared = shared_channels(runs);
  if (shared.empty()) throw InputError(Mark{}, "no two of the runs have a channel in common");
  const std::vector<std::string> labels = results::run_labels(runs);
  std::vector<Json> curves(shared.size(), Json::array()), deviations(shared.size(), Json::array());
  Json run_list = Json::array(), channels = Json::array();
  for (std::size_t r = 0; r < runs.size(); ++r) {
    Json run{{"label", labels[r]}};
    run.update(run_json(runs, r, shared, options, curves, deviations));
    run_list.push_back(std::move(run));
  }
  std::vector<ChannelInfo> infos;
  for (std::size_t k = 0; k < shared.size(); ++k) {
    const ChannelInfo& channel = shared[k].channel;
    infos.push_back(channel);
    channels.push_back({{"name", channel.name},
                        {"unit", channel.unit},
                        {"meaning", channel.meaning},
                        {"curves", curves[k]},
                        {"deviations", deviations[k]}});
  }
  Json data{{"format", "mimbre-comparison-1"},
            {"runs", run_list},
            {"channels", channels},
            {"shown", results::shown_channels(infos, options)}};
  const Json first = results::scene_json(runs.front().results, options.max_frames);
  data.update(first);
  data["ghosts"] = Json::array();
  for (std::size_t r = 1; r < runs.size(); ++r) {
    Json scene = results::scene_json(runs[r].results, options.max_frames);
    for (const char* part : {"bodies", "frames", "elements"})
      if (scene[part] == first[part]) scene.erase(part);
    scene.erase("roads");
    data["ghosts"].push_back(std::move(scene));
  }
  return data;
}

}  // namespace

std::string comparison_html(const std::vector<ComparedRun>& runs, const ReportOptions& options) {
  if (runs.size() < 2) throw InputError(Mark{}, "a comparison needs at least two runs");
  std::vector<ComparedRun> continuous = runs;
  for (ComparedRun& run : continuous) {
    results::check_sizes(run.results);
    run.results.channels = results::continuous_channels(run.results);
  }
  return results::page_with(data_json(continuous, options));
}

void write_comparison(const std::vector<ComparedRun>& runs, const std::string& path,
                      const ReportOptions& options) {
  results::write_page(comparison_html(runs, options), path);
}

}  // namespace mimbre
