#pragma once
#include <algorithm>
#include <cmath>

#include "math/elementary.h"
#include "signals/blocks/linear.h"
#include "signals/blocks/matrix_shape.h"

namespace mimbre::blocks {

/// The ratio of two polynomials in s, or, sampled, in z.
struct TransferFunction {
  static constexpr std::array<BlockMatrix, 2> matrices{{{"numerator"}, {"denominator"}}};

  /// Σ b_k s^(n−k) / Σ a_k s^(n−k) as a chain of n states,
  ///
  ///     ẋ₁ = ω (u − Σ αᵢ xᵢ),  ẋᵢ = ω xᵢ₋₁,  y = b₀ u + Σ (bᵢ − b₀ aᵢ) ω⁻ⁱ xᵢ,  αᵢ = aᵢ ω⁻ⁱ,  a₀ = 1.
  ///
  /// ω is the size of the largest pole, so that the states are of one size. Sampled: z for s, x⁺ for ẋ, ω
  /// = 1.
  static linear::Realisation realise(const Eigen::RowVectorXd& numerator,
                                     const Eigen::RowVectorXd& denominator, bool sampled) {
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
    linear::Realisation r;
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
  static linear::Realisation realise(const spec::Block& b) {
    return realise(b.matrices[0].row(0), b.matrices[1].row(0), b.every > 0);
  }

  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    const auto &numerator = b.matrices[0], &denominator = b.matrices[1];
    for (const auto& [name, m] : {std::pair("numerator", &numerator), std::pair("denominator", &denominator)})
      if (m->rows() != 1 || m->cols() == 0) {
        item.error(fmt::format("{} is {}; a row of coefficients is needed, that of the highest power first",
                               name, shape_of(*m)));
        return;
      }
    const auto degree = [](const Eigen::MatrixXd& p) {
      Eigen::Index zeros = 0;
      while (zeros < p.cols() && p(0, zeros) == 0) ++zeros;
      return p.cols() - zeros - 1;  // −1: all are 0
    };
    const Eigen::Index above = degree(numerator), below = degree(denominator);
    if (below < 0)
      item.error("denominator is 0");
    else if (above > below)
      item.error(
          fmt::format("the numerator is of degree {}, above {} of the denominator: that would be a "
                      "derivative; add poles to the denominator",
                      above, below));
    else if (below > most_block_states)
      item.error(fmt::format("the denominator is of degree {}, more than {}", below, most_block_states));
  }
  static bool feeds_through(const spec::Block& b) { return !realise(b).D.isZero(0); }
  static void compile(const spec::Block& b, const BlockPlan& plan) { linear::compile(realise(b), plan); }

  static constexpr BlockInfo info{.name = "transfer_function",
                                  .key = "transfer_function",
                                  .matrices = matrices,
                                  .smooth = true,
                                  .check = check,
                                  .feeds_through = feeds_through,
                                  .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row = linear::row<T>;
};

}  // namespace mimbre::blocks
