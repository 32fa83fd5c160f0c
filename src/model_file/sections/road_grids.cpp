#include "model_file/sections/road_grids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mimbre/road_file.h"
#include "mimbre/road_profile.h"
#include "model_file/sections/heights.h"
#include "model_file/text/file_reader.h"
#include "roads/grid.h"
#include "roads/overlap.h"

namespace mimbre::model_file {
namespace {

/// Heights that a road has at most: 160 MB.
constexpr double most_heights = 2e7;

std::optional<Eigen::Vector2d> read_pair(const std::optional<Value>& given) {
  const auto numbers = given ? given->numbers(2, 2, quantity::length) : std::nullopt;
  if (!numbers) return std::nullopt;
  return Eigen::Vector2d((*numbers)[0], (*numbers)[1]);
}

struct Box {
  Eigen::Vector2d low, high;
};

/// Around a road whose line bends: as far as its sections reach to all sides of the line. One along x ends
/// with its line.
Box box_around(const RoadGrid& road) {
  const double left = road.v.back(), right = road.v.front(),
               reach = std::max(std::abs(left), std::abs(right));
  const auto [low_x, high_x] = std::minmax_element(road.x.begin(), road.x.end());
  const auto [low_y, high_y] = std::minmax_element(road.y.begin(), road.y.end());
  if (*low_y == *high_y) return {{*low_x, *low_y + right}, {*high_x, *low_y + left}};
  return {{*low_x - reach, *low_y - reach}, {*high_x + reach, *high_y + reach}};
}

/// A straight grid over all of one along a line, from its heights over the straight one's points.
void sample(const RoadGrid& from, const Eigen::Vector2d& spacing, const Value& value, spec::Road& road) {
  const Box box = box_around(from);
  const Eigen::Array2d counts = ((box.high - box.low).array() / spacing.array()).round() + 1;
  if (counts.prod() > most_heights)
    return value.error(
        fmt::format("makes {:.0f} × {:.0f} heights, and at most {:.0e} can be: give a larger 'spacing'",
                    counts[0], counts[1], most_heights));
  road.origin = box.low;
  road.spacing = spacing;
  const roads::GridArrays grid = roads::arrays_of(from, 0);
  road.heights.resize(std::max<Eigen::Index>(2, static_cast<Eigen::Index>(counts[1])),
                      std::max<Eigen::Index>(2, static_cast<Eigen::Index>(counts[0])));
  for (Eigen::Index j = 0; j < road.heights.rows(); ++j)
    for (Eigen::Index i = 0; i < road.heights.cols(); ++i)
      road.heights(j, i) = roads::grid_height(grid, box.low[0] + static_cast<double>(i) * spacing[0],
                                              box.low[1] + static_cast<double>(j) * spacing[1])
                               .z;
}

/// What a file leaves open, or asks for and does not get.
void warn_of_road(Builder& builder, const Value& file, const RoadGrid& road) {
  const auto warn = [&](const std::string& text) {
    builder.warnings.push_back({file.mark(), fmt::format("'{}': {}", *file.word(), text)});
  };
  for (const std::string& key : road.unused) warn(fmt::format("{} is not used", key));
  if (road.holes > 0)
    warn(fmt::format("{} heights between known ones are missing; they are taken from the nearest",
                     road.holes));
  if (const auto overlap = roads::worst_overlap(road, roads::arrays_of(road, 0)))
    warn(fmt::format(
        "{}: at u = {:.6g} m, v = {:.6g} m its height is another one than that of u = {:.6g} m over the same "
        "place, by {:.3g} m; the part counts whose line is nearer",
        overlap->bend ? "the road bends more tightly than it is wide"
                      : "the road crosses itself or comes back over itself",
        overlap->u, overlap->v, overlap->other_u, overlap->difference));
}

void read_file(Builder& builder, const Fields& fields, const Value& file, spec::Road& road) {
  const auto path = file.word();
  if (!path || !has_folder(builder, file)) return;
  const std::string found = path_of(builder, file.mark(), *path);
  builder.other_files.push_back(found);
  try {
    RoadGrid read = builder.reader->road(found);
    warn_of_road(builder, file, read);
    if (const auto spacing = read_pair(fields.get("spacing"))) return sample(read, *spacing, file, road);
    if (static_cast<double>(read.height.size()) > most_heights)
      return file.error(fmt::format("has {} heights, and at most {:.0e} can be: give a 'spacing'",
                                    read.height.size(), most_heights));
    road.along_line = std::move(read);
  } catch (const InputError& e) {
    for (const Diagnostic& d : e.diagnostics()) file.error(to_string(d));
  }
}

/// {class: C, length: 100, seed: 1}.
void read_random(const Value& value, spec::Road& road) {
  const Fields fields(value, {"class", "roughness", "waviness", "length", "width", "seed"});
  if (!value.has_fields()) return;
  RandomRoad what;
  const auto given = fields.get("class"), roughness = fields.get("roughness");
  if (given.has_value() == roughness.has_value())
    return value.error("needs a 'class' from A to H, or a 'roughness' in m³, Gd at 0.1 cycles/m");
  if (roughness) what.roughness = roughness->positive().value_or(1e-6);
  if (given) {
    const std::string word = given->word().value_or("A");
    if (word.size() != 1 || word[0] < 'A' || word[0] > 'H')
      return given->error(fmt::format("is '{}'; classes are A to H", word));
    what.roughness = road_roughness(word[0]);
  }
  if (const auto x = fields.get("waviness")) what.waviness = x->positive().value_or(2);
  if (const auto x = fields.need("length", "100")) what.length = x->positive(quantity::length).value_or(100);
  if (const auto x = fields.get("seed"))
    what.seed = static_cast<std::uint64_t>(x->integer(0, 1000000000).value_or(1));
  double width = 3;
  if (const auto x = fields.get("width")) width = x->positive(quantity::length).value_or(width);
  // Tracks near enough for any wheel, and few enough for each wave to be mixed from them.
  const int tracks = std::clamp(static_cast<int>(std::lround(width / 0.25)) + 1, 2, 41);
  what.v.clear();
  for (int k = 0; k < tracks; ++k) what.v.push_back(width * (static_cast<double>(k) / (tracks - 1) - 0.5));
  if (what.length / what.increment * tracks > most_heights)
    return value.error(fmt::format("{} m are too long for a grid of {} m", what.length, what.increment));
  try {
    sample(random_road(what), {what.increment, width / (tracks - 1)}, value, road);
  } catch (const std::invalid_argument& e) {
    value.error(e.what());
  }
}

void put_at(const Eigen::Vector2d& origin, spec::Road& road) {
  road.origin = origin;
  RoadGrid& grid = road.along_line;
  if (grid.along() == 0) return;
  const Eigen::Vector2d by = origin - box_around(grid).low;
  for (double& x : grid.x) x += by[0];
  for (double& y : grid.y) y += by[1];
}

}  // namespace

void read_road_heights(Builder& builder, const Fields& fields, spec::Road& road) {
  const auto heights = fields.get("heights"), file = fields.get("file"), random = fields.get("iso8608");
  if (heights.has_value() + file.has_value() + random.has_value() != 1)
    return fields.error("needs one of 'heights', 'file' (OpenCRG) and 'iso8608' (a random road)");
  if (file) read_file(builder, fields, *file, road);
  if (random) {
    if (const auto spacing = fields.get("spacing")) spacing->error("a random road has a spacing of its own");
    read_random(*random, road);
  }
  // What made itself a grid may be put elsewhere.
  if (const auto origin = read_pair(heights ? fields.need("origin", "[0, -5]") : fields.get("origin")))
    put_at(*origin, road);
  if (!heights) return;
  if (const auto spacing = read_pair(fields.need("spacing", "[0.5, 0.5]"))) road.spacing = *spacing;
  if (auto read = read_heights(*heights)) road.heights = std::move(*read);
}

}  // namespace mimbre::model_file
