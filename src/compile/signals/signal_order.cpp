#include "compile/signals/signal_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "compile/signals/compile_blocks.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

template <class Items>
auto& of(Items& items, int index) {
  return items[static_cast<std::size_t>(index)];
}

const std::string& name_of(const spec::Model& m, const SignalNode& n) {
  return n.is_block ? of(m.blocks, n.index).name : of(m.signals, n.index).name;
}

/// One attempt, with the blocks that are known to close loops.
class Attempt {
 public:
  Attempt(const spec::Model& model, const std::vector<char>& ahead)
      : m_(model),
        ahead_(ahead),
        state_{std::vector<int>(model.signals.size(), 0), std::vector<int>(model.blocks.size(), 0)} {}

  /// False where there is a loop, then in `loop`.
  bool run() {
    for (int k = 0; k < static_cast<int>(m_.signals.size()); ++k)
      if (of(m_.signals, k).block < 0 && !(of(m_.signals, k).every > 0) && !visit({false, k})) return false;
    for (const bool last : {false, true})
      for (int k = 0; k < static_cast<int>(m_.blocks.size()); ++k)
        if (!(of(m_.blocks, k).every > 0) && (of(ahead_, k) != 0) == last && !visit({true, k})) return false;
    return true;
  }

  std::vector<SignalNode> order, loop;

 private:
  bool visit(const SignalNode& node) {
    int& state = of(state_[node.is_block ? 1 : 0], node.index);
    if (state == 2) return true;
    if (state == 1) {
      loop.assign(std::find(path_.begin(), path_.end(), node), path_.end());
      return false;
    }
    state = 1;
    path_.push_back(node);
    for (const spec::Source& source : sources_of(m_, node))
      if (SignalNode by{};
          is_made_within_a_step(m_, source, by) && !(by.is_block && of(ahead_, by.index)) && !visit(by))
        return false;
    path_.pop_back();
    state = 2;
    order.push_back(node);
    return true;
  }

  const spec::Model& m_;
  const std::vector<char>& ahead_;
  std::vector<int> state_[2];
  std::vector<SignalNode> path_;
};

using NodeMarks = std::array<std::vector<char>, 2>;  ///< of signals, of blocks

NodeMarks no_marks(const spec::Model& m) {
  return {std::vector<char>(m.signals.size(), 0), std::vector<char>(m.blocks.size(), 0)};
}

/// Sets a node's mark and returns what it was.
bool mark(NodeMarks& marks, const SignalNode& n) {
  return std::exchange(of(marks[n.is_block ? 1 : 0], n.index), 1) != 0;
}

/// Puts behind `found` what is evaluated at instants and that a node takes, by way of continuous ones.
void add_sampled_sources(const spec::Model& m, const SignalNode& node, NodeMarks& seen,
                         std::vector<SignalNode>& found) {
  for (const spec::Source& source : sources_of(m, node)) {
    if (source.kind != spec::Source::Kind::signal) continue;
    SignalNode by{};
    const bool continuous = is_made_within_a_step(m, source, by);
    if (mark(seen, by)) continue;
    if (continuous)
      add_sampled_sources(m, by, seen, found);
    else
      found.push_back(by);
  }
}

void put_behind_sources(const spec::Model& m, const SignalNode& node, NodeMarks& visited,
                        std::vector<SignalNode>& order) {
  if (mark(visited, node)) return;
  NodeMarks seen = no_marks(m);
  std::vector<SignalNode> sources;
  add_sampled_sources(m, node, seen, sources);
  for (const SignalNode& source : sources) put_behind_sources(m, source, visited, order);
  order.push_back(node);
}

}  // namespace

std::vector<SignalNode> order_sampled(const spec::Model& m, const std::vector<SignalNode>& sampled) {
  NodeMarks visited = no_marks(m);
  std::vector<SignalNode> order;
  for (const SignalNode& node : sampled) put_behind_sources(m, node, visited, order);
  return order;
}

std::vector<spec::Source> sources_of(const spec::Model& m, const SignalNode& node) {
  if (!node.is_block) return of(m.signals, node.index).law.arguments;
  std::vector<spec::Source> all;
  for (const spec::Law& input : of(m.blocks, node.index).inputs)
    all.insert(all.end(), input.arguments.begin(), input.arguments.end());
  return all;
}

bool is_made_within_a_step(const spec::Model& m, const spec::Source& source, SignalNode& by) {
  if (source.kind != spec::Source::Kind::signal) return false;
  const spec::Signal& signal = of(m.signals, source.index);
  by = signal.block >= 0 ? SignalNode{true, signal.block} : SignalNode{false, source.index};
  return !(signal.block >= 0 ? of(m.blocks, signal.block).every > 0 : signal.every > 0);
}

SignalOrder order_signals(const spec::Model& m) {
  SignalOrder found;
  found.ahead.assign(m.blocks.size(), 0);
  while (true) {
    Attempt attempt(m, found.ahead);
    if (attempt.run()) {
      found.nodes = std::move(attempt.order);
      return found;
    }
    const auto closes = std::find_if(attempt.loop.begin(), attempt.loop.end(), [&](const SignalNode& n) {
      return n.is_block && !feeds_through(of(m.blocks, n.index));
    });
    if (closes != attempt.loop.end()) {
      of(found.ahead, closes->index) = 1;
      continue;
    }
    std::string names;
    for (const SignalNode& n : attempt.loop) names += fmt::format("'{}' → ", name_of(m, n));
    const SignalNode& first = attempt.loop.front();
    throw InputError(
        first.is_block ? of(m.blocks, first.index).mark : of(m.signals, first.index).mark,
        fmt::format("signals depend on each other in a circle, without a state or delay: {}'{}'; "
                    "evaluate one of them at instants, `every: 0.01`, or put a delay or a filter "
                    "between",
                    names, name_of(m, first)));
  }
}

}  // namespace mimbre
