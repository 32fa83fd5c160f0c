#include "fe_files/nastran/nastran_systems.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "fe_files/text.h"

// MSC Nastran Quick Reference Guide, CORD1R to CORD2S.

namespace mimbre::fe {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using SystemKind = NastranSystem::Kind;

constexpr int kLongestChain = 1000;
constexpr double kDegree = std::numbers::pi / 180;

/// sin and cos that are exact at multiples of 90°.
Vector3d direction_in_plane(double degrees) {
  const double quarter = std::fmod(degrees, 360.0) / 90;
  if (quarter == std::round(quarter)) {
    constexpr double cosines[] = {1, 0, -1, 0};
    const int q = ((static_cast<int>(std::lround(quarter)) % 4) + 4) % 4;
    return {cosines[q], cosines[(q + 3) % 4], 0};
  }
  return {std::cos(degrees * kDegree), std::sin(degrees * kDegree), 0};
}

}  // namespace

Vector3d NastranSystem::place(const Vector3d& c) const {
  Vector3d local = c;
  if (kind == SystemKind::cylindrical) {
    local = c[0] * direction_in_plane(c[1]);
    local.z() = c[2];
  } else if (kind == SystemKind::spherical) {  // r, θ from the z axis, φ about it
    const Vector3d from_z = direction_in_plane(c[1]);
    local = c[0] * from_z[1] * direction_in_plane(c[2]);
    local.z() = c[0] * from_z[0];
  }
  return origin + axes * local;
}

Matrix3d NastranSystem::directions(const Vector3d& at) const {
  if (kind == SystemKind::rectangular) return axes;
  const Vector3d local = axes.transpose() * (at - origin);
  const double radius = std::hypot(local.x(), local.y());
  const Vector3d out = radius > 1e-9 * (std::abs(local.z()) + (at.norm() + origin.norm()))
                           ? Vector3d(local.x() / radius, local.y() / radius, 0)
                           : Vector3d(Vector3d::UnitX());
  const Vector3d around(-out.y(), out.x(), 0), up = Vector3d::UnitZ();
  Matrix3d result;
  if (kind == SystemKind::cylindrical) {
    result << out, around, up;
  } else {
    const double distance = local.norm();
    const double sine = distance > 0 ? radius / distance : 0,
                 cosine = distance > 0 ? local.z() / distance : 1;
    result << sine * out + cosine * up, cosine * out - sine * up, around;
  }
  return axes * result;
}

bool NastranSystem::is_basic() const { return kind == SystemKind::rectangular && axes.isIdentity(1e-9); }

void NastranSystems::add(const NastranCard& card, std::size_t label_field, Card system) {
  const std::int64_t label = card.label(label_field, "coordinate system");
  system.mark = card.mark;
  if (!cards_.emplace(label, std::move(system)).second)
    card.fail(fmt::format("coordinate system {} is there already", label));
}

bool NastranSystems::read(const NastranCard& card) {
  const std::string& name = card.name;
  if (name.size() != 6 || !name.starts_with("CORD")) return false;
  Card system;
  switch (name[5]) {
    case 'R':
      system.kind = SystemKind::rectangular;
      break;
    case 'C':
      system.kind = SystemKind::cylindrical;
      break;
    case 'S':
      system.kind = SystemKind::spherical;
      break;
    default:
      return false;
  }
  if (name[4] == '2') {
    system.reference = card.whole(1, "coordinate system", 0);
    for (std::size_t i = 0; i < 3; ++i) system.points[i] = card.vector(2 + 3 * i, "coordinate");
    add(card, 0, std::move(system));
    return true;
  }
  if (name[4] != '1') return false;
  for (std::size_t first = 0; first == 0 || !card.blank(first); first += 4) {  // two stand on a card
    for (std::size_t i = 0; i < 3; ++i) system.grids[i] = card.label(first + 1 + i, "node");
    add(card, first, system);
    if (first == 4) break;
  }
  return true;
}

std::array<Vector3d, 3> NastranSystems::points_of(std::int64_t label, const Card& card, const FindGrid& find,
                                                  int depth) {
  std::array<Vector3d, 3> points;
  if (card.grids[0] > 0) {
    for (std::size_t i = 0; i < 3; ++i) {
      GridPlace grid;
      if (!find(card.grids[i], grid))
        throw InputError(card.mark,
                         fmt::format("node {} of coordinate system {} is not there", card.grids[i], label));
      points[i] = resolved(grid.system, card.mark, find, depth + 1).place(grid.coordinates);
    }
    return points;
  }
  const NastranSystem& reference = resolved(card.reference, card.mark, find, depth + 1);
  for (std::size_t i = 0; i < 3; ++i) points[i] = reference.place(card.points[i]);
  return points;
}

const NastranSystem& NastranSystems::resolved(std::int64_t label, const Mark& mark, const FindGrid& find,
                                              int depth) {
  if (const auto done = systems_.find(label); done != systems_.end()) return done->second;
  const auto found = cards_.find(label);
  if (found == cards_.end())
    throw InputError(mark,
                     fmt::format("coordinate system {} is not there; give the file that has it", label));
  Card& card = found->second;
  if (card.within || depth > kLongestChain)
    throw InputError(card.mark, "coordinate systems refer to each other in a circle");
  card.within = true;
  std::array<Vector3d, 3> points;
  try {
    points = points_of(label, card, find, depth);
  } catch (...) {
    card.within = false;
    throw;
  }
  card.within = false;
  const Vector3d z = points[1] - points[0], aside = points[2] - points[0], y = z.cross(aside);
  if (!(y.norm() > 1e-12 * z.norm() * aside.norm()))
    throw InputError(card.mark, fmt::format("the three points of coordinate system {} are on a line", label));
  NastranSystem system;
  system.kind = card.kind;
  system.origin = points[0];
  system.axes.col(1) = y.normalized();
  system.axes.col(2) = z.normalized();
  system.axes.col(0) = system.axes.col(1).cross(system.axes.col(2));
  return systems_.emplace(label, system).first->second;
}

void NastranSystems::resolve(const FindGrid& find) {
  std::vector<Diagnostic> wrong;
  for (auto& [label, card] : cards_) {
    try {
      resolved(label, card.mark, find, 0);
    } catch (const InputError& error) {
      // What refers to a wrong one would report the same again.
      for (const Diagnostic& one : error.diagnostics()) {
        bool is_new = true;
        for (const Diagnostic& other : wrong) is_new = is_new && to_string(other) != to_string(one);
        if (is_new && wrong.size() < 100) wrong.push_back(one);
      }
    }
  }
  if (!wrong.empty()) throw InputError(std::move(wrong));
}

const NastranSystem& NastranSystems::at(std::int64_t label, const Mark& mark) const {
  const auto found = systems_.find(label);
  if (found == systems_.end())
    throw InputError(mark,
                     fmt::format("coordinate system {} is not there; give the file that has it", label));
  return found->second;
}

}  // namespace mimbre::fe
