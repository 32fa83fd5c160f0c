#include "mimbre/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#include "io/report_page.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr std::string_view kPlaceholder = "%MIMBRE_DATA%";

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = static_cast<std::uint32_t>(bytes[i]) << 16;
    if (left > 1) group |= static_cast<std::uint32_t>(bytes[i + 1]) << 8;
    if (left > 2) group |= bytes[i + 2];
    text += digits[group >> 18];
    text += digits[(group >> 12) & 63];
    text += left > 1 ? digits[(group >> 6) & 63] : '=';
    text += left > 2 ? digits[group & 63] : '=';
  }
  return text;
}

/// Little-endian bytes whatever the machine: browsers' typed arrays are little-endian wherever browsers run.
template <typename Bits, typename Real>
std::string packed(const std::vector<Real>& values) {
  static_assert(sizeof(Bits) == sizeof(Real));
  std::vector<unsigned char> bytes(values.size() * sizeof(Bits));
  std::size_t at = 0;
  for (const Real value : values) {
    Bits bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (std::size_t b = 0; b < sizeof bits; ++b) bytes[at++] = static_cast<unsigned char>(bits >> (8 * b));
  }
  return base64(bytes);
}

Json array_of(const std::vector<float>& values) {
  return {{"type", "f32"}, {"size", values.size()}, {"data", packed<std::uint32_t>(values)}};
}
Json array_of(const std::vector<double>& values) {
  return {{"type", "f64"}, {"size", values.size()}, {"data", packed<std::uint64_t>(values)}};
}
Json array_of(const std::vector<std::uint32_t>& values) {
  return {{"type", "u32"}, {"size", values.size()}, {"data", packed<std::uint32_t>(values)}};
}

/// Indices of at most `most` of `count` instants, evenly spread, first and last included.
std::vector<Index> thinned(Index count, Index most) {
  most = std::max<Index>(most, 2);
  std::vector<Index> kept;
  if (count <= most) {
    for (Index i = 0; i < count; ++i) kept.push_back(i);
    return kept;
  }
  for (Index k = 0; k < most; ++k) kept.push_back(k * (count - 1) / (most - 1));
  return kept;
}

/// Samples of a channel less `offset` (single precision is enough then). A record longer than `most` is cut
/// into stretches of `2·stretch` instants; each leaves its smallest and largest value, in their order.
struct Samples {
  Index count = 0;
  Index half = 1;  ///< instants per kept sample
};

Samples sampling(Index count, Index most) {
  most = std::max<Index>(most, 2);
  if (count <= most) return {count, 1};
  const Index half = (count + most - 1) / most;
  const Index stretches = (count + 2 * half - 1) / (2 * half);
  return {2 * stretches, half};
}

std::vector<double> sample_times(const Eigen::VectorXd& time, const Samples& samples) {
  std::vector<double> kept;
  kept.reserve(static_cast<std::size_t>(samples.count));
  for (Index k = 0; k < samples.count; ++k) kept.push_back(time(std::min(k * samples.half, time.size() - 1)));
  if (samples.half > 1) kept.back() = time(time.size() - 1);
  return kept;
}

void append_samples(const Eigen::Ref<const Eigen::VectorXd>& values, double offset, const Samples& samples,
                    std::vector<float>& out) {
  const auto add = [&](double value) { out.push_back(static_cast<float>(value - offset)); };
  if (samples.half == 1) {
    for (const double value : values) add(value);
    return;
  }
  for (Index begin = 0; begin < values.size(); begin += 2 * samples.half) {
    Index low = begin, high = begin;
    const Index end = std::min(begin + 2 * samples.half, values.size());
    for (Index i = begin; i < end; ++i) {
      // Comparisons with a NaN are false: one at the beginning of the stretch must be stepped over.
      if (values(i) < values(low) || std::isnan(values(low))) low = i;
      if (values(i) > values(high) || std::isnan(values(high))) high = i;
    }
    add(values(std::min(low, high)));
    add(values(std::max(low, high)));
  }
}

/// The middle of the finite values: what is left after subtracting it keeps seven digits of the channel's
/// range.
double middle(const Eigen::Ref<const Eigen::VectorXd>& values) {
  double low = 0, high = 0;
  bool any = false;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = any ? std::min(low, value) : value;
    high = any ? std::max(high, value) : value;
    any = true;
  }
  return low / 2 + high / 2;
}

[[noreturn]] void bad(const std::string& message) { throw InputError(Mark{}, message); }

void check(const Results& results) {
  const Index instants = results.time.size();
  const auto& header = results.header;
  const auto same = [](Index have, Index want, const char* what) {
    if (have != want) bad(fmt::format("results: {} of {}, expected {}", what, have, want));
  };
  same(results.channels.rows(), instants, "instants of the channels");
  same(results.channels.cols(), static_cast<Index>(header.channels.size()), "columns of the channels");
  same(static_cast<Index>(results.poses.size()), instants, "instants of the poses");
  same(results.modes.rows(), instants, "instants of the modes");
  for (const auto& poses : results.poses)
    same(poses.cols(), static_cast<Index>(header.bodies.size()), "bodies with poses");
  Index modes = 0;
  for (const auto& body : header.bodies) {
    modes += body.modes;
    if (body.point_shapes.cols() == 0) continue;
    same(body.point_shapes.rows(), 3 * body.points.cols(), "rows of point shapes");
    same(body.point_shapes.cols(), body.modes, "columns of point shapes");
  }
  same(results.modes.cols(), modes, "modes");
  for (const auto& body : header.bodies)
    for (const auto& line : body.lines)
      for (const int point : line)
        if (point < 0 || point >= body.points.cols())
          bad(fmt::format("results: a line of body '{}' ends at point {} of {}", body.name, point,
                          body.points.cols()));
}

