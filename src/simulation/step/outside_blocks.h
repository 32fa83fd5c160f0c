#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/state.h"
#include "mimbre/outside_block.h"

namespace mimbre {

/// The blocks of a simulation that are computed by code from elsewhere: an instance each, made with it, so
/// that what cannot be loaded is refused before the run.
class OutsideBlocks {
 public:
  /// Throws InputError.
  OutsideBlocks(const Compiled& model, double step);
  bool none() const { return blocks_.empty(); }

  /// The block `block` of the spec at the state's time. `made`: when it was called before. False where it
  /// fails: then failure() has the reason, and the state is as it was.
  bool exchange(const SignalsData::Sampled& sampled, const double* in, double made, State& state,
                double* out);
  const std::string& failure() const { return failure_; }
  void forget_failure() { failure_.clear(); }

  /// As Simulation::not_saved().
  std::string not_saved() const;
  std::vector<std::string> warnings() const;

  /// The states of all of them, as numbers of eight bytes.
  std::vector<double> save() const;
  /// Throws InputError where the block is not one of save() of these blocks, or has no state of one that had
  /// begun.
  void check(std::span<const double> states) const;
  /// Goes on from it; checked. Throws InputError where a block refuses its state.
  void restore(std::span<const double> states);
  /// All of them begin anew with the next instant; `state` knows of that.
  void restart(State& state);

 private:
  struct Block {
    const spec::Block* spec;
    int index;  ///< of the spec
    int held;   ///< SignalsData::Block::held
    std::unique_ptr<OutsideInstance> instance;
    bool begun = false, failed = false;
  };
  void make_anew(Block& block);

  const Compiled& model_;
  std::vector<Block> blocks_;
  std::string failure_;
};

}  // namespace mimbre
