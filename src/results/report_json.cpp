#include "results/report_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "mimbre/diagnostics.h"
#include "results/base64.h"
#include "results/thin_surface.h"

namespace mimbre::results {
namespace {

using Eigen::Index;

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

[[noreturn]] void bad(const std::string& message) { throw InputError(Mark{}, message); }

void same(Index have, Index want, const char* what) {
  if (have != want) bad(fmt::format("results: {} of {}, expected {}", what, have, want));
}

/// How much of any mode's largest stress each point has; empty without stresses.
Eigen::VectorXd stress_weights(const BodyDrawing& body) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(body.stress.size() > 0 ? body.points.cols() : 0);
  for (Index mode = 0; weights.size() > 0 && mode < body.stress.cols(); ++mode) {
    const Eigen::VectorXd sizes = body.stress.col(mode).reshaped(6, body.points.cols()).colwise().norm();
    if (const double largest = sizes.maxCoeff(); largest > 0) weights = weights.cwiseMax(sizes / largest);
  }
  return weights;
}

/// Of each mode (column) the rows of the points kept, `rows` per point.
Json kept_rows(const Eigen::MatrixXd& all, const std::vector<int>& points, Index rows) {
  std::vector<float> values;
  values.reserve(points.size() * static_cast<std::size_t>(rows * all.cols()));
  for (Index mode = 0; mode < all.cols(); ++mode)
    for (const int point : points)
      for (Index k = 0; k < rows; ++k) values.push_back(static_cast<float>(all(rows * point + k, mode)));
  return array_of(values);
}

template <std::size_t corners>
Json indices(const std::vector<std::array<int, corners>>& all) {
  std::vector<std::uint32_t> values;
  values.reserve(corners * all.size());
  for (const auto& one : all)
    for (const int point : one) values.push_back(static_cast<std::uint32_t>(point));
  return array_of(values);
}

Json solids_json(const std::vector<spec::Shape>& solids) {
  Json shapes = Json::array();
  for (const auto& shape : solids) {
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
  return shapes;
}

Json animation_json(const Results& results, int max_frames) {
  std::vector<double> times, positions;
  std::vector<float> rotations, modes;
  for (const Index i : thinned(results.time.size(), max_frames)) {
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

}  // namespace

Json body_json(const BodyDrawing& body, int most) {
  const ThinSurface thin = thin_surface(body.points, body.triangles, free_lines(body.lines, body.triangles),
                                        most, stress_weights(body));
  std::vector<double> labels;
  if (!body.labels.empty())
    for (const int point : thin.points)
      labels.push_back(static_cast<double>(body.labels[static_cast<std::size_t>(point)]));
  // Each line has its own; where lines were left out they have none.
  std::vector<float> bars;
  std::vector<std::uint32_t> round;
  if (thin.lines.size() == body.round_lines.size()) {
    for (const double value : body.bar_stress.reshaped()) bars.push_back(static_cast<float>(value));
    round.assign(body.round_lines.begin(), body.round_lines.end());
  }
  return {{"name", body.name},
          {"modes", body.modes},
          {"lineRadius", body.line_radius},
          {"points", kept_rows(body.points.reshaped(), thin.points, 3)},
          {"pointShapes", kept_rows(body.point_shapes, thin.points, 3)},
          {"lines", indices(thin.lines)},
          {"triangles", indices(thin.triangles)},
          {"edges", indices(thin.edges)},
          {"labels", array_of(labels)},
          {"stress", kept_rows(body.stress, thin.points, 6)},
          {"barStress", array_of(bars)},
          {"roundLines", array_of(round)},
          {"shapes", solids_json(body.shapes)}};
}

int drawn_points(const std::vector<BodyDrawing>& bodies) {
  constexpr Index largest = 2500, least = 300, numbers = 6'000'000;  // single precision: 32 MB of text
  Index per_point = 0;                                               // of all bodies
  for (const auto& body : bodies)
    if (body.points.cols() > least)
      per_point += 3 + 3 * body.point_shapes.cols() + (body.stress.size() > 0 ? 6 * body.stress.cols() : 0);
  return static_cast<int>(std::clamp(per_point > 0 ? numbers / per_point : largest, least, largest));
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

namespace {

/// Turns are counted where a value within ±π jumps by more than half a turn.
void count_turns(Eigen::Ref<Eigen::VectorXd> angle) {
  const double pi = EIGEN_PI, turn = 2 * pi;
  if (!(angle.array().abs() <= pi * (1 + 1e-9)).all()) return;
  double turns = 0;
  for (Index i = 1; i < angle.size(); ++i) {
    const double before = angle(i - 1) - turns * turn, jump = angle(i) - before;
    turns -= std::round(jump / turn);
    angle(i) += turns * turn;
  }
}

}  // namespace

Eigen::MatrixXd continuous_channels(const Results& results) {
  Eigen::MatrixXd channels = results.channels;
  for (Index k = 0; k < channels.cols(); ++k)
    if (results.header.channels[static_cast<std::size_t>(k)].unit == "rad") count_turns(channels.col(k));
  return channels;
}

double typical(const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::vector<double> finite;
  for (const double value : values)
    if (std::isfinite(value)) finite.push_back(value);
  if (finite.empty()) return 0;
  const auto half = finite.begin() + static_cast<std::ptrdiff_t>(finite.size() / 2);
  std::nth_element(finite.begin(), half, finite.end());
  return *half;
}

void check_drawing(const BodyDrawing& body) {
  const Index points = body.points.cols();
  if (body.point_shapes.cols() > 0) {
    same(body.point_shapes.rows(), 3 * points, "rows of point shapes");
    same(body.point_shapes.cols(), body.modes, "columns of point shapes");
  }
  if (body.stress.size() > 0) {
    same(body.stress.rows(), 6 * points, "rows of stress");
    if (body.stress.cols() > body.modes)
      bad(fmt::format("results: stress of {} modes, body '{}' has {}", body.stress.cols(), body.name,
                      body.modes));
  }
  if (!body.round_lines.empty()) {
    same(static_cast<Index>(body.round_lines.size()), static_cast<Index>(body.lines.size()), "round lines");
    same(body.bar_stress.rows(), static_cast<Index>(8 * body.lines.size()), "rows of stress of bars");
    if (body.bar_stress.cols() > body.modes)
      bad(fmt::format("results: stress of bars of {} modes, body '{}' has {}", body.bar_stress.cols(),
                      body.name, body.modes));
  }
  if (!body.labels.empty()) same(static_cast<Index>(body.labels.size()), points, "labels of points");
  const auto inside = [&](const auto& corners, const char* what) {
    for (const int point : corners)
      if (point < 0 || point >= points)
        bad(fmt::format("results: a {} of body '{}' ends at point {} of {}", what, body.name, point, points));
  };
  for (const auto& line : body.lines) inside(line, "line");
  for (const auto& triangle : body.triangles) inside(triangle, "triangle");
}

void check_elements(const ResultsHeader& header) {
  const auto inside = [](int index, std::size_t count, const char* what, const std::string& of) {
    if (index < -1 || index >= static_cast<int>(count))
      bad(fmt::format("results: '{}' is on {} {} of {}", of, what, index, count));
  };
  for (const FrameDrawing& frame : header.frames) {
    inside(frame.body, header.bodies.size(), "body", frame.name);
    const int modes = frame.body < 0 ? 0 : header.bodies[static_cast<std::size_t>(frame.body)].modes;
    same(frame.motion.cols(), modes, "modes of a frame");
    if (modes > 0) same(frame.motion.rows(), 6, "rows of a frame's motion");
  }
  for (const ElementDrawing& element : header.elements)
    for (const int end : {element.frame_a, element.frame_b})
      inside(end, header.frames.size(), "frame", element.name);
}

void check_sizes(const Results& results) {
  const Index instants = results.time.size();
  const auto& header = results.header;
  same(results.channels.rows(), instants, "instants of the channels");
  same(results.channels.cols(), static_cast<Index>(header.channels.size()), "columns of the channels");
  same(static_cast<Index>(results.poses.size()), instants, "instants of the poses");
  same(results.modes.rows(), instants, "instants of the modes");
  for (const auto& poses : results.poses)
    same(poses.cols(), static_cast<Index>(header.bodies.size()), "bodies with poses");
  Index modes = 0;
  for (const auto& body : header.bodies) {
    modes += body.modes;
    check_drawing(body);
  }
  same(results.modes.cols(), modes, "modes");
  check_elements(header);
}

Json scene_json(const Results& results, int max_frames) {
  Json bodies = Json::array(), roads = Json::array();
  const int most = drawn_points(results.header.bodies);
  for (const auto& body : results.header.bodies) bodies.push_back(body_json(body, most));
  for (const auto& road : results.header.roads) {
    std::vector<double> profile;
    for (const double value : road.profile.reshaped()) profile.push_back(value);
    roads.push_back({{"name", road.name}, {"profile", array_of(profile)}});
  }
  Json scene{{"bodies", bodies}, {"roads", roads}, {"animation", animation_json(results, max_frames)}};
  scene.update(elements_json(results.header));
  return scene;
}

Json elements_json(const ResultsHeader& header) {
  Json frames = Json::array(), elements = Json::array();
  for (const FrameDrawing& frame : header.frames) {
    Json position = Json::array(), rotation = Json::array();
    for (int i = 0; i < 3; ++i) {
      position.push_back(frame.pose.position(i));
      for (int j = 0; j < 3; ++j) rotation.push_back(frame.pose.rotation(i, j));
    }
    std::vector<float> motion;
    for (const double value : frame.motion.reshaped()) motion.push_back(static_cast<float>(value));
    frames.push_back({{"name", frame.name},
                      {"body", frame.body},
                      {"position", position},
                      {"rotation", rotation},
                      {"motion", array_of(motion)}});
  }
  for (const ElementDrawing& element : header.elements) {
    Json drawn{{"name", element.name},
               {"kind", element.kind},
               {"a", element.frame_a},
               {"b", element.frame_b},
               {"size", element.size}};
    if (element.curve.size() > 0) {
      const auto curve = element.curve.reshaped();
      drawn["curve"] = array_of(std::vector<float>(curve.begin(), curve.end()));
    }
    elements.push_back(std::move(drawn));
  }
  return {{"frames", frames}, {"elements", elements}};
}

Json parsed(const std::string& text) {
  if (text.empty()) return nullptr;
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json(text) : json;
}

Json shown_channels(const std::vector<ChannelInfo>& channels, const ReportOptions& options) {
  std::vector<std::string> names;
  for (const auto& channel : channels) names.push_back(channel.name);
  Json shown = Json::array();
  for (const auto& name : options.channels) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      bad(fmt::format("no channel '{}' in the results{}", name, did_you_mean(name, names)));
    shown.push_back(found - names.begin());
  }
  return shown;
}

}  // namespace mimbre::results
