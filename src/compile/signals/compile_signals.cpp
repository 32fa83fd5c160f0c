#include "compile/signals/compile_signals.h"

#include <fmt/format.h>

#include <algorithm>

#include "compile/signals/compile_blocks.h"
#include "compile/signals/signal_order.h"
#include "mimbre/diagnostics.h"
#include "spec/force_law.h"
#include "spec/output_kind.h"

namespace mimbre {
namespace {

using Source = spec::Source;

class Planner {
 public:
  explicit Planner(Compiled& c) : c_(c), s_(c.spec()), d_(c.signals) {}

  void run() {
    d_.slot_of_signal.assign(s_.signals.size(), -1);
    d_.slot_of_sensor.assign(s_.sensors.size(), -1);
    for (std::size_t k = 0; k < s_.inputs.size(); ++k) input(static_cast<int>(k));
    for (std::size_t k = 0; k < s_.signals.size(); ++k)
      if (s_.signals[k].block < 0 && s_.signals[k].every > 0) sampled(static_cast<int>(k));
    for (std::size_t k = 0; k < s_.blocks.size(); ++k) block(static_cast<int>(k));
    order_ = order_signals(s_);
    find_moving();
    find_smooth();
    for (const SignalNode& node : order_.nodes)
      if (!moves(node)) make(node, d_.fixed, d_.fixed_loops);
    functions_of_time();
    d_.first_moving = d_.slots;
    const auto see = [&](const std::vector<Source>& arguments, const std::string& who, const Mark& mark) {
      for (const Source& a : arguments)
        if (a.kind == Source::Kind::sensor) sense(a.index, who, mark);
    };
    for (const SignalNode& node : order_.nodes) {
      const std::string& name = node.is_block ? s_.blocks[node.index].name : s_.signals[node.index].name;
      see(sources_of(s_, node), fmt::format("signal '{}'", name),
          node.is_block ? s_.blocks[node.index].mark : s_.signals[node.index].mark);
    }
    for (const spec::Spring& spring : s_.springs)
      see(spring.general.arguments, fmt::format("spring '{}'", spring.name), spring.mark);
    for (const spec::Joint& joint : s_.joints)
      for (const spec::JointSpring& spring : joint.springs)
        see(spring.general.arguments, fmt::format("the spring of joint '{}'", joint.name), joint.mark);
    for (const spec::Element& e : s_.elements)
      for (const auto* arguments : {&e.arguments, &e.general.arguments})
        see(*arguments, fmt::format("{} '{}'", e.law, e.name), e.mark);
    for (const SignalNode& node : order_.nodes)
      if (moves(node)) make(node, d_.moving, d_.moving_loops);
    for (const Pending& made : pending_) (*made.list)[made.at].law = within_a_step(*made.law);
    for (std::size_t k = 0; k < d_.sampled.size(); ++k)
      for (const spec::Law* law : sampled_laws_[k]) d_.sampled[k].inputs.push_back(seen_of(c_, *law));
    put_sampled_in_order();
    for (std::size_t k = 0; k < s_.blocks.size(); ++k)
      for (const spec::Law& input : s_.blocks[k].inputs)
        if (!(s_.blocks[k].every > 0)) d_.blocks[k].laws.push_back(within_a_step(input));
  }

 private:
  int hold(std::initializer_list<double> values) {
    const int first = static_cast<int>(d_.start.size());
    d_.start.append(values.begin(), values.end());
    return first;
  }

  void input(int k) {
    const spec::Input& i = s_.inputs[k];
    const bool linear = i.hold == spec::Input::Hold::linear;
    d_.slot_of_input.push_back(d_.slots);
    d_.held.push_back(
        {d_.slots++, linear ? hold({i.start, 0, i.start, 0}) : hold({i.start, -1e300}), linear, k});
  }

