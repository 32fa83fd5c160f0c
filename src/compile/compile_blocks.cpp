#include "compile/compile_blocks.h"

#include <algorithm>
#include <cmath>

#include "math/elementary.h"
#include "spec/block_types.h"

namespace mimbre {
namespace {

/// The matrices of a linear block (src/signals/blocks/linear.h), and its states at the start.
struct Realisation {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd start;
};

/// Σ b_k s^(n−k) / Σ a_k s^(n−k) as a chain of n states,
///
///     ẋ₁ = ω (u − Σ αᵢ xᵢ),  ẋᵢ = ω xᵢ₋₁,  y = b₀ u + Σ (bᵢ − b₀ aᵢ) ω⁻ⁱ xᵢ,  αᵢ = aᵢ ω⁻ⁱ,  a₀ = 1.
///
/// ω is the size of the largest pole, so that the states are of one size. Sampled: z for s, x⁺ for ẋ, ω = 1.
Realisation realise(const Eigen::RowVectorXd& numerator, const Eigen::RowVectorXd& denominator,
                    bool sampled) {
  Eigen::Index zeros = 0;
  while (denominator[zeros] == 0) ++zeros;
  const Eigen::Index n = denominator.size() - zeros - 1;
  const Eigen::RowVectorXd a = denominator.tail(n + 1) / denominator[zeros];
  Eigen::RowVectorXd b = Eigen::RowVectorXd::Zero(n + 1);
  const Eigen::Index given = std::min(numerator.size(), n + 1);
  b.tail(given) = numerator.tail(given) / denominator[zeros];
  double omega = 0;
  for (Eigen::Index k = 1; k <= n; ++k)
    omega = std::max(omega, mimbre::pow(std::abs(a[k]), 1.0 / static_cast<double>(k)));
  if (sampled || !(omega > 0)) omega = 1;
  Realisation r;
  r.A.setZero(n, n);
  r.B.setZero(n, 1);
  r.C.setZero(1, n);
  r.D.setConstant(1, 1, b[0]);
  r.start.setZero(n);
  double power = 1;
  for (Eigen::Index k = 0; k < n; ++k) {
    power *= omega;
    r.A(0, k) = -a[k + 1] / power * omega;
    r.C(0, k) = (b[k + 1] - b[0] * a[k + 1]) / power;
    if (k > 0) r.A(k, k - 1) = omega;
  }
  if (n > 0) r.B(0, 0) = omega;
  return r;
}

Realisation realise(const spec::Block& block) {
  const auto& m = block.matrices;
  if (block.type == "transfer_function") return realise(m[0].row(0), m[1].row(0), block.every > 0);
  Realisation r{m[0], m[1], m[2], m[3], m[4].reshaped()};
  if (r.D.size() == 0) r.D.setZero(r.C.rows(), r.B.cols());
  if (r.start.size() == 0) r.start.setZero(r.A.rows());
  return r;
}

bool is_linear(const spec::Block& block) {
  return block.type == "transfer_function" || block.type == "state_space";
}

void append_rows(const Eigen::MatrixXd& m, Array<double>& to) {
  for (Eigen::Index r = 0; r < m.rows(); ++r)
    for (Eigen::Index c = 0; c < m.cols(); ++c) to.push_back(m(r, c));
}

/// Points that a delay keeps: three and more per step, so that halved steps and jumps at their ends fit, but
/// never more than 4096.
int delay_points(double delay, double step) {
  return static_cast<int>(std::min(4096.0, 16 + 4 * std::ceil(delay / step)));
}

}  // namespace

bool feeds_through(const spec::Block& block) {
  if (is_linear(block)) return !realise(block).D.isZero(0);
  return block.type != "delay" && block.type != "hysteresis";
}

bool is_smooth(const spec::Block& block) { return is_linear(block); }

SignalsData::Block compile_block(const spec::Block& block, double step, SignalsData& signals) {
  SignalsData::Block b{};
  b.type = find_block(block.type);
  b.inputs = static_cast<int>(block.inputs.size());
  b.outputs = output_count(block);
  b.every = block.every;
  b.numbers = static_cast<int>(signals.numbers.size());
  b.function = -1;
  b.matrices = signals.matrices;
  if (is_linear(block)) {
    const Realisation r = realise(block);
    for (const auto* m : {&r.A, &r.B, &r.C, &r.D}) append_rows(*m, signals.numbers);
    append_rows(r.start, signals.numbers);
    b.states = static_cast<int>(r.A.rows());
    if (!(b.every > 0)) signals.matrices += step_matrices(b.states, b.inputs);
    return b;
  }
  switch (static_cast<BlockType>(b.type)) {
    case BlockType::pid:
      b.states = 2;
      break;
    case BlockType::rate_limit:
    case BlockType::hysteresis:
      b.states = 1;
      break;
    case BlockType::delay:
      b.states = delay_states(delay_points(block.numbers[0], block.every > 0 ? block.every : step));
      break;
    case BlockType::table:
      b.function = static_cast<int>(signals.functions.size());
      signals.functions.push_back(block.function.data());
      break;
    case BlockType::table_2d: {
      const auto &x = block.matrices[0], &y = block.matrices[1];
      signals.numbers.push_back(static_cast<double>(x.size()));
      signals.numbers.push_back(static_cast<double>(y.size()));
      for (const Eigen::MatrixXd& m : block.matrices) append_rows(m, signals.numbers);
      break;
    }
    default:
      break;
  }
  signals.numbers.append(block.numbers.begin(), block.numbers.end());
  return b;
}

}  // namespace mimbre
