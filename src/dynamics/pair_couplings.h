#pragma once
#include <cmath>
#include <vector>

#include "forces/element_ends.h"

/// Tangents of pairs of spheres of a swarm, which change from step to step. The factorised matrix D, whose
/// pattern does not, has what each of the two bodies feels of itself; what one feels of the other, C, stands
/// here, and systems with A = D + C are solved by conjugate gradients that D preconditions (Hestenes and
/// Stiefel, Journal of Research of the National Bureau of Standards 49, 1952).
namespace mimbre {

class PairCouplings {
 public:
  /// Of systems with that many unknowns. `columns(contact, sphere)`: the unknowns that move a sphere, −1
  /// where a row has none.
  template <class Columns>
  PairCouplings(const Compiled& m, int unknowns, const Columns& columns) : columns_(m.swarms.size()) {
    std::size_t pairs = 0;
    for (std::size_t k = 0; k < m.swarms.size(); ++k) {
      const SwarmData& swarm = m.swarms[k];
      pairs += static_cast<std::size_t>(swarm.last - swarm.first);
      for (std::size_t i = 0; i < swarm.spheres.size(); ++i)
        columns_[k].push_back(columns(static_cast<int>(k), static_cast<int>(i)));
    }
    pairs_.reserve(pairs);
    if (pairs == 0) return;
    for (auto* x : {&residual_, &direction_, &by_matrix_, &preconditioned_, &solution_})
      x->assign(static_cast<std::size_t>(unknowns), 0.0);
  }

  void clear() { pairs_.clear(); }
  bool empty() const { return pairs_.empty(); }
  /// rows: count × stride of each side, of what the element measures per unit of its unknowns; they and the
  /// tangents of the system stay where they are. `tangent`: count × count, symmetric.
  void add(const ElementData& e, const ElementEnds& ends, const double* tangent, const double* rows_a,
           int stride_a, const double* rows_b, int stride_b) {
    const auto& columns = columns_[static_cast<std::size_t>(e.spec)];
    Pair pair{e.count,
              {rows_a, stride_a, &columns[static_cast<std::size_t>(ends.first)]},
              {rows_b, stride_b, &columns[static_cast<std::size_t>(ends.second)]},
              {}};
    std::copy_n(tangent, e.count * e.count, pair.tangent);
    pairs_.push_back(pair);
  }

  /// y += C x.
  void add_product(const double* x, double* y) const {
    for (const Pair& pair : pairs_) {
      push(pair, pair.a, pair.b, x, y);
      push(pair, pair.b, pair.a, x, y);
    }
  }

  /// Adds C to a dense matrix of that size, column-major.
  void add_to(double* matrix, int size) const {
    for (const Pair& pair : pairs_)
      for (const auto& [from, to] : {std::pair(&pair.a, &pair.b), std::pair(&pair.b, &pair.a)})
        for (int i = 0; i < pair.count; ++i)
          for (int j = 0; j < pair.count; ++j)
            for (std::size_t c = 0; c < from->columns->size(); ++c)
              for (std::size_t r = 0; r < to->columns->size(); ++r)
                if ((*from->columns)[c] >= 0 && (*to->columns)[r] >= 0)
                  matrix[static_cast<std::ptrdiff_t>((*from->columns)[c]) * size + (*to->columns)[r]] +=
                      to->row(i)[r] * pair.tangent[i * pair.count + j] * from->row(j)[c];
  }

  /// x ← A⁻¹ x; `precondition(x)`: x ← D⁻¹ x. A bounded number of iterations; what they leave is small beside
  /// the right-hand side, and Newton's iteration sees to it.
  template <class Precondition>
  void solve(double* x, const Precondition& precondition) const {
    if (empty()) return precondition(x);
    constexpr double enough = 1e-7;
    constexpr int most_iterations = 500;
    const std::size_t n = residual_.size();
    const auto dot = [n](const std::vector<double>& a, const std::vector<double>& b) {
      double sum = 0;
      for (std::size_t k = 0; k < n; ++k) sum += a[k] * b[k];
      return sum;
    };
    // The product with D is known without D: of z = D⁻¹ r it is r.
    std::copy_n(x, n, residual_.begin());
    std::fill(solution_.begin(), solution_.end(), 0.0);
    std::fill(direction_.begin(), direction_.end(), 0.0);
    std::fill(by_matrix_.begin(), by_matrix_.end(), 0.0);
    double before = 0, first = 0;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      preconditioned_ = residual_;
      precondition(preconditioned_.data());
      const double now = dot(residual_, preconditioned_);
      if (iteration == 0) first = now;
      if (!(now > enough * enough * first)) break;
      const double turned = iteration == 0 ? 0 : now / before;
      for (std::size_t k = 0; k < n; ++k) {
        direction_[k] = preconditioned_[k] + turned * direction_[k];
        by_matrix_[k] = residual_[k] + turned * by_matrix_[k];
      }
      // With C the product of A; of D alone it is needed again.
      std::copy(by_matrix_.begin(), by_matrix_.end(), preconditioned_.begin());
      add_product(direction_.data(), preconditioned_.data());
      const double curvature = dot(direction_, preconditioned_);
      if (!(curvature > 0)) {
        // No definite matrix: D alone leads on, more slowly.
        if (iteration == 0) std::copy(direction_.begin(), direction_.end(), solution_.begin());
        break;
      }
      const double length = now / curvature;
      for (std::size_t k = 0; k < n; ++k) {
        solution_[k] += length * direction_[k];
        residual_[k] -= length * preconditioned_[k];
      }
      before = now;
    }
    std::copy(solution_.begin(), solution_.end(), x);
  }

 private:
  struct Side {
    const double* rows;
    int stride;
    const std::vector<int>* columns;
    const double* row(int k) const { return rows + static_cast<std::ptrdiff_t>(k) * stride; }
  };
  struct Pair {
    int count;
    Side a, b;
    double tangent[36];
  };

  /// y += Rₜₒᵀ T R_from x.
  static void push(const Pair& pair, const Side& from, const Side& to, const double* x, double* y) {
    double rate[6], force[6];
    for (int k = 0; k < pair.count; ++k) {
      rate[k] = 0;
      for (std::size_t c = 0; c < from.columns->size(); ++c)
        if (const int at = (*from.columns)[c]; at >= 0) rate[k] += from.row(k)[c] * x[at];
    }
    for (int k = 0; k < pair.count; ++k) {
      force[k] = 0;
      for (int j = 0; j < pair.count; ++j) force[k] += pair.tangent[k * pair.count + j] * rate[j];
    }
    for (int k = 0; k < pair.count; ++k)
      for (std::size_t c = 0; c < to.columns->size(); ++c)
        if (const int at = (*to.columns)[c]; at >= 0) y[at] += force[k] * to.row(k)[c];
  }

  std::vector<std::vector<std::vector<int>>> columns_;  ///< by contact and sphere
  std::vector<Pair> pairs_;
  mutable std::vector<double> residual_, direction_, by_matrix_, preconditioned_, solution_;
};

}  // namespace mimbre