  /// Slots of values that are evaluated at instants, of the laws of what they are made of.
  void sampled_values(int values, double every, int block, std::vector<const spec::Law*> laws) {
    const int held = static_cast<int>(d_.start.size());
    for (int k = 0; k < values; ++k) d_.held.push_back({d_.slots++, hold({0}), false, -1});
    hold({0, 0});
    d_.sampled.push_back({held, values, every, block, {}});
    sampled_laws_.push_back(std::move(laws));
  }

  void put_sampled_in_order() {
    Array<SignalsData::Sampled> ordered;
    for (const SignalNode& node : order_sampled(s_, sampled_))
      ordered.push_back(
          std::move(d_.sampled[std::find(sampled_.begin(), sampled_.end(), node) - sampled_.begin()]));
    d_.sampled = std::move(ordered);
  }

  void sampled(int k) {
    const spec::Signal& s = s_.signals[k];
    d_.slot_of_signal[k] = d_.slots;
    sampled_.push_back({false, k});
    sampled_values(1, s.every, -1, {&s.law});
  }

  void block(int k) {
    const spec::Block& s = s_.blocks[k];
    SignalsData::Block b = compile_block(s, s_.simulation.step, d_);
    b.slot = -1;
    if (s.every > 0) {
      b.slot = d_.slots;
      std::vector<const spec::Law*> laws;
      for (const spec::Law& input : s.inputs) laws.push_back(&input);
      sampled_.push_back({true, k});
      sampled_values(b.outputs, s.every, k, std::move(laws));
      give_outputs(k, b.slot);
    } else if (d_.clock < 0) {
      d_.clock = hold({0, 0});
    }
    b.held = static_cast<int>(d_.start.size());
    d_.start.resize(d_.start.size() + static_cast<std::size_t>(b.memory()), 0.0);
    d_.blocks.push_back(std::move(b));
  }

  /// The signals that are a block's outputs have the slots from there on.
  void give_outputs(int block, int slot) {
    for (std::size_t k = 0; k < s_.signals.size(); ++k)
      if (s_.signals[k].block == block) d_.slot_of_signal[k] = slot + s_.signals[k].output;
  }

  LawData within_a_step(const spec::Law& law) const {
    LawData data{law.formula.data(), {}};
    for (const Source& a : law.arguments) data.slots.push_back(slot_of(c_, a));
    return data;
  }

  char& of(std::array<std::vector<char>, 2>& marks, const SignalNode& n) const {
    return marks[n.is_block ? 1 : 0][static_cast<std::size_t>(n.index)];
  }
  bool moves(const SignalNode& n) { return of(moving_, n) != 0; }

  /// Sets marks until those of all nodes agree with `rule`, of a node and what its sources have.
  template <class Rule>
  void spread(std::array<std::vector<char>, 2>& marks, const Rule& rule) {
    marks = {std::vector<char>(s_.signals.size(), 0), std::vector<char>(s_.blocks.size(), 0)};
    for (bool changed = true; changed;) {
      changed = false;
      for (const SignalNode& node : order_.nodes) {
        bool any = false;
        for (const Source& a : sources_of(s_, node))
          if (SignalNode by{}; is_made_within_a_step(s_, a, by)) any = any || of(marks, by);
        if (char& mark = of(marks, node); !mark && (any || rule(node))) mark = changed = true;
      }
    }
  }

  void find_moving() {
    spread(moving_, [&](const SignalNode& node) {
      const std::vector<Source> sources = sources_of(s_, node);
      return std::any_of(sources.begin(), sources.end(),
                         [](const Source& a) { return a.kind == Source::Kind::sensor; });
    });
  }

  void find_smooth() {
    spread(rough_,
           [&](const SignalNode& node) { return node.is_block && !is_smooth(s_.blocks[node.index]); });
  }

