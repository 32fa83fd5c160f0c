#pragma once
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// A signal by a formula, or a block: what is made in every evaluation of a step.
struct SignalNode {
  bool is_block;
  int index;  ///< in spec::Model
  bool operator==(const SignalNode&) const = default;
};

struct SignalOrder {
  std::vector<SignalNode> nodes;  ///< each behind those that it needs
  /// By block: it closes a loop, so that what it makes is used before it is made. None of these feeds
  /// through.
  std::vector<char> ahead;
};

/// What it takes.
std::vector<spec::Source> sources_of(const spec::Model& model, const SignalNode& node);
/// What makes a source in an evaluation; none for inputs, sensors, the time, and what is sampled.
bool is_made_within_a_step(const spec::Model& model, const spec::Source& source, SignalNode& by);

/// Throws InputError, with the names, where signals need each other in a circle without a state or a delay.
SignalOrder order_signals(const spec::Model& model);

/// What is evaluated at instants, each behind those that it takes, by way of continuous signals too: at one
/// instant a chain of them has no delay. In a circle the first of `sampled` comes last; what it takes is made
/// of its value of the instant before.
std::vector<SignalNode> order_sampled(const spec::Model& model, const std::vector<SignalNode>& sampled);

}  // namespace mimbre
