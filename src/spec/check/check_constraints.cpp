#include <algorithm>
#include <set>
#include <utility>

#include "joints/joint_kind.h"
#include "spec/check/checked_item.h"
#include "spec/constraint_kind.h"

/// Constraints between bodies.
namespace mimbre::checks {
namespace {

void check_terms(const spec::Model& model, const CheckedItem& item, const spec::Constraint& c) {
  if (c.terms.empty()) item.error("couples nothing; give it the coordinates of joints");
  std::set<std::pair<int, int>> coupled;
  for (const spec::Constraint::Term& term : c.terms) {
    if (!item.index("joint", term.joint, model.joints.size(), "joints")) continue;
    const spec::Joint& joint = model.joints[static_cast<std::size_t>(term.joint)];
    if (!is_joint(joint.type)) continue;  // check_joints
    check_coordinate(item, fmt::format("joint '{}'", joint.name).c_str(), joint.type, term.coordinate);
    if (!coupled.insert({term.joint, term.coordinate}).second)
      item.error(fmt::format("has coordinate {} of joint '{}' twice; add up its factors", term.coordinate,
                             joint.name));
    if (item.finite("factor", term.factor) && term.factor == 0)
      item.error(fmt::format("the factor of joint '{}' is 0; leave the joint out", joint.name));
  }
}

void check_constraint_numbers(const CheckedItem& item, const spec::Constraint& c,
                              const ConstraintInfo& info) {
  if (c.numbers.size() != info.numbers.size())
    return item.error(
        fmt::format("a {} has {} numbers, {} are given", info.name, info.numbers.size(), c.numbers.size()));
  for (const double number : c.numbers)
    if (!item.finite("one of numbers", number)) return;
  ConstraintInfo::Faults faults;
  if (info.check) info.check(c, faults);
  for (const std::string& fault : faults) item.error(fault);
  if (!faults.empty()) return;
  for (std::size_t k = 0; k < c.numbers.size(); ++k)
    if (const LawNumber& number = info.numbers[k]; !number.allows(c.numbers[k]))
      item.error(fmt::format("{} {}", number.key, wrong_number(number, c.numbers[k])));
}

void check_frames_of(const spec::Model& model, const CheckedItem& item, const spec::Constraint& c) {
  if (!c.terms.empty()) item.error("has terms, which belong to a coupling");
  const bool a = item.index("frame_a", c.frame_a, model.frames.size(), "frames");
  const bool b = item.index("frame_b", c.frame_b, model.frames.size(), "frames");
  if (!a || !b || !sound_frame(model, c.frame_a) || !sound_frame(model, c.frame_b)) return;
  const int body = model.frames[static_cast<std::size_t>(c.frame_a)].body;
  if (constraint_info(find_constraint(c.type)).on_road && body != spec::ground)
    item.error("the first side has to be the ground");
  if (body != model.frames[static_cast<std::size_t>(c.frame_b)].body) return;
  if (body == spec::ground)
    item.error("both sides are the ground; a constraint needs a body");
  else if (!model.bodies[static_cast<std::size_t>(body)].flexible)
    item.error(fmt::format("both sides are on the rigid body '{}'; a constraint needs two bodies",
                           model.bodies[static_cast<std::size_t>(body)].name));
}

void check_road_of(const spec::Model& model, const CheckedItem& item, const spec::Constraint& c,
                   const ConstraintInfo& info) {
  if (!info.on_road) {
    if (c.road >= 0) item.error(fmt::format("has a road; a {} takes none", info.name));
    return;
  }
  if (!item.index("road", c.road, model.roads.size(), "roads")) return;
  const spec::Road& road = model.roads[static_cast<std::size_t>(c.road)];
  if (road.over != spec::Road::Over::grid)
    item.error(fmt::format("road '{}' has no grid; a wheel that rolls without slip needs a road over a grid",
                           road.name));
  else if (road.along_line.along() > 0)
    item.error(fmt::format(
        "road '{}' has kinks between the points of its file, and no wheel rolls over a kink; give it "
        "a `spacing`, which rounds them",
        road.name));
}

}  // namespace

void check_constraints(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.constraints.size(); ++k) {
    const spec::Constraint& c = model.constraints[k];
    const CheckedItem item(errors, "constraint", c.name, c.mark, k);
    const int kind = find_constraint(c.type);
    if (kind < 0) {
      item.error(fmt::format("type is '{}', which there is not", c.type));
      continue;
    }
    const ConstraintInfo& info = constraint_info(kind);
    if (info.of_coordinates)
      check_terms(model, item, c);
    else
      check_frames_of(model, item, c);
    check_road_of(model, item, c, info);
    check_constraint_numbers(item, c, info);
  }
}

}  // namespace mimbre::checks