  void make(const SignalNode& node, Array<SignalsData::Computed>& list, bool& loops) {
    if (node.is_block) {
      SignalsData::Block& b = d_.blocks[node.index];
      b.slot = d_.slots;
      b.ahead = order_.ahead[static_cast<std::size_t>(node.index)] != 0;
      loops = loops || b.ahead;
      d_.slots += b.outputs;
      give_outputs(node.index, b.slot);
      list.push_back({b.slot, {}, node.index});
      return;
    }
    d_.slot_of_signal[node.index] = d_.slots;
    list.push_back({d_.slots++, {}, -1});
    pending_.push_back({&list, list.size() - 1, &s_.signals[node.index].law});
  }

  void sense(int sensor, const std::string& who, const Mark& mark) {
    if (d_.slot_of_sensor[sensor] >= 0) return;
    const spec::Output& o = s_.sensors[sensor];
    if (!output_info(o).place_sensor) {
      // What a signal measures by itself has no other name.
      const std::string use = who == fmt::format("signal '{}'", o.name)
                                  ? fmt::format("measures `{}`", o.kind)
                                  : fmt::format("uses '{}' (`{}`)", o.name, o.kind);
      throw InputError(mark, fmt::format("{} {}, which forces decide at the same instant; evaluate it at "
                                         "instants by a signal with `every: 0.01`",
                                         who, use));
    }
    d_.slot_of_sensor[sensor] = d_.slots;
    d_.sensors.push_back({d_.slots++, static_cast<int>(d_.sensors.size())});
    seen_.push_back(sensor);
  }

  int of_time(const Function& f) {
    d_.of_time.push_back({d_.slots, f.data()});
    return d_.slots++;
  }

  /// Slot of a signal that motion must not decide. `derived`: its derivatives by time are needed.
  int fixed_signal(int signal, const std::string& who, bool derived) {
    const spec::Signal& s = s_.signals[signal];
    SignalNode node{};
    if (is_made_within_a_step(s_, {Source::Kind::signal, signal}, node)) {
      if (moves(node))
        throw InputError(
            s.mark, fmt::format("{} follows signal '{}', which depends on the motion at the same instant; "
                                "give the signal `every: 0.01`, or use an actuator",
                                who, s.name));
      if (derived && of(rough_, node))
        throw InputError(s.mark,
                         fmt::format("{} follows signal '{}', whose rate is not known; send it through a "
                                     "transfer_function",
                                     who, s.name));
    }
    return d_.slot_of_signal[signal];
  }

  void functions_of_time() {
    for (const spec::Load& l : s_.loads) d_.slot_of_load.push_back(l.signal >= 0 ? -1 : of_time(l.scale));
    for (const spec::Road& r : s_.roads)
      d_.slot_of_road.push_back(r.over != spec::Road::Over::time ? -1
                                : r.signal >= 0
                                    ? fixed_signal(r.signal, fmt::format("road '{}'", r.name), false)
                                    : of_time(r.height));
    for (const spec::Joint& joint : s_.joints) {
      d_.slot_of_drive.emplace_back();
      for (const spec::Drive& drive : joint.drives) d_.slot_of_drive.back().push_back(driven(joint, drive));
    }
  }

  int driven(const spec::Joint& joint, const spec::Drive& drive) {
    const auto k = static_cast<std::size_t>(drive.coordinate);
    const double start = k < joint.initial_position.size() ? joint.initial_position[k].value_or(0) : 0;
    const bool position = drive.of == spec::Drive::Of::position;
    if (drive.signal < 0)
      // A run may be longer than in the file: what is prepared reaches over four times that.
      return of_time(position ? drive.law : drive.law.integral(start, 4 * s_.simulation.end));
    const int signal = fixed_signal(drive.signal, fmt::format("the drive of joint '{}'", joint.name), true);
    if (position) return signal;
    d_.integrals.push_back({d_.slots, signal, hold({start, 0})});
    return d_.slots++;
  }

