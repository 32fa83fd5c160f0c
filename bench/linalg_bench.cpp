// The block-sparse factorisation on the patterns of the flexible and of the rigid vehicle, beside Eigen's
// dense LLᵀ.
#include <benchmark/benchmark.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "linalg/block_sparse.h"

namespace {
using mimbre::linalg::BlockFactor;
using mimbre::linalg::BlockPattern;
using mimbre::linalg::BlockPlace;
using mimbre::linalg::BlockSymbolic;

/// A chassis and four corners of arm, axle, link (closes a loop over arm and axle) and rod.
BlockPattern vehicle(int arm, int axle, int link, int rod) {
  BlockPattern pattern{{6}, {}};
  for (int corner = 0; corner < 4; ++corner) {
    const int a = 4 * corner + 1;
    pattern.sizes.insert(pattern.sizes.end(), {arm, axle, link, rod});
    for (auto [i, j] : {std::pair(0, 1), {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3}, {0, 4}, {1, 4}, {2, 4}})
      pattern.couplings.emplace_back(i == 0 ? 0 : a + i - 1, a + j - 1);
  }
  return pattern;
}

BlockPattern pattern(const benchmark::State& state) {
  return state.range(0) == 0 ? vehicle(1, 3, 1, 2) : vehicle(5, 3, 7, 8);
}

/// A definite matrix of that pattern; calls write(i, j, r, c, value) for each stored entry.
template <class Write>
void assemble(const BlockSymbolic& symbolic, Write write) {
  for (int i = 0; i < symbolic.blocks(); ++i)
    for (int j = 0; j <= i; ++j)
      if (symbolic.coupled(i, j))
        for (int r = symbolic.start(i); r < symbolic.start(i + 1); ++r)
          for (int c = symbolic.start(j); c < symbolic.start(j + 1); ++c)
            write(i, j, r, c, r == c ? 40.0 : std::cos(1.0 + r + c));
}

void fill(const BlockSymbolic& symbolic, double* values) {
  assemble(symbolic, [&](int i, int j, int r, int c, double value) {
    const BlockPlace place = symbolic.place(i, j);
    values[place.offset + (r - symbolic.start(i)) * place.row_stride +
           (c - symbolic.start(j)) * place.col_stride] = value;
  });
}

/// The copy of the assembled values stands for set_zero() and is what makes each factorisation a fresh one.
void block_factor(benchmark::State& state) {
  const BlockSymbolic symbolic(pattern(state));
  BlockFactor<double> factor(symbolic);
  factor.set_zero();
  fill(symbolic, factor.values());
  const std::vector<double> values(factor.values(), factor.values() + symbolic.value_count());
  for (auto _ : state) {
    std::copy(values.begin(), values.end(), factor.values());
    benchmark::DoNotOptimize(factor.factor());
    benchmark::ClobberMemory();
  }
  state.counters["values"] = static_cast<double>(symbolic.value_count());
  state.counters["panels"] = static_cast<double>(symbolic.panels().size());
}

void block_solve(benchmark::State& state) {
  const BlockSymbolic symbolic(pattern(state));
  BlockFactor<double> factor(symbolic);
  factor.set_zero();
  fill(symbolic, factor.values());
  if (!factor.factor().ok()) state.SkipWithError("factorisation failed");
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(symbolic.size());
  Eigen::VectorXd x = b;
  for (auto _ : state) {
    x = b;
    factor.solve(x.data());
    benchmark::ClobberMemory();
  }
}

Eigen::MatrixXd dense(const BlockSymbolic& symbolic) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(symbolic.size(), symbolic.size());
  assemble(symbolic, [&](int, int, int r, int c, double value) { matrix(r, c) = matrix(c, r) = value; });
  return matrix;
}

void dense_factor(benchmark::State& state) {
  const Eigen::MatrixXd matrix = dense(BlockSymbolic(pattern(state)));
  Eigen::LLT<Eigen::MatrixXd> llt(matrix);
  for (auto _ : state) {
    llt.compute(matrix);
    benchmark::ClobberMemory();
  }
}

void dense_solve(benchmark::State& state) {
  const Eigen::MatrixXd matrix = dense(BlockSymbolic(pattern(state)));
  const Eigen::LLT<Eigen::MatrixXd> llt(matrix);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(matrix.rows());
  Eigen::VectorXd x = b;
  for (auto _ : state) {
    x = b;
    llt.solveInPlace(x);
    benchmark::ClobberMemory();
  }
}

BENCHMARK(block_factor)->ArgName("flexible")->Arg(0)->Arg(1);
BENCHMARK(block_solve)->ArgName("flexible")->Arg(0)->Arg(1);
BENCHMARK(dense_factor)->ArgName("flexible")->Arg(0)->Arg(1);
BENCHMARK(dense_solve)->ArgName("flexible")->Arg(0)->Arg(1);
}  // namespace
