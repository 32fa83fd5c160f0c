#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "math/turn.h"
#include "urdf/robot.h"

namespace mimbre::urdf {
namespace {

/// The joint's coordinate stays at this value from now on.
void fix(Robot& robot, Joint& joint, double value, const std::string& why) {
  robot.notes.push_back(
      {joint.mark, fmt::format("joint '{}' is fixed at {:.6g}: {}", joint.name, value, why)});
  Pose moved;
  if (joint.turns())
    moved.rotation = turn_about(joint.axis, value);
  else
    moved.position = value * joint.axis;
  if (value != 0) joint.pose = joint.pose.of(moved);
  joint.type = Joint::Type::fixed;
  joint.mimic.reset(), joint.lower.reset(), joint.upper.reset();
  joint.effort = joint.damping = joint.friction = 0;
}

}  // namespace

void fix_immobile_joints(Robot& robot) {
  std::map<std::string, double> values;  // of joints that do not move
  for (Joint& joint : robot.joints) {
    if (joint.type == Joint::Type::fixed) {
      if (joint.mimic) {
        robot.notes.push_back({joint.mark, fmt::format("joint '{}' is fixed; that it mimics '{}' is left out",
                                                       joint.name, joint.mimic->joint)});
        joint.mimic.reset();
      }
      values[joint.name] = 0;
    } else if (joint.lower && *joint.lower == *joint.upper) {
      const double value = *joint.lower;
      fix(robot, joint, value, "its lower limit is its upper limit");
      values[joint.name] = value;
    }
  }
  // A chain of followers takes a round for each of its joints.
  for (bool more = true; more;) {
    more = false;
    for (Joint& joint : robot.joints) {
      if (!joint.mimic) continue;
      const Mimic mimic = *joint.mimic;
      const auto leader = values.find(mimic.joint);
      if (mimic.multiplier != 0 && leader == values.end()) continue;
      const double value = (mimic.multiplier == 0 ? 0 : mimic.multiplier * leader->second) + mimic.offset;
      fix(robot, joint, value,
          mimic.multiplier == 0 ? fmt::format("it mimics '{}' with the multiplier 0", mimic.joint)
                                : fmt::format("it mimics '{}', which does not move", mimic.joint));
      values[joint.name] = value;
      more = true;
    }
  }
}

}  // namespace mimbre::urdf
