#include "portable/dependencies.h"

#include <map>
#include <set>
#include <utility>

namespace mimbre::portable {
namespace {

/// Follows values back through the operations, and through what phases hand to later ones.
class Search {
 public:
  Search(const RecordedModel& recorded, const SignalsData& signals)
      : nodes_(recorded.program.recording.nodes()), signals_(signals) {
    for (const SignalsData::HeldInput& h : signals.held)
      if (h.linear) times_.insert({h.held + 1, h.held + 3});
    for (const SignalsData::Integral& i : signals.integrals) times_.insert(i.held + 1);
    for (const Phase& phase : recorded.program.phases) {
      // Of a state at rest: its motion, and the signals. Without blocks these are the same as in a step.
      const bool looks = !(recorded.blocks && phase.name.ends_with("_step")) &&
                         (phase.name == "origin" || phase.name == "motion" ||
                          phase.name.starts_with("signals_") || phase.name.starts_with("sense_"));
      for (const Store& store : phase.stores)
        if (looks) stores_[{store.to, store.at}].push_back(store.value.node);
    }
  }

  Dependencies behind(int node) {
    seen_.clear();
    inputs_.clear();
    found_ = {};
    wait_.assign(1, node);
    while (!wait_.empty()) {
      const int next = wait_.back();
      wait_.pop_back();
      if (next >= 0 && seen_.insert(next).second) look(nodes_[static_cast<std::size_t>(next)]);
    }
    found_.inputs.assign(inputs_.begin(), inputs_.end());
    return found_;
  }

 private:
  bool is_input(int node, Memory memory) const {
    const Recording::Node* n = node < 0 ? nullptr : &nodes_[static_cast<std::size_t>(node)];
    return n && n->op == Recording::Op::input && static_cast<Memory>(n->b) == memory;
  }
  /// Whether a node compares the time with the time from which a value is held: both are those of now.
  bool is_age(const Recording::Node& node) const {
    const auto is = [&](int time, int held) {
      return is_input(time, Memory::time) && is_input(held, Memory::held) &&
             times_.contains(nodes_[static_cast<std::size_t>(held)].a);
    };
    return is(node.a, node.b) || is(node.b, node.a);
  }
  void look(const Recording::Node& node) {
    using Op = Recording::Op;
    switch (node.op) {
      case Op::constant:
        return;
      case Op::input:
        read(static_cast<Memory>(node.b), node.a);
        return;
      case Op::part:
        wait_.push_back(node.a);
        return;
      case Op::call:
        wait_.insert(wait_.end(), {node.a, node.b, node.d});
        return;
      default:
        if (!is_age(node)) wait_.insert(wait_.end(), {node.a, node.b, node.c});
    }
  }
  void read_held(int at) {
    for (const SignalsData::HeldInput& h : signals_.held) {
      if (at < h.held || at >= h.held + (h.linear ? 4 : 2)) continue;
      if (h.input >= 0) inputs_.insert(h.input);
      return;
    }
    found_.memory = true;
  }
  void read(Memory memory, int at) {
    found_.acceleration = found_.acceleration || memory == Memory::a || memory == Memory::multipliers;
    found_.motion = found_.motion || memory == Memory::q || memory == Memory::v;
    found_.time = found_.time || memory == Memory::time || memory == Memory::delayed;
    found_.memory = found_.memory || memory == Memory::states || memory == Memory::delayed ||
                    memory == Memory::event_count || memory == Memory::event_time;
    if (memory == Memory::held) return read_held(at);
    const auto made = stores_.find({memory, at});
    if (made != stores_.end()) wait_.insert(wait_.end(), made->second.begin(), made->second.end());
  }

  const std::vector<Recording::Node>& nodes_;
  const SignalsData& signals_;
  std::map<std::pair<Memory, int>, std::vector<int>> stores_;
  std::set<int> times_;  ///< where times are held
  std::set<int> seen_, inputs_;
  std::vector<int> wait_;
  Dependencies found_;
};

/// Calls f with each store of all phases.
template <class F>
void for_stores(const RecordedModel& recorded, const F& f) {
  for (const Phase& phase : recorded.program.phases)
    for (const Store& store : phase.stores) f(store);
}

}  // namespace

std::vector<Dependencies> dependencies_of_outputs(const RecordedModel& recorded, const SignalsData& signals) {
  Search search(recorded, signals);
  std::vector<Dependencies> all(recorded.outputs.size());
  bool driven = false;  // dependent positions follow from the states and the time
  for_stores(recorded, [&](const Store& store) {
    if (store.to == Memory::output) all[static_cast<std::size_t>(store.at)] = search.behind(store.value.node);
    if (store.to == Memory::phi) driven = driven || search.behind(store.value.node).time;
  });
  const bool instant = recorded.program.sizes[static_cast<std::size_t>(Memory::mass)] > 0;
  for (Dependencies& d : all) d.time = d.time || (instant && driven && d.motion);
  return all;
}

std::vector<int> equations_of_inputs(const RecordedModel& recorded, const SignalsData& signals) {
  Search search(recorded, signals);
  std::set<int> equations;
  for_stores(recorded, [&](const Store& store) {
    const bool equation =
        store.to == Memory::phi || store.to == Memory::phi_dot || store.to == Memory::phi_ddot;
    if (equation && !search.behind(store.value.node).inputs.empty()) equations.insert(store.at);
  });
  return {equations.begin(), equations.end()};
}

bool signals_see_accelerations(const RecordedModel& recorded, const SignalsData& signals) {
  Search search(recorded, signals);
  bool any = false;
  for_stores(recorded, [&](const Store& store) {
    if (store.to == Memory::slot) any = any || search.behind(store.value.node).acceleration;
  });
  return any;
}

}  // namespace mimbre::portable
