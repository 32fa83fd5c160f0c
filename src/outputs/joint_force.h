#pragma once
#include "joints/joint_kind.h"
#include "outputs/joint_coordinates.h"

namespace mimbre::outputs {

/// The joint's reaction on its second body, at the joint's point there, in global axes.
struct JointForce {
  static constexpr const char* words[] = {"fx", "fy", "fz", "mx", "my", "mz"};
  /// What a reader of reactions may not know of the joint.
  static const char* note(spec::JointType type) {
    return joint_info(type).all_static_modes
               ? " (a bracket: fixed, and a flexible body gets static modes for it)"
               : "";
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const spec::Joint& joint = joint_of(m, o.item);
    return {o.name, o.component < 3 ? "N" : "N m",
            fmt::format("reaction {} of joint '{}' on its second body, at the joint's point there, {} of the "
                        "global axes{}",
                        o.component < 3 ? "force" : "moment", joint.name, axis_words[o.component % 3],
                        note(joint.type))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const JointReaction r = view.reaction(o.item);
    return o.component < 3 ? r.force[o.component] : r.moment[o.component - 3];
  }
  static constexpr OutputInfo info{.name = "joint_force",
                                   .of = OutputInfo::Of::joint,
                                   .words = words,
                                   .needs = OutputInfo::Needs::reactions,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
