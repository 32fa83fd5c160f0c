#include "simulation/observe/channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_map>

#include "dynamics/amplitudes.h"
#include "mimbre/diagnostics.h"
#include "outputs/wheel_quantities.h"
#include "simulation/describe/contact_drawings.h"
#include "simulation/observe/constraint_channels.h"
#include "simulation/observe/contact_channels.h"
#include "simulation/observe/element_channels.h"

namespace mimbre {
namespace {

/// Throws InputError where an output, which comes first, is called like a standard channel.
void check_names(const std::vector<spec::Output>& outputs, const std::vector<ChannelInfo>& channels) {
  std::unordered_map<std::string_view, const spec::Output*> named;
  for (const spec::Output& o : outputs) named.emplace(o.name, &o);
  std::vector<Diagnostic> taken;
  for (std::size_t k = outputs.size(); k < channels.size(); ++k)
    if (const auto found = named.find(channels[k].name); found != named.end())
      taken.push_back({found->second->mark,
                       fmt::format("output '{}': every run of this model has a channel of that name ({}); "
                                   "rename the output, or leave it out",
                                   channels[k].name, channels[k].meaning)});
  if (!taken.empty()) throw InputError(std::move(taken));
}

}  // namespace

void Channels::close_part(Part::Kind kind, int item, Needs needs) {
  const std::size_t first = part_of_.size();
  const int count = static_cast<int>(info_.size() - first);
  if (count == 0) return;
  part_of_.resize(info_.size(), static_cast<int>(parts_.size()));
  parts_.push_back({kind, item, static_cast<int>(first), count, needs});
}

Channels::Channels(const Compiled& m) : model_(m), draws_ground_(draws_ground(m.spec())), joints_(m) {
  for (const BodyData& b : m.bodies)
    if (b.modes > 0) modes_ += m.flexible[b.flexible].modes;
  add_outputs();
  add_joints();
  add_elements();
  for (std::size_t k = 0; k < m.constraints.size(); ++k) {
    add_constraint_info(m, m.constraints[k], info_);
    close_part(Part::Kind::constraint, static_cast<int>(k), Needs::reactions);
  }
  for (std::size_t k = 0; k < m.spec().contacts.size(); ++k) {
    add_contact_info(m.spec().contacts[k], info_);
    close_part(Part::Kind::contact, static_cast<int>(k), Needs::forces);
  }
  add_signals();
  add_energy_info(info_);
  close_part(Part::Kind::energy, 0, Needs::motion);
  add_solver_info(info_);
  close_part(Part::Kind::solver, 0, Needs::motion);
  check_names(m.spec().outputs, info_);
}

void Channels::add_outputs() {
  for (const spec::Output& o : model_.spec().outputs) {
    const ObservedOutput& observed = outputs_.emplace_back(model_, o);
    info_.push_back(observed.info->describe(model_, o));
    close_part(Part::Kind::output, static_cast<int>(outputs_.size()) - 1, observed.info->needs);
  }
  output_count_ = static_cast<int>(info_.size());
}

void Channels::add_joints() {
  for (int j = 0; j < static_cast<int>(model_.spec().joints.size()); ++j) {
    joints_.add_motion_info(j, info_);
    close_part(Part::Kind::joint, j, Needs::motion);
    joints_.add_reaction_info(j, info_);
    close_part(Part::Kind::reaction, j, Needs::reactions);
  }
}

void Channels::add_elements() {
  const Compiled& m = model_;
  using Describe = void (*)(const Compiled&, int, std::vector<ChannelInfo>&);
  const auto add = [&](Part::Kind kind, Describe describe, int element) {
    describe(m, element, info_);
    close_part(kind, element, Needs::forces);
  };
  for (int k = 0; k < m.first_tyre; ++k) add(Part::Kind::spring, add_spring_info, k);
  for (int k = m.first_tyre; k < m.first_load; ++k) add(Part::Kind::tyre, add_tyre_info, k);
  for (int k = m.first_tyre; k < m.first_load; ++k)
    if (m.elements[k].measure == Measure::wheel) add(Part::Kind::wheel, add_wheel_info, k);
  for (int k = m.first_tyre; k < m.first_load; ++k) add(Part::Kind::road, add_road_info, k);
  for (int k = m.first_load; k < m.first_joint_spring; ++k) add(Part::Kind::load, add_load_info, k);
  for (int k = 0; k < static_cast<int>(m.spec().elements.size()); ++k)
    add(Part::Kind::element, add_element_info, m.first_other + k);
}

void Channels::add_signals() {
  const Compiled& m = model_;
  for (std::size_t k = 0; k < m.spec().inputs.size(); ++k) {
    add_input_info(m.spec().inputs[k], info_);
    close_part(Part::Kind::input, m.signals.slot_of_input[k], Needs::forces);
  }
  for (std::size_t k = 0; k < m.spec().signals.size(); ++k) {
    add_signal_info(m.spec().signals[k], info_);
    close_part(Part::Kind::signal, m.signals.slot_of_signal[k], Needs::forces);
  }
  for (std::size_t k = 0; k < m.spec().events.size(); ++k) {
    add_event_info(m.spec().events[k], info_);
    close_part(Part::Kind::event, static_cast<int>(k), Needs::motion);
  }
}

double Channels::value(const ObservedOutput& o, relative::RelativeSystem& system, const State& s) const {
  return o.info->value(ChannelView(joints_, o.bodies, system, s), *o.output);
}

void Channels::mark_undetermined(const Redundancy& redundancy) {
  const auto among = [&](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto mark = [&](const Part& part, const char* note) {
    for (int k = part.first; k < part.first + part.count; ++k) {
      ChannelInfo& channel = info_[static_cast<std::size_t>(k)];
      channel.meaning += note;
      channel.determined = false;
    }
  };
  const auto mark_joint = [&](const Part& part, int joint) {
    const std::string& name = model_.spec().joints[static_cast<std::size_t>(joint)].name;
    if (among(redundancy.joints, name) || among(redundancy.nearly_joints, name))
      mark(part, ", the smallest of those that redundant constraints leave open");
  };
  for (const Part& part : parts_) {
    if (part.kind == Part::Kind::reaction) mark_joint(part, part.item);
    if (part.kind == Part::Kind::constraint) {
      const int spec = model_.constraints[static_cast<std::size_t>(part.item)].spec;
      const std::string& name = model_.spec().constraints[static_cast<std::size_t>(spec)].name;
      if (among(redundancy.constraints, name) || among(redundancy.nearly_constraints, name))
        mark(part, ", one of those that redundant constraints leave open");
    }
    if (part.kind != Part::Kind::output) continue;
    const spec::Output& o = model_.spec().outputs[static_cast<std::size_t>(part.item)];
    if (output_info(o).of == OutputInfo::Of::joint && part.needs == Needs::reactions)
      mark_joint(part, o.item);
  }
}

void Channels::read(const Part& part, relative::RelativeSystem& system, const State& s,
                    const EnergyBalance& e, const Statistics& statistics, double* channels) const {
  using Kind = Part::Kind;
  const Compiled& m = model_;
  const auto& w = system.workspace();
  const auto data = [&]() -> const ElementData& { return m.elements[part.item]; };
  const auto element = [&] { return element_state(data(), w.elements.data()); };
  double* to = channels + part.first;
  switch (part.kind) {
    case Kind::output:
      *to = value(outputs_[static_cast<std::size_t>(part.item)], system, s);
      return;
    case Kind::joint:
      return joints_.read_motion(part.item, system, s, to);
    case Kind::reaction:
      return joints_.read_reaction(part.item, system, s, to);
    case Kind::spring:
      return read_spring(element(), to);
    case Kind::tyre:
      *to = -element().force[0];
      return;
    case Kind::wheel:
      return read_wheel(m, data(), element(), to);
    case Kind::road:
      *to = *element().surroundings;
      return;
    case Kind::load:
      return read_load(data(), element(), to);
    case Kind::contact:
      return read_contact(contact_sum(m, w, part.item), to);
    case Kind::element:
      return read_element(element(), to);
    case Kind::constraint:
      return read_constraint(m.constraints[static_cast<std::size_t>(part.item)], system, s, to);
    case Kind::input:
    case Kind::signal:
      *to = w.signals.value[part.item];
      return;
    case Kind::event:
      // Where there is no run, as at rest, none has happened.
      return read_event(
          statistics.events.empty() ? EventRecord() : statistics.events[static_cast<std::size_t>(part.item)],
          to);
    case Kind::energy:
      return read_energy(e, to);
    case Kind::solver:
      return read_solver(statistics, to);
  }
}

void Channels::sample(relative::RelativeSystem& system, const State& s, const EnergyBalance& e,
                      const Statistics& statistics, ResultsRow& row) const {
  row.channels.resize(static_cast<Eigen::Index>(info_.size()));
  for (const Part& part : parts_) read(part, system, s, e, statistics, row.channels.data());
  picture(system, s, row);
}

void Channels::picture(const relative::RelativeSystem& system, const State& s, ResultsRow& row) const {
  const Compiled& m = model_;
  const auto& w = system.workspace();
  row.time = s.time;
  row.poses.resize(7, static_cast<Eigen::Index>(m.spec().bodies.size()) + (draws_ground_ ? 1 : 0));
  if (draws_ground_) row.poses.rightCols<1>() << 0, 0, 0, 1, 0, 0, 0;
  row.modes.resize(modes_);
  Eigen::Index mode = 0;
  for (std::size_t k = 0; k < m.spec().bodies.size(); ++k) {
    const BodyData& b = m.bodies[m.body_of_spec[k]];
    const auto& motion = w.bodies[m.body_of_spec[k]];
    row.poses.col(static_cast<Eigen::Index>(k)).head<3>() = motion.position + w.origin;
    row.poses.col(static_cast<Eigen::Index>(k)).tail<4>() = quaternion_of(motion.rotation);
    if (b.modes == 0) continue;
    const FlexibleData& f = m.flexible[b.flexible];
    for (int i = 0; i < b.modes; ++i) row.modes[mode + i] = s.q[b.q + b.joint_positions + i];
    extend(f, row.modes.data() + mode);
    mode += f.modes;
  }
}

std::vector<RoadDrawing> Channels::roads() const {
  std::vector<RoadDrawing> roads;
  for (const spec::Road& road : model_.spec().roads) {
    if (road.over != spec::Road::Over::distance) continue;
    const int count = 2000;
    RoadDrawing drawing{road.name, Eigen::Matrix2Xd(2, count + 1)};
    for (int k = 0; k <= count; ++k) {
      const double x = road.draw_from + (road.draw_to - road.draw_from) * k / count;
      drawing.profile.col(k) << x, road.height.value(x);
    }
    roads.push_back(std::move(drawing));
  }
  return roads;
}

}  // namespace mimbre
