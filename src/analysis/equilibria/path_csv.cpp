#include <fmt/format.h>

#include <stdexcept>

#include "base/output_place.h"
#include "mimbre/equilibrium_path.h"

namespace mimbre {

std::vector<int> shown_channels(const EquilibriumPath& path) {
  std::vector<int> shown;
  for (int k = 0; k < path.output_count; ++k) shown.push_back(k);
  if (!shown.empty()) return shown;
  for (std::size_t k = 0; k < path.channels.size(); ++k) {
    const ChannelInfo& channel = path.channels[k];
    if (channel.name.starts_with("joint.") && (channel.unit == "m" || channel.unit == "rad"))
      shown.push_back(static_cast<int>(k));
  }
  return shown;
}

void write_csv(const EquilibriumPath& path, const std::string& file) {
  std::string text = "branch,factor,unstable,point";
  const std::vector<int> shown = shown_channels(path);
  for (const int k : shown) text += ',' + path.channels[static_cast<std::size_t>(k)].name;
  text += '\n';
  for (std::size_t b = 0; b < path.branches.size(); ++b)
    for (const PathPoint& point : path.branches[b].points) {
      text += fmt::format("{},{},{},{}", b, point.factor, point.unstable,
                          path_point_words[static_cast<std::size_t>(point.kind)]);
      for (const int k : shown) text += fmt::format(",{}", point.values[k]);
      text += '\n';
    }
  try {
    write_whole(file, text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}: {}", file, error.what()));
  }
}

}  // namespace mimbre
