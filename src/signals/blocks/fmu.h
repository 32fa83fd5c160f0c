#pragma once
#include "mimbre/outside_block.h"
#include "signals/blocks/block.h"

/// A block that an FMU computes (spec::Block::outside), at instants only. Its equations are not here: the
/// sampler calls it (simulation/step/outside_blocks.h). It has neither numbers nor states in the model's
/// image; its inputs at the last instant are kept as those of any block.
namespace mimbre::blocks {

struct Fmu {
  static int outputs(const spec::Block& b) { return b.outside ? b.outside->outputs() : 1; }
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    if (!b.outside) return item.error("has no FMU: set 'outside' (load_fmu)");
    if (b.outside->inputs() != std::ssize(b.inputs))
      item.error(fmt::format("has {} inputs, its FMU takes {}", b.inputs.size(), b.outside->inputs()));
    if (b.outside->inputs() > most_outside_values || b.outside->outputs() > most_outside_values)
      item.error(fmt::format("has {} inputs and {} outputs; up to {} of each are possible",
                             b.outside->inputs(), b.outside->outputs(), most_outside_values));
    if (b.outside->outputs() < 1) item.error("has no outputs");
  }
  static bool feeds_through(const spec::Block&) { return false; }

  static constexpr BlockInfo info{.name = "fmu",
                                  .key = "fmu",
                                  .inputs = -1,
                                  .named_outputs = true,
                                  .continuous = false,
                                  .outside = true,
                                  .outputs = outputs,
                                  .check = check,
                                  .feeds_through = feeds_through};

  template <class T>
  static void output(const BlockCall<T>&) {}
  template <class T>
  static void slope(const BlockCall<T>&, T*) {}
  static bool keep(const BlockCall<double>&, double*) { return false; }
  template <class T>
  static constexpr BlockRow<T> row{output<T>, slope<T>, nullptr, keep};
};

}  // namespace mimbre::blocks
