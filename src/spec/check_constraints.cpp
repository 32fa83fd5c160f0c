#include <algorithm>
#include <set>
#include <utility>

#include "joints/table.h"
#include "spec/checked_item.h"
#include "spec/constraint_kinds.h"

/// Constraints between bodies.
namespace mimbre::checks {
namespace {

using ConstraintKind = spec::Constraint::Kind;

void check_terms(const spec::Model& model, const CheckedItem& item, const spec::Constraint& c) {
  if (c.terms.empty()) item.error("couples nothing; give it the coordinates of joints");
  item.finite("constant", c.constant);
  std::set<std::pair<int, int>> coupled;
  for (const spec::Constraint::Term& term : c.terms) {
    if (!item.index("joint", term.joint, model.joints.size(), "joints")) continue;
    const spec::Joint& joint = model.joints[static_cast<std::size_t>(term.joint)];
    const int type = static_cast<int>(joint.type);
    if (type < 0 || type >= static_cast<int>(joint_table.size())) continue;  // check_joints
    check_coordinate(item, fmt::format("joint '{}'", joint.name).c_str(), joint.type, term.coordinate);
    if (!coupled.insert({term.joint, term.coordinate}).second)
      item.error(fmt::format("has coordinate {} of joint '{}' twice; add up its factors", term.coordinate,
                             joint.name));
    if (item.finite("factor", term.factor) && term.factor == 0)
      item.error(fmt::format("the factor of joint '{}' is 0; leave the joint out", joint.name));
  }
}

void check_points(const CheckedItem& item, const spec::Constraint& c) {
  const std::size_t least = c.closed ? 3 : 2, count = c.points.size();
  if (count < least)
    return item.error(fmt::format("has {} points; {} curve needs {} at least", count,
                                  c.closed ? "a closed" : "an open", least));
  if (!std::all_of(c.points.begin(), c.points.end(), [](const auto& p) { return p.allFinite(); }))
    return item.error("a point of the curve is not finite");
  double extent = 0;
  for (const Eigen::Vector3d& p : c.points) extent = std::max(extent, (p - c.points.front()).norm());
  for (std::size_t k = c.closed ? 0 : 1; k < count; ++k) {
    const std::size_t before = k > 0 ? k - 1 : count - 1;
    if (!((c.points[k] - c.points[before]).norm() > 1e-9 * extent))
      item.error(fmt::format("points {} and {} of the curve are at one place{}", before, k,
                             k == 0 ? "; a closed curve returns to its first point automatically" : ""));
  }
}

void check_frames_of(const spec::Model& model, const CheckedItem& item, const spec::Constraint& c) {
  const bool a = item.index("frame_a", c.frame_a, model.frames.size(), "frames");
  const bool b = item.index("frame_b", c.frame_b, model.frames.size(), "frames");
  if (!a || !b || !sound_frame(model, c.frame_a) || !sound_frame(model, c.frame_b)) return;
  const int body = model.frames[static_cast<std::size_t>(c.frame_a)].body;
  if (body != model.frames[static_cast<std::size_t>(c.frame_b)].body) return;
  if (body == spec::ground)
    item.error("both sides are the ground; a constraint needs a body");
  else if (!model.bodies[static_cast<std::size_t>(body)].flexible)
    item.error(fmt::format("both sides are on the rigid body '{}'; a constraint needs two bodies",
                           model.bodies[static_cast<std::size_t>(body)].name));
}

}  // namespace

void check_constraints(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.constraints.size(); ++k) {
    const spec::Constraint& c = model.constraints[k];
    const CheckedItem item(errors, "constraint", c.name, c.mark, k);
    if (!item.enumerator("kind", c.kind, static_cast<int>(constraint_table.size()))) continue;
    if (c.kind == ConstraintKind::coupling) {
      check_terms(model, item, c);
      continue;
    }
    check_frames_of(model, item, c);
    if (c.kind == ConstraintKind::distance) item.positive("length", c.length);
    if (c.kind == ConstraintKind::screw && item.finite("lead", c.lead) && c.lead == 0)
      item.error("lead is 0, so that it never moves along its axis; a revolute joint does that");
    if (c.kind == ConstraintKind::on_curve) check_points(item, c);
  }
}

}  // namespace mimbre::checks
