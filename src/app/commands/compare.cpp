#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/common.h"
#include "app/json.h"
#include "app/terminal/table.h"
#include "mimbre/results.h"

/// mimbre compare: differences between two results files.
namespace mimbre::app {
namespace {

struct CompareArguments {
  std::vector<std::string> files;
  bool json = false, strict = false;
};

/// Of the channel's largest value; a channel that is zero throughout has no scale.
double relative(const ChannelDifference& d) {
  if (d.max_difference == 0) return 0;
  return d.max_difference / d.amplitude;
}

std::vector<std::string> missing(const Results& from, const Results& in) {
  std::set<std::string> known;
  for (const ChannelInfo& channel : in.header.channels) known.insert(channel.name);
  std::vector<std::string> names;
  for (const ChannelInfo& channel : from.header.channels)
    if (!known.contains(channel.name)) names.push_back(channel.name);
  return names;
}

/// Channels that both have in different units, with these.
std::vector<std::string> in_other_units(const Results& a, const Results& b) {
  std::map<std::string, std::string> units;
  for (const ChannelInfo& channel : b.header.channels) units.emplace(channel.name, channel.unit);
  std::vector<std::string> names;
  for (const ChannelInfo& channel : a.header.channels)
    if (const auto in_b = units.find(channel.name); in_b != units.end() && in_b->second != channel.unit)
      names.push_back(fmt::format("'{}' ({} and {})", channel.name, channel.unit, in_b->second));
  return names;
}

/// The time of some results, s.
struct Span {
  double from, until;
};
Span span_of(const Results& results) { return {results.time[0], results.time[results.time.size() - 1]}; }

/// That the run of a file did not come to its end, or nothing.
std::string early_end(const std::string& file, const Results& results) {
  const auto ends = [&](const char* how) {
    return fmt::format("the run of '{}' {}: its results end at t = {:.6g} s", file, how,
                       span_of(results).until);
  };
  if (results.summary_json.empty()) return ends("was cut short");
  const Json summary = Json::parse(results.summary_json, nullptr, false);
  if (!summary.is_object() || !summary.contains("status")) return "";
  if (summary["status"] == "interrupted") return ends("was interrupted");
  return summary["status"] == "failed" ? ends("failed") : "";
}

/// That a file has more than what is compared, or nothing.
std::string left_out(const std::string& file, const Span& whole, const Span& common) {
  const double rounding = 1e-9 * std::max(std::abs(whole.from), std::abs(whole.until));
  if (whole.from >= common.from - rounding && whole.until <= common.until + rounding) return "";
  return fmt::format(
      "only t = {:.6g} to {:.6g} s is compared, which both have; '{}' goes from {:.6g} to {:.6g} s",
      common.from, common.until, file, whole.from, whole.until);
}

int run_compare(const CompareArguments& arguments) {
  if (arguments.files.size() != 2)
    throw UsageError(fmt::format(
        "two results files are needed, the reference and the one to compare with it; {}",
        arguments.files.size() == 1 ? fmt::format("'{}' is the only one given", arguments.files.front())
                                    : "'mimbre report' makes a page that compares any number"));
  const std::string &first = arguments.files[0], &second = arguments.files[1];
  const Results a = read_results(first), b = read_results(second);
  const std::vector<ChannelDifference> differences = compare(a, b);
  const std::vector<std::string> other_units = in_other_units(a, b);
  const std::string not_compared = fmt::format("{}", fmt::join(other_units, ", "));
  if (differences.empty())
    throw InputError(
        Mark{},
        fmt::format(
            "'{}' and '{}' have no channel in common{}", first, second,
            other_units.empty() ? "" : fmt::format(" that has the same unit in both: {}", not_compared)));
  const Span in_a = span_of(a), in_b = span_of(b);
  const Span common{std::max(in_a.from, in_b.from), std::min(in_a.until, in_b.until)};
  std::vector<std::string> warnings;
  for (const std::string& warning : {early_end(first, a), early_end(second, b), left_out(first, in_a, common),
                                     left_out(second, in_b, common)})
    if (!warning.empty()) warnings.push_back(warning);
  if (!other_units.empty())
    warnings.push_back(
        fmt::format("not compared, as their units in '{}' and '{}' differ: {}", first, second, not_compared));
  const std::vector<std::string> only_in_a = missing(a, b), only_in_b = missing(b, a);
  const int code = done_with(!warnings.empty() || !only_in_a.empty() || !only_in_b.empty(), arguments.strict);
  std::map<std::string, std::string> units;
  for (const ChannelInfo& channel : a.header.channels) units[channel.name] = channel.unit;

  if (arguments.json) {
    Json json = answer("compare");
    json["from"] = common.from;
    json["until"] = common.until;
    for (const ChannelDifference& d : differences)
      json["channels"][d.name] = {{"unit", units[d.name]},
                                  {"max_difference", d.max_difference},
                                  {"mean_difference", d.mean_difference},
                                  {"at_time", d.at_time},
                                  {"amplitude", d.amplitude},
                                  {"interpolation_error", d.interpolation_error},
                                  {"relative", relative(d)}};
    json["only_in_first"] = only_in_a;
    json["only_in_second"] = only_in_b;
    json["warnings"] = warnings;
    print_data(to_text(json) + '\n');
    return code;
  }
  const bool interpolated = std::any_of(differences.begin(), differences.end(),
                                        [](const ChannelDifference& d) { return d.interpolation_error > 0; });
  std::vector<std::string> columns{
      "channel", "unit", "largest difference", "at t, s", "mean difference", "largest / amplitude"};
  if (interpolated) columns.push_back("interpolation error");
  Table table(columns);
  for (const ChannelDifference& d : differences) {
    std::vector<std::string> row{d.name,
                                 units[d.name],
                                 fmt::format("{:.4g}", d.max_difference),
                                 fmt::format("{:.6g}", d.at_time),
                                 fmt::format("{:.4g}", d.mean_difference),
                                 fmt::format("{:.3g}", relative(d))};
    if (interpolated) row.push_back(fmt::format("{:.2g}", d.interpolation_error));
    table.add(row);
  }
  print_data(table.text());
  if (interpolated)
    fmt::print(stderr,
               "mimbre: note: some instants are not in both files: values between instants are interpolated, "
               "and may be off by about as much as the last column has\n");
  for (const std::string& warning : warnings) print_warning(warning);
  if (!only_in_a.empty()) print_warning(fmt::format("only in '{}': {}", first, fmt::join(only_in_a, ", ")));
  if (!only_in_b.empty()) print_warning(fmt::format("only in '{}': {}", second, fmt::join(only_in_b, ", ")));
  return code;
}

}  // namespace

Command add_compare(CommandLine& program) {
  Parser parser = program.add_command("compare", "Print the differences of two results, channel by channel");
  const auto arguments = std::make_shared<CompareArguments>();
  parser.add_option("results", arguments->files, "Two results files (HDF5); the first is the reference")
      .type_name("A.h5 B.h5");
  parser.add_flag("--json", arguments->json, "The same as JSON");
  add_strict_option(parser, arguments->strict);
  parser.footer(
      "Compares the channels that both have in the same unit, on the instants of the coarser one within the "
      "time they share.\n"
      "Where the other has no such instant its values are interpolated, by cubics where they are smooth. "
      "'interpolation\n"
      "error' estimates how far that may be off: smaller differences mean nothing. For none, write both "
      "files at the same\n"
      "instants (output_interval).\n"
      "Example:\n  mimbre compare coarse.h5 fine.h5");
  return {parser, [arguments] { return run_compare(*arguments); }};
}

}  // namespace mimbre::app