Json body_json(const BodyDrawing& body) {
  std::vector<float> points, point_shapes;
  for (const double value : body.points.reshaped()) points.push_back(static_cast<float>(value));
  for (const double value : body.point_shapes.reshaped()) point_shapes.push_back(static_cast<float>(value));
  std::vector<std::uint32_t> lines;
  for (const auto& line : body.lines)
    for (const int point : line) lines.push_back(static_cast<std::uint32_t>(point));
  Json shapes = Json::array();
  for (const auto& shape : body.shapes) {
    static constexpr const char* kinds[] = {"box", "cylinder", "sphere"};
    Json rotation = Json::array(), position = Json::array(), size = Json::array();
    for (int i = 0; i < 3; ++i) {
      position.push_back(shape.pose.position(i));
      size.push_back(shape.size(i));
      for (int j = 0; j < 3; ++j) rotation.push_back(shape.pose.rotation(i, j));
    }
    shapes.push_back({{"kind", kinds[static_cast<int>(shape.kind)]},
                      {"size", size},
                      {"position", position},
                      {"rotation", rotation}});
  }
  return {{"name", body.name},
          {"modes", body.modes},
          {"lineRadius", body.line_radius},
          {"points", array_of(points)},
          {"pointShapes", array_of(point_shapes)},
          {"lines", array_of(lines)},
          {"shapes", shapes}};
}

Json animation_json(const Results& results, const ReportOptions& options) {
  std::vector<double> times, positions;
  std::vector<float> rotations, modes;
  for (const Index i : thinned(results.time.size(), options.max_frames)) {
    times.push_back(results.time(i));
    const auto& poses = results.poses[static_cast<std::size_t>(i)];
    for (Index body = 0; body < poses.cols(); ++body) {
      for (Index k = 0; k < 3; ++k) positions.push_back(poses(k, body));
      for (Index k = 3; k < 7; ++k) rotations.push_back(static_cast<float>(poses(k, body)));
    }
    for (const double amplitude : results.modes.row(i)) modes.push_back(static_cast<float>(amplitude));
  }
  return {{"time", array_of(times)},
          {"positions", array_of(positions)},
          {"rotations", array_of(rotations)},
          {"modes", array_of(modes)}};
}

/// JSON text as JSON, keys in their order; what cannot be read is shown as it is.
Json parsed(const std::string& text) {
  if (text.empty()) return nullptr;
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json(text) : json;
}

Json shown_channels(const Results& results, const ReportOptions& options) {
  std::vector<std::string> names;
  for (const auto& channel : results.header.channels) names.push_back(channel.name);
  Json shown = Json::array();
  for (const auto& name : options.channels) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      bad(fmt::format("no channel '{}' in the results{}", name, did_you_mean(name, names)));
    shown.push_back(found - names.begin());
  }
  return shown;
}

Json data_json(const Results& results, const ReportOptions& options) {
  const auto& header = results.header;
  const Samples samples = sampling(results.time.size(), options.max_samples);
  Json channels = Json::array();
  std::vector<float> values;
  values.reserve(header.channels.size() * static_cast<std::size_t>(samples.count));
  for (std::size_t k = 0; k < header.channels.size(); ++k) {
    const auto column = results.channels.col(static_cast<Index>(k));
    const double offset = middle(column);
    append_samples(column, offset, samples, values);
    channels.push_back({{"name", header.channels[k].name},
                        {"unit", header.channels[k].unit},
                        {"meaning", header.channels[k].meaning},
                        {"offset", offset}});
  }
  Json bodies = Json::array(), roads = Json::array();
  for (const auto& body : header.bodies) bodies.push_back(body_json(body));
  for (const auto& road : header.roads) {
    std::vector<double> profile;
    for (const double value : road.profile.reshaped()) profile.push_back(value);
    roads.push_back({{"name", road.name}, {"profile", array_of(profile)}});
  }
  return {{"format", "mimbre-report-1"},
          {"title", header.title},
          {"step", header.step},
          {"instants", results.time.size()},
          {"model", header.model_text},
          {"options", parsed(header.options_json)},
          {"summary", parsed(results.summary_json)},
          {"time", array_of(sample_times(results.time, samples))},
          {"channels", channels},
          {"values", array_of(values)},
          {"shown", shown_channels(results, options)},
          {"bodies", bodies},
          {"roads", roads},
          {"animation", animation_json(results, options)}};
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

bool report_available() { return !io::report_page().empty(); }

std::string report_html(const Results& results, const ReportOptions& options) {
  const std::string_view page = io::report_page();
  if (page.empty())
    throw std::runtime_error(
        "this mimbre was built without its report page; install Node.js 18 or newer with npm and "
        "configure with -DMIMBRE_WITH_REPORT=ON");
  check(results);
  const std::size_t at = page.find(kPlaceholder);
  std::string html(page.substr(0, at));
  html += script_safe(data_json(results, options));
  html += page.substr(at + kPlaceholder.size());
  return html;
}

void write_report(const Results& results, const std::string& path, const ReportOptions& options) {
  const std::string html = report_html(results, options);
  const std::string temporary = path + ".part";
  std::ofstream file(temporary, std::ios::binary);
  file.write(html.data(), static_cast<std::streamsize>(html.size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(temporary, path, error);
  if (!file || error) {
    const std::string reason = error ? error.message() : std::strerror(errno);
    std::remove(temporary.c_str());
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path, reason));
  }
}

}  // namespace mimbre
