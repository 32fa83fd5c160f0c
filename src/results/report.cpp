#include "mimbre/report.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string_view>

#include "base/output_place.h"
#include "results/report_json.h"
#include "results/report_page.h"

namespace mimbre {
namespace {

using Eigen::Index;
using results::Json;

constexpr std::string_view kPlaceholder = "%MIMBRE_DATA%";

Json data_json(const Results& results, const ReportOptions& options) {
  const auto& header = results.header;
  const results::Samples samples = results::sampling(results.time.size(), options.max_samples);
  const Eigen::MatrixXd continuous = results::continuous_channels(results);
  Json channels = Json::array();
  std::vector<float> values;
  values.reserve(header.channels.size() * static_cast<std::size_t>(samples.count));
  for (std::size_t k = 0; k < header.channels.size(); ++k) {
    const auto column = continuous.col(static_cast<Index>(k));
    const double offset = results::typical(column);
    results::append_samples(column, offset, samples, values);
    channels.push_back({{"name", header.channels[k].name},
                        {"unit", header.channels[k].unit},
                        {"meaning", header.channels[k].meaning},
                        {"offset", offset}});
  }
  Json data = {{"format", "mimbre-report-1"},
               {"title", header.title},
               {"step", header.step},
               {"instants", results.time.size()},
               {"model", header.model_text},
               {"options", results::parsed(header.options_json)},
               {"summary", results::parsed(results.summary_json)},
               {"time", results::array_of(results::sample_times(results.time, samples))},
               {"channels", channels},
               {"values", results::array_of(values)},
               {"shown", results::shown_channels(header.channels, options)}};
  data.update(results::scene_json(results, options.max_frames));
  return data;
}

/// JSON that may stand in a script element: with no '<' in it, nothing in it can end or hide the element.
std::string script_safe(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

}  // namespace

std::string results::page_with(const Json& data) {
  const std::string_view page = report_page();
  if (page.empty())
    throw std::runtime_error(
        "this mimbre was built without its report page; install Node.js 18 or newer with npm and "
        "configure with -DMIMBRE_WITH_REPORT=ON");
  const std::size_t at = page.find(kPlaceholder);
  std::string html(page.substr(0, at));
  html += script_safe(data);
  html += page.substr(at + kPlaceholder.size());
  return html;
}

void results::write_page(const std::string& html, const std::string& path) {
  try {
    write_whole(path, html);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path, error.what()));
  }
}

bool report_available() { return !results::report_page().empty(); }

std::string report_html(const Results& results, const ReportOptions& options) {
  results::check_sizes(results);
  return results::page_with(data_json(results, options));
}

void write_report(const Results& results, const std::string& path, const ReportOptions& options) {
  results::write_page(report_html(results, options), path);
}

}  // namespace mimbre
