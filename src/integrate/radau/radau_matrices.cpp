#include "integrate/radau/radau_matrices.h"

#include <cmath>

#include "integrate/radau/radau_method.h"
#include "linalg/block_factor_impl.h"

namespace mimbre {

template class linalg::BlockFactor<linalg::Complex>;

using linalg::Complex;

RadauMatrices::RadauMatrices(System& system, double penalty)
    : system_(system),
      penalty_(penalty),
      dense_(system.pattern().size() == 0 && system.velocities() > 0),
      one_block_(dense_ ? linalg::BlockSymbolic({{system.velocities()}, {}}) : linalg::BlockSymbolic()),
      symbolic_(dense_ ? one_block_ : system.pattern()),
      real_(symbolic_),
      complex_(symbolic_) {
  for (std::vector<double>* values : {&inertia_, &damping_, &stiffness_})
    values->resize(static_cast<std::size_t>(symbolic_.value_count()));
  if (dense_) copy_.resize(static_cast<std::size_t>(system.velocities()) * system.velocities());
}

void RadauMatrices::assemble(const double* q, const MatrixWeights& weights, std::vector<double>& values) {
  if (!dense_) return system_.matrix_values(q, weights, values.data());
  system_.dense_matrix(q, weights, copy_.data());
  const linalg::BlockPlace place = symbolic_.place(0, 0);
  const int n = symbolic_.size();
  for (int c = 0; c < n; ++c)
    for (int r = c; r < n; ++r)
      values[place.offset + r * place.row_stride + c * place.col_stride] = copy_[r + c * n];
}

linalg::FactorStatus RadauMatrices::factor(const double* q, double h) {
  const double real = h / radau::gamma;
  const Complex s = Complex(h) / radau::alpha_beta;
  const double square = s.re * s.re + s.im * s.im, size = std::sqrt(square);
  assemble(q, {size, 0, penalty_}, damping_);
  assemble(q, {0, square, penalty_}, stiffness_);
  assemble(q, {0, 0, penalty_}, inertia_);
  const double damping = real / size, stiffness = real * real / square;
  const Complex c = s * (1 / size), k = s * s * (1 / square);
  real_.set_zero();
  complex_.set_zero();
  for (std::size_t i = 0; i < inertia_.size(); ++i) {
    const double m = inertia_[i], dc = damping_[i] - m, dk = stiffness_[i] - m;
    real_.values()[i] = m + damping * dc + stiffness * dk;
    complex_.values()[i] = {m + c.re * dc + k.re * dk, c.im * dc + k.im * dk};
  }
  const linalg::FactorStatus status = real_.factor();
  return status.ok() ? complex_.factor() : status;
}

}  // namespace mimbre
