#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "simulation/observe/channels.h"
#include "simulation/step/outside_blocks.h"

/// What the state keeps of inputs, sampled signals and force elements, from step to step.
namespace mimbre {

/// The number of an input or a tunable parameter. Throws InputError where there is none.
int find_input(const Compiled& model, const std::string& name);

/// Laws at their start values, and inputs, but for those given (RunOptions::inputs).
void start_signals(const Compiled& model, const std::map<std::string, double>& inputs, State& state);

/// After a step, or at the start: the system's last forces are of this state. Takes over the states of force
/// elements at its end, and moves integrals of signals on.
void commit_signals(const Compiled& model, const relative::RelativeSystem& system, State& state);

/// The part of that of laws that take signals, but for users' laws: before a step, where signals have jumped.
void commit_signalled_laws(const Compiled& model, const relative::RelativeSystem& system, State& state);

/// The part of that of continuous blocks: their states, and their inputs of now. Also by itself, before a
/// step, where inputs have jumped since then.
void commit_blocks(const Compiled& model, const relative::RelativeSystem& system, State& state);
bool inputs_jumped(const Compiled& model, const State& state);

/// Sets an input, kept in its range: at once, or on a straight line that ends a step later.
void set_held_input(const Compiled& model, int input, double value, double step, State& state);
/// Its value at the state's time.
double held_input_value(const Compiled& model, int input, const State& state);

/// A formula of signals and of anything that outputs show.
class Seen {
 public:
  Seen(const Compiled& model, SignalsData::Seen data);
  /// After the system's residual of that state.
  double value(const Channels& channels, relative::RelativeSystem& system, const State& state) const;

 private:
  SignalsData::Seen data_;
  std::vector<std::optional<ObservedOutput>> sensors_;  ///< by argument; none: a slot
};

/// Evaluates signals at instants, and laws that are sampled.
class Sampler {
 public:
  /// Throws InputError where something is due more often than there are steps of that length, s, and where a
  /// block from elsewhere cannot be loaded.
  Sampler(const Compiled& model, double step);
  bool none() const { return signals_.empty() && laws_.empty(); }
  /// Before a step of that length: what is due is evaluated from the system's last residual, which is of
  /// `seen`, and kept in `state`; what takes another signal that is due takes its new value. Allocates
  /// nothing that the outputs that it sees do not, nor blocks from elsewhere. False where one of these fails.
  bool sample(const Channels& channels, relative::RelativeSystem& system, const State& seen, double step,
              State& state);
  OutsideBlocks& outside() { return outside_; }
  const OutsideBlocks& outside() const { return outside_; }

 private:
  struct Signal {
    const SignalsData::Sampled* data;
    std::vector<Seen> inputs;
    bool chained;  ///< it takes another
  };
  void make_block(const SignalsData::Sampled& signal, const double* in, double made, State& state,
                  double* out);

  const Compiled& model_;
  std::vector<Signal> signals_;
  std::vector<int> laws_;  ///< elements
  OutsideBlocks outside_;
};

}  // namespace mimbre
