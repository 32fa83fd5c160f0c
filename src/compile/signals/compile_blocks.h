#pragma once
#include "compile/compiled.h"

/// The part of compile() that makes the blocks of the spec. The spec is checked.
namespace mimbre {

/// Where a block's constants go (BlockInfo::compile), and how many it has.
struct BlockPlan {
  SignalsData& signals;
  SignalsData::Block& block;
  double step;  ///< the model's, s

  void add_numbers(const std::vector<double>& numbers) const {
    signals.numbers.append(numbers.begin(), numbers.end());
  }
  /// By rows.
  void add_numbers(const Eigen::MatrixXd& m) const {
    for (Eigen::Index r = 0; r < m.rows(); ++r)
      for (Eigen::Index c = 0; c < m.cols(); ++c) signals.numbers.push_back(m(r, c));
  }
};

/// Whether its outputs follow its inputs at the same instant, so that it closes no loop.
bool feeds_through(const spec::Block& block);
/// Whether its outputs have derivatives by time, where its inputs have.
bool is_smooth(const spec::Block& block);

/// Its constants, which go to `signals`, and sizes; places in what is held are left to be given. `step`: the
/// model's, s.
SignalsData::Block compile_block(const spec::Block& block, double step, SignalsData& signals);

}  // namespace mimbre
