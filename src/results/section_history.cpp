#include "mimbre/section_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "base/output_place.h"
#include "mimbre/reduced_body.h"

namespace mimbre {
namespace {

const std::string& body_name(const Results& results, const RecordedSection& section) {
  return results.header.bodies[static_cast<std::size_t>(section.body)].name;
}

/// Names of bodies and bars have no commas or quotes: they are words of the model file.
std::string place(const Results& results, const RecordedSection& section) {
  return fmt::format("{},{},{},{},{:.10g}", body_name(results, section), section.bar, section.element,
                     section.end ? "end" : "start", section.along);
}

void write(const std::string& path, std::string_view text) {
  try {
    write_whole(path, text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path, error.what()));
  }
}

}  // namespace

bool is_of(const Results& results, const RecordedSection& section, const std::vector<std::string>& bodies) {
  return bodies.empty() ||
         std::find(bodies.begin(), bodies.end(), body_name(results, section)) != bodies.end();
}

Extremes extremes(const Results& results, int channel) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Extremes found{nan, nan, nan, nan};
  for (Eigen::Index k = 0; k < results.time.size(); ++k) {
    const double value = results.channels(k, channel), time = results.time[k];
    if (std::isnan(value)) continue;
    if (!(value >= found.least)) found.least = value, found.least_time = time;
    if (!(value <= found.most)) found.most = value, found.most_time = time;
  }
  return found;
}

void write_section_loads(const Results& results, const std::vector<std::string>& bodies,
                         const std::string& path) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "body,bar,element,end,along,t,{}\n", fmt::join(section_components, ","));
  for (const RecordedSection& section : results.header.sections) {
    if (!is_of(results, section, bodies)) continue;
    const std::string where = place(results, section);
    for (Eigen::Index k = 0; k < results.time.size(); ++k) {
      fmt::format_to(out, "{},{}", where, results.time[k]);
      for (const int channel : section.channels)
        if (channel < 0)
          text.push_back(',');
        else
          fmt::format_to(out, ",{}", results.channels(k, channel));
      text.push_back('\n');
    }
  }
  write(path, {text.data(), text.size()});
}

void write_section_envelopes(const Results& results, const std::vector<std::string>& bodies,
                             const std::string& path) {
  std::string text = "body,bar,element,end,along,component,min,min_time,max,max_time\n";
  for (const RecordedSection& section : results.header.sections) {
    if (!is_of(results, section, bodies)) continue;
    for (std::size_t c = 0; c < section.channels.size(); ++c) {
      if (section.channels[c] < 0) continue;
      const Extremes e = extremes(results, section.channels[c]);
      text += fmt::format("{},{},{},{},{},{}\n", place(results, section), section_components[c], e.least,
                          e.least_time, e.most, e.most_time);
    }
  }
  write(path, text);
}

}  // namespace mimbre
