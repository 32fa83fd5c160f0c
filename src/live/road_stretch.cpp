#include "live/road_stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace mimbre::live {
namespace {

constexpr int samples = 2000, lengths_before = 2, lengths_behind = 17;
constexpr std::size_t most_stretch_points = 20'000;
constexpr double tolerance = 5e-4;  // m: a kept sample may be as far off as those between

/// Keeps the samples from which straight lines pass all others within the tolerance: from the last that was
/// kept, the slopes that still pass all since.
class Thinned {
 public:
  explicit Thinned(std::vector<Eigen::Vector2d>& kept) : kept_(kept) {}
  void add(const Eigen::Vector2d& sample) {
    if (kept_.empty()) {
      kept_.push_back(sample);
    } else if (waiting_) {
      const Eigen::Vector2d step = sample - kept_.back();
      if (step.y() < lowest_ * step.x() || step.y() > highest_ * step.x()) {
        kept_.push_back(last_);
        lowest_ = -std::numeric_limits<double>::infinity();
        highest_ = -lowest_;
      }
    }
    last_ = sample;
    waiting_ = sample.x() > kept_.back().x();
    if (!waiting_) return;
    const Eigen::Vector2d step = sample - kept_.back();
    lowest_ = std::max(lowest_, (step.y() - tolerance) / step.x());
    highest_ = std::min(highest_, (step.y() + tolerance) / step.x());
  }
  void end() {
    if (waiting_) kept_.push_back(last_);
  }

 private:
  std::vector<Eigen::Vector2d>& kept_;
  Eigen::Vector2d last_;
  bool waiting_ = false;  ///< last_ is not kept yet
  double lowest_ = -std::numeric_limits<double>::infinity(),
         highest_ = std::numeric_limits<double>::infinity();
};

}  // namespace

RoadDrawing road_stretch(const spec::Road& road) {
  const double length = road.draw_to - road.draw_from;
  const auto place = [&](int k) { return road.draw_from + length * k / samples; };
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int k = 0; k <= samples; ++k) {
    const double z = road.height.value(place(k));
    if (!std::isfinite(z)) continue;
    low = std::min(low, z);
    high = std::max(high, z);
  }
  std::vector<Eigen::Vector2d> points;
  Thinned thinned(points);
  for (int k = -lengths_before * samples;
       k <= (1 + lengths_behind) * samples && points.size() < most_stretch_points; ++k) {
    const double z = road.height.value(place(k));
    if (z >= low - length && z <= high + length) thinned.add({place(k), z});
  }
  thinned.end();
  RoadDrawing drawing{road.name, Eigen::Matrix2Xd(2, static_cast<Eigen::Index>(points.size()))};
  for (std::size_t k = 0; k < points.size(); ++k)
    drawing.profile.col(static_cast<Eigen::Index>(k)) = points[k];
  return drawing;
}

}  // namespace mimbre::live
