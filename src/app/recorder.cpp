#include "app/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "mimbre/diagnostics.h"

namespace mimbre::app {
namespace {

namespace fs = std::filesystem;

std::string absolute(const std::string& path) {
  std::error_code error;
  const fs::path found = fs::absolute(path, error);
  return error ? path : found.lexically_normal().string();
}

/// Where the rows of a saved run may be: in the file that grew then, in the one that it became where the run
/// came to its end afterwards, and in the target of the run that resumes it.
std::vector<std::string> places(const std::string& grown, const std::string& target) {
  std::vector<std::string> all{grown};
  for (const std::string& path : {file_when_whole(grown), absolute(target)})
    if (!path.empty() && std::find(all.begin(), all.end(), path) == all.end()) all.push_back(path);
  return all;
}

[[noreturn]] void refuse(const RunState& saved, const std::vector<std::string>& sought) {
  // A file that grew beside an older one has another name since the run came to its end.
  const std::size_t named = file_when_whole(sought.front()).empty() ? 0 : 1;
  std::string others;
  for (std::size_t k = 0; k < sought.size(); ++k)
    if (k != named) others += fmt::format("{}'{}'", others.empty() ? "" : " nor in ", sought[k]);
  throw InputError(
      Mark{sought[named], 0, 0},
      fmt::format("the {} rows that the saved run had recorded until t = {:.6g} s are {}; put that "
                  "file back, or run from the start",
                  saved.rows.count, saved.snapshot.time,
                  others.empty() ? "no longer here" : "neither here nor in " + others));
}

std::vector<ResultsRow> rows_of_results(const std::string& path, std::int64_t count) {
  const Results old = read_results(path);
  std::vector<ResultsRow> rows;
  for (Eigen::Index k = 0; k < std::min<Eigen::Index>(count, old.time.size()); ++k)
    rows.push_back({old.time[k], old.channels.row(k).transpose(), old.poses[static_cast<std::size_t>(k)],
                    old.modes.row(k).transpose()});
  return rows;
}

/// Numbers in a table have as many digits as distinguish them, so that they come back as they were.
std::vector<ResultsRow> rows_of_csv(const std::string& path, std::int64_t count, int headings, int outputs) {
  std::ifstream file(path);
  std::string line;
  for (; headings > 0; --headings) std::getline(file, line);
  std::vector<ResultsRow> rows;
  while (std::ssize(rows) < count && std::getline(file, line)) {
    ResultsRow row;
    row.channels.resize(outputs);
    char* at = line.data();
    row.time = std::strtod(at, &at);
    for (double& value : row.channels) {
      if (*at == ',') ++at;
      value = std::strtod(at, &at);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::vector<ResultsRow> recorded_rows(const RunState& saved, const RunFiles& files, int outputs) {
  const bool results = !files.results.empty();
  const std::string &grown = results ? saved.results : saved.csv,
                    &target = results ? files.results : files.csv;
  const std::vector<std::string> sought = places(grown, target);
  for (const std::string& path : sought) {
    std::error_code error;
    if (!fs::exists(path, error)) continue;
    std::vector<ResultsRow> rows =
        results ? rows_of_results(path, saved.rows.count)
                : rows_of_csv(path, saved.rows.count, files.csv_units ? 2 : 1, outputs);
    RecordedRows found;
    for (const ResultsRow& row : rows) found.add(row);
    if (found == saved.rows) return rows;
  }
  refuse(saved, sought);
}

Recorder::Recorder(const RunFiles& files, const Simulation& simulation, const std::string& options_json)
    : files_(files), outputs_count_(simulation.output_count()) {
  if (!files.results.empty())
    results_ = std::make_unique<ResultsWriter>(files.results, simulation.header(options_json));
  if (files.csv.empty()) return;
  std::vector<std::string> columns, units;
  for (int k = 0; k < outputs_count_; ++k) {
    columns.push_back(simulation.channels()[k].name);
    if (files.csv_units) units.push_back(simulation.channels()[k].unit);
  }
  csv_ = std::make_unique<CsvWriter>(files.csv, columns, units);
}

void Recorder::record(Simulation& simulation) {
  if (!recording()) return;
  simulation.sample(row_);
  add(row_);
}

void Recorder::add(const ResultsRow& row) {
  if (results_) {
    results_->add(row);
    rows_.add(row);
  }
  outputs_ = row.channels.head(outputs_count_);
  if (!csv_) return;
  csv_->add(row.time, outputs_);
  if (!results_) rows_.add({row.time, outputs_, {}, {}});
}

void Recorder::take_over(const RunState& saved, const std::vector<ResultsRow>& rows) {
  for (const ResultsRow& row : rows) add(row);
  taken_over_ = {saved.results, saved.csv};
}

void Recorder::flush_if_due() {
  if (results_) results_->flush_if_due();
  if (csv_) csv_->flush_if_due();
}

void Recorder::describe(RunState& state) {
  state.rows = rows_;
  if (results_) {
    results_->flush();
    state.results = absolute(results_->path());
  }
  if (csv_) {
    csv_->flush();
    state.csv = absolute(csv_->path());
  }
}

void Recorder::remove_what_was_taken_over() {
  for (const std::string& path : taken_over_) {
    std::error_code ignored;
    // Only what a killed run left beside an older file; results with the name they were given stay.
    if (fs::path(path).filename().string().find(".part-") != std::string::npos) fs::remove(path, ignored);
  }
  taken_over_.clear();
}

std::vector<std::string> Recorder::finish(const std::string& summary, bool whole) {
  std::vector<std::string> kept;
  std::exception_ptr first;
  const auto keep_first = [&](auto&& work) {
    try {
      work();
    } catch (const std::exception&) {
      if (!first) first = std::current_exception();
    }
  };
  const auto close = [&](auto& writer, const auto&... text) {
    if (whole) return writer.finish(text...);
    const std::string path = writer.keep(text...);
    kept.push_back(fmt::format("{} {} in '{}'", writer.rows(), writer.rows() == 1 ? "row" : "rows", path));
  };
  if (results_) keep_first([&] { close(*results_, summary); });
  if (csv_) keep_first([&] { close(*csv_); });
  if (first) std::rethrow_exception(first);
  if (whole) remove_what_was_taken_over();
  return kept;
}

}  // namespace mimbre::app
