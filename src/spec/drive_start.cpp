#include "spec/drive_start.h"

#include <algorithm>
#include <cmath>

#include "joints/joint_kind.h"

namespace mimbre {
namespace {

/// Of figures that a user writes.
constexpr double drive_rounding = 1e-9;

/// How far bodies and their points lie from the origin at most, m.
double extent(const spec::Model& model) {
  double most = 0;
  for (const spec::Body& b : model.bodies) most = std::max(most, b.pose.position.norm());
  for (const spec::Frame& f : model.frames) most = std::max(most, f.pose.position.norm());
  return most;
}

}  // namespace

bool contradicts_drive(const spec::Model& model, spec::JointType type, int coordinate, bool rate,
                       double given, double driven) {
  const double off = std::abs(given - driven);
  if (off == 0) return false;
  const double length = extent(model);
  double scale = is_angle(type, coordinate) ? 1 : length;
  if (rate) scale *= length > 0 ? std::sqrt(model.gravity.norm() / length) : 0;
  return off > drive_rounding * std::max({scale, std::abs(given), std::abs(driven)});
}

}  // namespace mimbre
