#pragma once
#include <array>

#include "compile/signals/compile_blocks.h"
#include "math/function_values.h"
#include "math/lanes.h"
#include "spec/block_info.h"
#include "spec/check/checked_item.h"

/// What the blocks share: each makes signals of others and of what it remembers, in the step (continuous) or
/// at instants (sampled).
///
/// A continuous block knows its inputs where the step starts and, again in every iteration, where it ends;
/// between them they are taken to be on straight lines. Its states are those of the step's start until the
/// step is accepted, so that iterations, parts of steps and repeated steps begin with the same ones.
namespace mimbre {

template <class T>
struct BlockCall {
  const double* numbers;         ///< the block's, as compile() laid them out
  const double* matrices;        ///< what the step's length made of them
  const FunctionData* function;  ///< of a table of one variable
  int inputs, outputs, states;
  double every;     ///< s; 0: continuous
  double time;      ///< s, now
  double h;         ///< s since its states were; 0: they are of now
  bool begun;       ///< it has states; where not, it begins with its inputs as they are now
  const T* before;  ///< states, `h` ago
  const T* first;   ///< inputs, `h` ago
  const T* in;      ///< inputs now
  T* out;

  bool sampled() const { return every > 0; }
};

/// A row of the table of blocks (signals/blocks/table.h).
template <class T>
struct BlockRow {
  /// Outputs now.
  void (*output)(const BlockCall<T>&);
  /// by (outputs × inputs): ∂out/∂in, all else kept.
  void (*slope)(const BlockCall<T>&, T* by);
  /// Outputs with their derivatives by time, of inputs whose derivatives are known; null: they are not
  /// smooth.
  void (*jets)(const BlockCall<T>&, const JetOf<T>* in, JetOf<T>* out);
  /// Moves the states on to now. `states` is what `before` points to. True where the output jumps by that.
  bool (*keep)(const BlockCall<double>&, double* states);
  /// What the length of a step h makes of its numbers: its `matrices`. Null: it has none.
  void (*prepare)(const SignalsData::Block&, const double* numbers, double h, double* matrices) = nullptr;
};

}  // namespace mimbre
