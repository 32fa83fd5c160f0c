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
    for (const Phase& phase : recorded.program.phases) {
      // Of a state at rest: what it says, and the signals. Without blocks these are the same as in a step.
      const bool looks = !(recorded.blocks && phase.name.ends_with("_step")) &&
                         (phase.name == "origin" || phase.name == "motion" ||
                          phase.name.starts_with("signals_") || phase.name.starts_with("sense_"));
      for (const Store& store : phase.stores)
        if (looks) stores_[{store.to, store.at}].push_back(store.value.node);
    }
  }

  std::vector<int> inputs_behind(int node) {
    seen_.clear();
    found_.clear();
    by_acceleration_ = false;
    wait_.assign(1, node);
    while (!wait_.empty()) {
      const int next = wait_.back();
      wait_.pop_back();
      if (next >= 0 && seen_.insert(next).second) look(nodes_[static_cast<std::size_t>(next)]);
    }
    return {found_.begin(), found_.end()};
  }
  bool acceleration_behind(int node) {
    inputs_behind(node);
    return by_acceleration_;
  }

 private:
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
        wait_.push_back(node.a);
        wait_.push_back(node.b);
        return;
      default:
        wait_.insert(wait_.end(), {node.a, node.b, node.c});
    }
  }
  void read(Memory memory, int at) {
    by_acceleration_ = by_acceleration_ || memory == Memory::a || memory == Memory::multipliers;
    if (memory == Memory::held) {
      for (const SignalsData::HeldInput& h : signals_.held)
        if (h.input >= 0 && at >= h.held && at < h.held + (h.linear ? 4 : 2)) found_.insert(h.input);
      return;
    }
    const auto made = stores_.find({memory, at});
    if (made != stores_.end()) wait_.insert(wait_.end(), made->second.begin(), made->second.end());
  }

  const std::vector<Recording::Node>& nodes_;
  const SignalsData& signals_;
  std::map<std::pair<Memory, int>, std::vector<int>> stores_;
  std::set<int> seen_, found_;
  std::vector<int> wait_;
  bool by_acceleration_ = false;
};

/// Calls f with each store of all phases.
template <class F>
void for_stores(const RecordedModel& recorded, const F& f) {
  for (const Phase& phase : recorded.program.phases)
    for (const Store& store : phase.stores) f(store);
}

}  // namespace

std::vector<std::vector<int>> inputs_of_outputs(const RecordedModel& recorded, const SignalsData& signals) {
  Search search(recorded, signals);
  std::vector<std::vector<int>> inputs(recorded.outputs.size());
  for_stores(recorded, [&](const Store& store) {
    if (store.to == Memory::output)
      inputs[static_cast<std::size_t>(store.at)] = search.inputs_behind(store.value.node);
  });
  return inputs;
}

std::vector<bool> outputs_by_acceleration(const RecordedModel& recorded, const SignalsData& signals) {
  Search search(recorded, signals);
  std::vector<bool> all(recorded.outputs.size());
  for_stores(recorded, [&](const Store& store) {
    if (store.to == Memory::output)
      all[static_cast<std::size_t>(store.at)] = search.acceleration_behind(store.value.node);
  });
  return all;
}

std::vector<int> equations_of_inputs(const RecordedModel& recorded, const SignalsData& signals) {
  Search search(recorded, signals);
  std::set<int> equations;
  for_stores(recorded, [&](const Store& store) {
    const bool equation =
        store.to == Memory::phi || store.to == Memory::phi_dot || store.to == Memory::phi_ddot;
    if (equation && !search.inputs_behind(store.value.node).empty()) equations.insert(store.at);
  });
  return {equations.begin(), equations.end()};
}

bool signals_see_accelerations(const RecordedModel& recorded, const SignalsData& signals) {
  Search search(recorded, signals);
  bool any = false;
  for_stores(recorded, [&](const Store& store) {
    if (store.to == Memory::slot) any = any || search.acceleration_behind(store.value.node);
  });
  return any;
}

}  // namespace mimbre::portable