  Compiled& c_;
  const spec::Model& s_;
  SignalsData& d_;
  SignalOrder order_;
  std::array<std::vector<char>, 2> moving_, rough_;  ///< by signal, by block
  std::vector<SignalNode> sampled_;
  std::vector<std::vector<const spec::Law*>> sampled_laws_;  ///< of each
  /// Formulas in lists, which get their slots when all have them.
  struct Pending {
    Array<SignalsData::Computed>* list;
    std::size_t at;
    const spec::Law* law;
  };
  std::vector<Pending> pending_;

 public:
  std::vector<int> seen_;  ///< sensors of the spec
};

}  // namespace

void plan_signals(Compiled& c) {
  Planner planner(c);
  planner.run();
  c.signals.seen = std::move(planner.seen_);
}

std::vector<int> seen_within_a_step(const Compiled& c) {
  return {c.signals.seen.begin(), c.signals.seen.end()};
}

bool is_of_frame(const spec::Output& sensor) {
  const OutputInfo& info = output_info(sensor);
  return info.of == OutputInfo::Of::frame && !info.along;
}

int slot_of(const Compiled& c, const Source& source) {
  switch (source.kind) {
    case Source::Kind::time:
      return 0;
    case Source::Kind::input:
      return c.signals.slot_of_input[source.index];
    case Source::Kind::signal:
      return c.signals.slot_of_signal[source.index];
    case Source::Kind::sensor:
      return c.signals.slot_of_sensor[source.index];
  }
  return 0;
}

SignalsData::Seen seen_of(const Compiled& c, const spec::Law& law) {
  SignalsData::Seen seen{law.formula.data(), {}};
  for (const Source& a : law.arguments)
    seen.arguments.push_back(
        {a.kind == Source::Kind::sensor ? -1 : slot_of(c, a), a.kind == Source::Kind::sensor ? a.index : -1});
  return seen;
}

int load_slot(const Compiled& c, int load) {
  const int signal = c.spec().loads[load].signal;
  return signal >= 0 ? c.signals.slot_of_signal[signal] : c.signals.slot_of_load[load];
}

int drive_slot(const Compiled& c, int joint, int drive) { return c.signals.slot_of_drive[joint][drive]; }

void place_roads(Compiled& c) {
  for (std::size_t k = 0; k < c.roads.size(); ++k) c.roads[k].slot = c.signals.slot_of_road[k];
}

int add_formula(Compiled& c, const spec::Law& law) {
  if (law.formula.is_zero()) return -1;
  LawData data{law.formula.data(), {}};
  for (const Source& a : law.arguments) data.slots.push_back(slot_of(c, a));
  c.formulas.push_back(std::move(data));
  return static_cast<int>(c.formulas.size()) - 1;
}

int add_argument(Compiled& c, int slot) {
  c.arguments.push_back(slot);
  return static_cast<int>(c.arguments.size()) - 1;
}

int SensorPlaces::of_coordinate(int joint, int coordinate) const {
  const auto same = [&](const ElementData& e) {
    return e.measure == Measure::coordinate && e.joint_spec == joint && e.local == coordinate;
  };
  const auto found = std::find_if(compiled.elements.begin(), compiled.elements.end(), same);
  if (found != compiled.elements.end()) return static_cast<int>(found - compiled.elements.begin());
  ElementData e = on_coordinate(joint, coordinate);
  e.law = find_law("sensor");
  return add_element(std::move(e));
}

void place_sensors(Compiled& c, const std::function<int(ElementData)>& add_element,
                   const std::function<ElementData(int joint, int coordinate)>& on_coordinate) {
  const SensorPlaces places{c, add_element, on_coordinate};
  for (const int sensor : c.signals.seen) {
    const spec::Output& o = c.spec().sensors[sensor];
    SensorData d;
    d.kind = find_output(o.kind);
    d.component = o.component;
    d.own_axes = o.own_axes;
    d.direction = o.direction;
    d.offset = o.offset;
    output_info(o).place_sensor(places, o, d);
    c.sensors.push_back(std::move(d));
  }
}

}  // namespace mimbre
