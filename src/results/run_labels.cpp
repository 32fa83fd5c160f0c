#include "results/run_labels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "results/report_json.h"

namespace mimbre::results {
namespace {

/// What one run was made with, in words, by what the words are about; in the order in which people look for
/// it.
using Facts = std::vector<std::pair<std::string, std::string>>;

const std::string* found(const Facts& facts, const std::string& key) {
  for (const auto& [name, words] : facts)
    if (name == key) return &words;
  return nullptr;
}

std::string as_text(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

Facts facts_set(const Json& options) {
  Facts facts;
  if (!options.is_object() || !options.contains("set") || !options["set"].is_object()) return facts;
  for (const auto& [name, value] : options["set"].items())
    facts.emplace_back(name, fmt::format("{}={}", name, as_text(value)));
  return facts;
}

/// The method in force is in the summary; of a run that was cut short only what was asked for is known.
Facts facts_method(const Json& options, const Json& summary, double step) {
  Facts facts;
  const Json& source = summary.is_object() ? summary : options;
  for (const char* key : {"formulation", "inertia", "formalism", "integrator"})
    if (source.is_object() && source.contains(key)) facts.emplace_back(key, as_text(source[key]));
  for (const char* key : {"rho", "xi"})
    if (source.is_object() && source.contains(key))
      facts.emplace_back(key, fmt::format("{}={}", key, as_text(source[key])));
  facts.emplace_back("step", fmt::format("{:.6g} ms", 1000 * step));
  return facts;
}

/// Whether some runs differ; with `absence`, also whether one has no value.
bool differs(const std::vector<Facts>& runs, const std::string& key, bool absence) {
  const std::string* first = nullptr;
  bool missing = false;
  for (const Facts& facts : runs) {
    const std::string* const words = found(facts, key);
    if (!words)
      missing = true;
    else if (!first)
      first = words;
    else if (*words != *first)
      return true;
  }
  return absence && missing && first;
}

std::map<std::string, int> counts(const std::vector<std::string>& labels) {
  std::map<std::string, int> result;
  for (const std::string& label : labels) ++result[label];
  return result;
}

}  // namespace

std::vector<std::string> run_labels(const std::vector<ComparedRun>& runs) {
  std::vector<Facts> set, method;
  for (const ComparedRun& run : runs) {
    const Json options = parsed(run.results.header.options_json), summary = parsed(run.results.summary_json);
    set.push_back(facts_set(options));
    method.push_back(facts_method(options, summary, run.results.header.step));
  }
  std::vector<std::string> labels, stems;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    std::vector<std::string> words;
    for (const auto& [name, text] : set[k])
      if (differs(set, name, true)) words.push_back(text);
    for (const auto& [name, text] : method[k])
      if (differs(method, name, false)) words.push_back(text);
    stems.push_back(std::filesystem::path(runs[k].file).stem().string());
    labels.push_back(words.empty() ? stems.back() : fmt::format("{}", fmt::join(words, ", ")));
  }
  const auto told_apart = counts(labels);
  for (std::size_t k = 0; k < runs.size(); ++k)
    if (told_apart.at(labels[k]) > 1 && labels[k] != stems[k]) labels[k] += fmt::format(" ({})", stems[k]);
  std::map<std::string, int> taken;
  for (std::string& label : labels)
    if (const int number = ++taken[label]; number > 1) label += fmt::format(" ({})", number);
  for (std::size_t k = 0; k < runs.size(); ++k)
    if (!runs[k].label.empty()) labels[k] = runs[k].label;
  return labels;
}

}  // namespace mimbre::results
