#pragma once
#include "signals/blocks/linear.h"
#include "signals/blocks/matrix_shape.h"

namespace mimbre::blocks {

/// A linear block by its matrices: as many inputs and outputs as they have columns and rows.
struct StateSpace {
  static constexpr std::array<BlockMatrix, 5> matrices{
      {{.key = "A"},
       {.key = "B", .column = true},
       {.key = "C"},
       {.key = "D", .optional = true},
       {.key = "initial", .optional = true, .column = true}}};

  static linear::Realisation realise(const spec::Block& b) {
    const auto& m = b.matrices;
    linear::Realisation r{m[0], m[1], m[2], m[3], m[4].reshaped()};
    if (r.D.size() == 0) r.D.setZero(r.C.rows(), r.B.cols());
    if (r.start.size() == 0) r.start.setZero(r.A.rows());
    return r;
  }

  static int outputs(const spec::Block& b) {
    return b.matrices.size() > 2 ? static_cast<int>(b.matrices[2].rows()) : 1;
  }
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    const Eigen::MatrixXd &A = b.matrices[0], &B = b.matrices[1], &C = b.matrices[2], &D = b.matrices[3],
                          &initial = b.matrices[4];
    const auto n = A.rows(), m = static_cast<Eigen::Index>(b.inputs.size());
    if (n < 1 || n > most_block_states)
      return item.error(fmt::format("A has {} rows; 1 to {} states are possible", n, most_block_states));
    if (C.rows() < 1 || C.rows() > most_block_outputs)
      return item.error(
          fmt::format("C has {} rows; 1 to {} outputs are possible", C.rows(), most_block_outputs));
    check_shape(item, "A", A, n, n);
    check_shape(item, "B", B, n, m);
    check_shape(item, "C", C, C.rows(), n);
    check_shape(item, "D", D, C.rows(), m, true);
    if (initial.size() != 0 && initial.size() != n)
      item.error(fmt::format("initial has {} numbers; there are {} states", initial.size(), n));
  }
  static bool feeds_through(const spec::Block& b) { return !realise(b).D.isZero(0); }
  static void compile(const spec::Block& b, const BlockPlan& plan) { linear::compile(realise(b), plan); }

  static constexpr BlockInfo info{.name = "state_space",
                                  .key = "state_space",
                                  .inputs = -1,
                                  .matrices = matrices,
                                  .named_outputs = true,
                                  .smooth = true,
                                  .outputs = outputs,
                                  .check = check,
                                  .feeds_through = feeds_through,
                                  .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row = linear::row<T>;
};

}  // namespace mimbre::blocks
