#include "model_file/text/degrees.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "joints/joint_kind.h"

namespace mimbre::model_file {
namespace {

constexpr double turn = 2 * std::numbers::pi;

/// The range of a law that comes back on its way; 0 of one that only rises or only falls.
double swing(const Function& law, double end) {
  constexpr int samples = 1000;
  double least = law.value(0), most = least, way = 0;
  double last = least;
  for (int k = 1; k <= samples; ++k) {
    const double now = law.value(end * k / samples);
    way += std::abs(now - last);
    least = std::min(least, now);
    most = std::max(most, now);
    last = now;
  }
  return way > 1.5 * (most - least) ? most - least : 0;
}

}  // namespace

void warn_of_degrees(Builder& builder) {
  for (const spec::Joint& joint : builder.model.joints) {
    const auto warn = [&](const std::string& what, double angle) {
      builder.warnings.push_back(
          {joint.mark,
           fmt::format("joint '{}' {} {:.4g} rad, {:.3g} turns; where degrees are meant write them: "
                       "30 deg",
                       joint.name, what, angle, std::abs(angle) / turn)});
    };
    for (const spec::Drive& drive : joint.drives) {
      if (!is_angle(joint.type, drive.coordinate) || drive.of != spec::Drive::Of::position) continue;
      const double start = drive.law.value(0), range = swing(drive.law, builder.model.simulation.end);
      if (std::abs(start) > turn)
        warn("is driven from", start);
      else if (range > 5 * turn)
        warn("is driven to and fro over", range);
    }
    for (int k = 0; k < static_cast<int>(joint.initial_position.size()); ++k)
      if (const auto& angle = joint.initial_position[static_cast<std::size_t>(k)];
          angle && is_angle(joint.type, k) && std::abs(*angle) > turn)
        warn("starts at", *angle);
  }
}

}  // namespace mimbre::model_file
