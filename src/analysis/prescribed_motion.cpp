#include "mimbre/prescribed_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "joints/joint_kind.h"
#include "math/once/spline.h"
#include "mimbre/diagnostics.h"
#include "mimbre/input_table.h"
#include "mimbre/text.h"
#include "mimbre/unknown_name.h"

namespace mimbre {
namespace {

/// Coordinates that are numbers: those before a rotation by a quaternion.
int scalars(const spec::Joint& joint) {
  const JointInfo& info = joint_info(joint.type);
  return info.quaternion < 0 ? info.velocities : info.rotation;
}

std::vector<JointCoordinate> all_coordinates(const spec::Model& model) {
  std::vector<JointCoordinate> all;
  for (int j = 0; j < static_cast<int>(model.joints.size()); ++j)
    for (int k = 0; k < scalars(model.joints[static_cast<std::size_t>(j)]); ++k) all.push_back({j, k});
  return all;
}

constexpr const char* quantities[] = {"position", "velocity", "acceleration"};

[[noreturn]] void refuse(const spec::Model& model, const JointCoordinate& of, const std::string& text) {
  throw InputError(Mark{}, fmt::format("the motion of '{}' {}", coordinate_text(model, of), text));
}

Function law(const spec::Model& model, const std::vector<double>& time, const PrescribedMotion::Column& c,
             double smooth) {
  const auto finite = [&](const std::vector<double>& x) {
    return std::all_of(x.begin(), x.end(), [](double y) { return std::isfinite(y); });
  };
  if (c.position.size() != time.size())
    refuse(model, c.of, fmt::format("has {} positions at {} instants", c.position.size(), time.size()));
  if (!finite(c.position) || !finite(c.velocity) || !finite(c.acceleration))
    refuse(model, c.of, "has a number that is not finite");
  if (c.velocity.empty() != c.acceleration.empty())
    refuse(model, c.of, "has velocities or accelerations alone; both are needed, or none");
  if (!c.velocity.empty()) {
    if (c.velocity.size() != time.size() || c.acceleration.size() != time.size())
      refuse(model, c.of, "does not have a velocity and an acceleration at each instant");
    if (smooth > 0)
      refuse(model, c.of, "has its own velocities and accelerations; only positions can be smoothed");
    return quintic_function({time, c.position, c.velocity, c.acceleration});
  }
  if (!(smooth > 0)) return quintic_function(quintic_spline(time, c.position, SplineEnds::not_a_knot));
  return quintic_function(quintic_spline(time, smoothed(time, c.position, smooth), SplineEnds::natural));
}

}  // namespace

std::string coordinate_text(const spec::Model& model, const JointCoordinate& of) {
  const spec::Joint& joint = model.joints[static_cast<std::size_t>(of.joint)];
  return joint_info(joint.type).velocities > 1 ? fmt::format("{}.{}", joint.name, of.coordinate) : joint.name;
}

JointCoordinate find_coordinate(const spec::Model& model, const std::string& name) {
  std::vector<std::string> names;
  for (const JointCoordinate& of : all_coordinates(model)) {
    names.push_back(coordinate_text(model, of));
    if (names.back() == name) return of;
  }
  throw UnknownName(Mark{},
                    fmt::format("there is no joint coordinate '{}'{}", name, did_you_mean(name, names)));
}

PrescribedMotion read_motion_table(const std::string& path, const spec::Model& model) {
  const std::vector<JointCoordinate> all = all_coordinates(model);
  // The table of inputs has the names; each may be called in two ways.
  std::vector<spec::Input> names;
  struct Meaning {
    std::size_t coordinate;
    std::size_t quantity;
  };
  std::vector<Meaning> meanings;
  const auto add = [&](std::string name, std::string unit, Meaning meaning) {
    spec::Input input;
    input.name = std::move(name);
    input.unit = std::move(unit);
    names.push_back(std::move(input));
    meanings.push_back(meaning);
  };
  for (std::size_t k = 0; k < all.size(); ++k) {
    const spec::Joint& joint = model.joints[static_cast<std::size_t>(all[k].joint)];
    const std::string unit = is_angle(joint.type, all[k].coordinate) ? "rad" : "m";
    const std::string text = coordinate_text(model, all[k]);
    const std::string number =
        joint_info(joint.type).velocities > 1 ? fmt::format(".{}", all[k].coordinate) : "";
    add(text, unit, {k, 0});
    for (std::size_t q = 0; q < 3; ++q) {
      const std::string with = q == 0 ? unit : q == 1 ? unit + "/s" : unit + "/s^2";
      add(fmt::format("joint.{}.{}{}", joint.name, quantities[q], number), with, {k, q});
      if (q > 0) add(fmt::format("{}.{}", text, quantities[q]), with, {k, q});
    }
  }
  PrescribedMotion motion;
  std::vector<int> column_of(all.size(), -1);
  for (RecordedInput& read : read_input_table(path, names, {}, "a coordinate of a joint")) {
    const Meaning meaning = meanings[static_cast<std::size_t>(read.input)];
    int& at = column_of[meaning.coordinate];
    if (at < 0) {
      at = static_cast<int>(motion.columns.size());
      motion.columns.push_back({all[meaning.coordinate], {}, {}, {}});
    }
    PrescribedMotion::Column& column = motion.columns[static_cast<std::size_t>(at)];
    std::vector<double>* const places[] = {&column.position, &column.velocity, &column.acceleration};
    const std::string& name = names[static_cast<std::size_t>(read.input)].name;
    if (!places[meaning.quantity]->empty())
      throw InputError({path, 0, 0}, fmt::format("has column '{}' twice, by two names", name));
    if (motion.time.empty()) motion.time = read.times;
    if (read.times != motion.time)
      throw InputError({path, 0, 0}, fmt::format("column '{}' has a cell without a number; a motion needs "
                                                 "one at each instant",
                                                 name));
    *places[meaning.quantity] = std::move(read.values);
  }
  for (const PrescribedMotion::Column& column : motion.columns)
    if (column.position.empty())
      throw InputError({path, 0, 0}, fmt::format("has no positions of '{}'; a column of that name is missing",
                                                 coordinate_text(model, column.of)));
  return motion;
}

spec::Model with_motion(spec::Model model, const PrescribedMotion& motion, double smooth) {
  if (motion.columns.empty()) throw InputError(Mark{}, "the motion prescribes no coordinate of a joint");
  if (motion.time.size() < 2)
    throw InputError(Mark{}, fmt::format("the motion has {}; two are needed at least",
                                         motion.time.empty() ? "no instant" : "one instant"));
  if (!(smooth >= 0 && std::isfinite(smooth)))
    throw InputError(Mark{}, fmt::format("smooth is {}; it is a time in s, 0 or more", smooth));
  for (std::size_t k = 0; k < motion.time.size(); ++k)
    if (!(motion.time[k] >= 0) || (k > 0 && !(motion.time[k] > motion.time[k - 1])) ||
        !std::isfinite(motion.time[k]))
      throw InputError(Mark{},
                       fmt::format("the instants of the motion must ascend from 0 or later; number {} "
                                   "is {} s",
                                   k + 1, motion.time[k]));
  for (const PrescribedMotion::Column& column : motion.columns) {
    const auto [joint, coordinate] = column.of;
    if (joint < 0 || joint >= static_cast<int>(model.joints.size()))
      throw InputError(Mark{}, fmt::format("the motion has joint {}, which there is not", joint));
    spec::Joint& of = model.joints[static_cast<std::size_t>(joint)];
    if (coordinate < 0 || coordinate >= scalars(of))
      throw InputError(Mark{}, fmt::format("joint '{}' has no scalar coordinate {}", of.name, coordinate));
    std::erase_if(of.drives, [&](const spec::Drive& drive) { return drive.coordinate == coordinate; });
    spec::Drive drive;
    drive.coordinate = coordinate;
    drive.law = law(model, motion.time, column, smooth);
    of.drives.push_back(std::move(drive));
    for (auto* given : {&of.initial_position, &of.initial_velocity, &of.near})
      if (static_cast<int>(given->size()) > coordinate)
        (*given)[static_cast<std::size_t>(coordinate)].reset();
  }
  model.simulation.end = std::max(motion.time.back(), 1e-9);
  return model;
}

}  // namespace mimbre
