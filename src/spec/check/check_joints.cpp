#include <set>

#include "joints/joint_kind.h"
#include "spec/check/checked_item.h"
#include "spec/drive_start.h"

/// Joints, their drives, springs and initial values.
namespace mimbre::checks {
namespace {

void check_ends(const spec::Model& model, const CheckedItem& item, const spec::Joint& joint) {
  const bool a = item.index("frame_a", joint.frame_a, model.frames.size(), "frames");
  const bool b = item.index("frame_b", joint.frame_b, model.frames.size(), "frames");
  if (!a || !b || !sound_frame(model, joint.frame_a) || !sound_frame(model, joint.frame_b)) return;
  const int body = model.frames[static_cast<std::size_t>(joint.frame_a)].body;
  if (body != model.frames[static_cast<std::size_t>(joint.frame_b)].body) return;
  item.error(body == spec::ground ? "both sides are the ground; a joint needs a body"
                                  : fmt::format("both sides are on body '{}'; a joint needs two bodies",
                                                model.bodies[static_cast<std::size_t>(body)].name));
}

/// What a drive prescribes needs no initial value, and one that is something else would be ignored.
void check_start(const spec::Model& model, const CheckedItem& item, const spec::Joint& joint, int coordinate,
                 bool rate, double driven) {
  const auto& given = rate ? joint.initial_velocity : joint.initial_position;
  const auto k = static_cast<std::size_t>(coordinate);
  if (k < given.size() && given[k] &&
      contradicts_drive(model, joint.type, coordinate, rate, *given[k], driven))
    item.error(fmt::format("{} {} contradicts the drive, which starts with {:.6g}; leave it out",
                           rate ? "initial_velocity" : "initial_position", *given[k], driven));
}

void check_drives(const spec::Model& model, const CheckedItem& item, const spec::Joint& joint) {
  std::set<int> driven;
  for (const spec::Drive& drive : joint.drives) {
    if (!item.enumerator("drive: of", drive.of, 2)) continue;
    if (!check_coordinate(item, "drive", joint.type, drive.coordinate)) continue;
    if (!driven.insert(drive.coordinate).second)
      item.error(fmt::format("coordinate {} is driven twice", drive.coordinate));
    if (drive.signal >= 0) continue;  // check_signals
    if (drive.law.is_zero()) {
      item.error("drive: has no law; Function::constant(0) holds the coordinate");
      continue;
    }
    const double value = drive.law.value(0), rate = drive.law.derivative(0);
    const bool position = drive.of == spec::Drive::Of::position;
    if (!item.finite("drive: law at t = 0", value)) continue;
    if (!position) {
      check_start(model, item, joint, drive.coordinate, true, value);
    } else if (item.finite("drive: rate of the law at t = 0", rate)) {
      check_start(model, item, joint, drive.coordinate, false, value);
      check_start(model, item, joint, drive.coordinate, true, rate);
    }
  }
}

void check_joint_springs(const CheckedItem& item, const spec::Joint& joint) {
  for (const spec::JointSpring& spring : joint.springs) {
    if (!check_coordinate(item, "spring", joint.type, spring.coordinate)) continue;
    if (spring.elastic.is_zero() && spring.damping.is_zero() && spring.general.formula.is_zero())
      item.error("spring: specifies no force; give 'elastic', 'damping' or both");
  }
}

void check_initial(const CheckedItem& item, const char* what, const std::vector<std::optional<double>>& given,
                   const JointInfo& info) {
  if (!given.empty() && static_cast<int>(given.size()) != info.velocities)
    item.error(fmt::format("{} has {} entries; a {} joint has {} coordinates (nullopt where one is free)",
                           what, given.size(), info.name, info.velocities));
  for (const auto& value : given)
    if (value) item.finite(what, *value);
}

}  // namespace

bool check_coordinate(const CheckedItem& item, const char* what, spec::JointType type, int coordinate) {
  const JointInfo& info = joint_info(type);
  // Coordinates that are plain lengths or angles come first.
  const int count = info.quaternion < 0 ? info.velocities : info.rotation;
  if (coordinate >= 0 && coordinate < count) return true;
  if (count == 0)
    item.error(fmt::format("{}: a {} joint has no scalar coordinate to act on", what, info.name));
  else
    item.error(fmt::format("{}: coordinate is {}; the scalar coordinates of a {} joint are 0 to {}", what,
                           coordinate, info.name, count - 1));
  return false;
}

void check_joints(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const spec::Joint& joint = model.joints[k];
    const CheckedItem item(errors, "joint", joint.name, joint.mark, k);
    check_ends(model, item, joint);
    item.enumerator("cut", joint.cut, 3);
    if (!item.enumerator("type", joint.type, static_cast<int>(all_joints().size()))) continue;
    const JointInfo& info = joint_info(joint.type);
    check_initial(item, "initial_position", joint.initial_position, info);
    check_initial(item, "initial_velocity", joint.initial_velocity, info);
    check_initial(item, "near", joint.near, info);
    check_drives(model, item, joint);
    check_joint_springs(item, joint);
  }
}

}  // namespace mimbre::checks
