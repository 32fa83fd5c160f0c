#include "simulation/observe/channel_view.h"

#include <utility>

#include "dynamics/amplitudes.h"
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/momentum.h"
#include "mimbre/reduced_body.h"
#include "simulation/observe/contact_channels.h"
#include "simulation/observe/section_forces.h"

namespace mimbre {

ObservedOutput::ObservedOutput(const Compiled& m, const spec::Output& o) : output(&o), info(&output_info(o)) {
  if (info->of != OutputInfo::Of::bodies) return;
  for (const int b : o.bodies) bodies.push_back(m.body_of_spec[static_cast<std::size_t>(b)]);
  if (o.bodies.empty())
    for (int b = 0; b < static_cast<int>(m.bodies.size()); ++b) bodies.push_back(b);
}

Vec3d ChannelView::origin() const { return system_.workspace().origin; }

Motion<double> ChannelView::motion(int frame) const {
  return relative::observed_motion(system_, model.frame_of_spec[frame], state_.q.data(), state_.v.data(),
                                   state_.a.data());
}

Vec3d ChannelView::deflection(int frame) const {
  const FrameData& f = model.frames[model.frame_of_spec[frame]];
  const BodyData& b = model.bodies[f.body];
  const FlexibleData& flexible = model.flexible[b.flexible];
  double* const y = system_.workspace().scratch.data();
  relative::copy_modes(b, state_.q.data() + b.q + b.joint_positions, flexible.stride, y);
  extend(flexible, y);
  return times(f.X, y);
}

JointCoordinates ChannelView::coordinates(int joint) const {
  return joints_.coordinates(joint, system_, state_);
}

MassMotion ChannelView::mass_motion() const {
  const relative::Momentum p =
      relative::momentum<double>(model, system_.workspace(), bodies_, state_.q.data(), state_.v.data());
  return {p.centre, p.linear, p.angular};
}

ElementState<const double> ChannelView::element(int element) const {
  return element_state(model.elements[element], std::as_const(system_.workspace().elements).data());
}

ContactSum ChannelView::contact(int contact, int body) const {
  return contact_sum(model, system_.workspace(), contact, body);
}

double ChannelView::slot(int slot) const {
  return system_.workspace().signals.value[static_cast<std::size_t>(slot)];
}

JointReaction ChannelView::reaction(int joint) const { return joints_.reaction(joint, system_, state_); }

Eigen::Matrix<double, 6, 1> ChannelView::section_forces(int body, int section) const {
  return mimbre::section_forces(system_, *spec().bodies[static_cast<std::size_t>(body)].flexible->sections,
                                model.body_of_spec[body], section, state_);
}

}  // namespace mimbre
