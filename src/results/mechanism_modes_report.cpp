#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mimbre/linear_report.h"
#include "results/modes_parts.h"
#include "results/report_json.h"
#include "results/report_page.h"

namespace mimbre {
namespace {

using Eigen::Index;
using results::Json;

/// Of the shapes of all modes: 40 MB of text.
constexpr std::size_t most_numbers = 8'000'000;

Json list_of(const auto& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(value);
  return list;
}

void add_floats(const auto& values, std::vector<float>& to) {
  for (const double value : values.reshaped()) to.push_back(static_cast<float>(value));
}

Json mode_json(const Mode& mode, const BodyShapes& shape, bool turns) {
  Json json{{"kind", results::kind_name(mode)},
            {"frequency", mode.frequency},
            {"damping", mode.damping},
            {"value", Json::array({mode.value.real(), mode.value.imag()})},
            {"grows", mode.grows},
            {"whirl", mode.whirl},
            {"text", mode.text},
            {"reach", shape.reach},
            {"turn", shape.largest_turn}};
  if (turns && std::isfinite(mode.fixed.imag())) json["ground"] = mode.fixed.imag();
  return json;
}

/// Of each body real part of its displacement, imaginary part, the same of its turn: x y z each.
std::vector<float> packed_bodies(const std::vector<BodyShapes>& modes, std::size_t count) {
  std::vector<float> out;
  for (std::size_t m = 0; m < count; ++m)
    for (Index b = 0; b < modes[m].displacement.cols(); ++b)
      for (const Eigen::Matrix3Xcd* part : {&modes[m].displacement, &modes[m].turn}) {
        add_floats(part->col(b).real(), out);
        add_floats(part->col(b).imag(), out);
      }
  return out;
}

/// Of each mode the real parts, then the imaginary ones.
std::vector<float> packed_amplitudes(const std::vector<BodyShapes>& modes, std::size_t count) {
  std::vector<float> out;
  for (std::size_t m = 0; m < count; ++m) {
    add_floats(modes[m].amplitudes.real(), out);
    add_floats(modes[m].amplitudes.imag(), out);
  }
  return out;
}

Json data_json(const LinearisedModes& found) {
  const MechanismShapes& shapes = results::shapes_of(found);
  Results at;
  at.header = shapes.header;
  at.time = Eigen::VectorXd::Constant(1, found.model.time);
  at.channels.resize(1, 0);
  at.poses = {shapes.at.poses};
  at.modes = shapes.at.modes.transpose();
  results::check_sizes(at);
  const auto each = static_cast<std::size_t>(12 * shapes.at.poses.cols() + 2 * shapes.at.modes.size());
  const std::size_t all = found.modes.size(),
                    count = std::min(all,
                                     std::max<std::size_t>(1, most_numbers / std::max<std::size_t>(each, 1)));
  Json modes = Json::array();
  for (std::size_t m = 0; m < count; ++m)
    modes.push_back(mode_json(found.modes[m], shapes.modes[m], found.turning > 0));
  Json data{{"format", "mimbre-mechanism-modes-1"},
            {"title", shapes.header.title},
            {"model", shapes.header.model_text},
            {"point", found.model.point},
            {"all", all},
            {"turning", found.turning},
            {"axis", list_of(shapes.axis)},
            {"place", list_of(shapes.place)},
            {"period", found.period},
            {"size", shapes.size},
            {"notes", found.model.notes},
            {"warnings", found.model.warnings},
            {"modes", modes},
            {"shapes", results::array_of(packed_bodies(shapes.modes, count))},
            {"amplitudes", results::array_of(packed_amplitudes(shapes.modes, count))}};
  data.update(results::scene_json(at, 2));
  return data;
}

}  // namespace

const MechanismShapes& results::shapes_of(const LinearisedModes& modes) {
  if (!modes.shapes)
    throw std::invalid_argument("the modes were found without shapes (ModesOptions::shapes)");
  return *modes.shapes;
}

const char* results::kind_name(const Mode& mode) {
  return mode.kind == Mode::Kind::rigid ? "rigid" : mode.kind == Mode::Kind::real ? "real" : "oscillating";
}

std::string mode_shapes_html(const LinearisedModes& modes) { return results::page_with(data_json(modes)); }

}  // namespace mimbre
