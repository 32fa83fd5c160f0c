#pragma once
#include "math/matrix_exponential.h"
#include "signals/blocks/block.h"

/// Linear blocks, by transfer functions or in state space, n states x, m inputs u, p outputs y:
///
///     ẋ = A x + B u,  y = C x + D u      continuous
///     x⁺ = A x + B u, y = C x + D u      sampled
///
/// Over a step h in which the inputs go from u₀ to u₁ on straight lines the continuous one is solved exactly
/// (Franklin, Powell, Workman, Digital Control of Dynamic Systems, 3rd ed., 6.3.2, "triangle hold"):
///
///     x₁ = Φ x₀ + Γ₁ u₀ + Γ₂ (u₁ − u₀)
///
///         ⎡A h  B h  0⎤   ⎡Φ  Γ₁  Γ₂⎤
///     exp ⎢ 0    0   I⎥ = ⎢0  I   I ⎥
///         ⎣ 0    0   0⎦   ⎣0  0   I ⎦
namespace mimbre::blocks::linear {

/// Numbers: A (n × n), B (n × m), C (p × n), D (p × m), then the states at the start; all by rows. Matrices
/// of the step: Φ, Γ₁, Γ₂.
struct Shape {
  int n, m, p;
  int b() const { return n * n; }
  int c() const { return b() + n * m; }
  int d() const { return c() + p * n; }
  int start() const { return d() + p * m; }
  int numbers() const { return start() + n; }
  int gamma1() const { return n * n; }
  int gamma2() const { return n * n + n * m; }
};

template <class T>
Shape shape(const BlockCall<T>& c) {
  return {c.states, c.inputs, c.outputs};
}

/// Φ, Γ₁, Γ₂ of a step.
inline void discretise(const SignalsData::Block& b, const double* numbers, double h, double* matrices) {
  const Shape s{b.states, b.inputs, b.outputs};
  const int n = s.n, m = s.m;
  SmallMatrix of = SmallMatrix::Zero(n + 2 * m, n + 2 * m);
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) of(r, c) = h * numbers[r * n + c];
    for (int c = 0; c < m; ++c) of(r, n + c) = h * numbers[s.b() + r * m + c];
  }
  for (int k = 0; k < m; ++k) of(n + k, n + m + k) = 1;
  const SmallMatrix e = matrix_exponential(of);
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) matrices[r * n + c] = e(r, c);
    for (int c = 0; c < m; ++c) {
      matrices[s.gamma1() + r * m + c] = e(r, n + c);
      matrices[s.gamma2() + r * m + c] = e(r, n + m + c);
    }
  }
}

/// States now.
template <class T>
std::array<T, most_block_states> states_of(const BlockCall<T>& c) {
  const Shape s = shape(c);
  std::array<T, most_block_states> x;
  if (!c.begun) {
    for (int r = 0; r < s.n; ++r) x[r] = T(c.numbers[s.start() + r]);
    return x;
  }
  for (int r = 0; r < s.n; ++r) {
    if (c.sampled() || c.h == 0) {
      x[r] = c.before[r];
      continue;
    }
    T sum(0);
    for (int k = 0; k < s.n; ++k) sum += c.matrices[r * s.n + k] * c.before[k];
    for (int k = 0; k < s.m; ++k)
      sum += c.matrices[s.gamma1() + r * s.m + k] * c.first[k] +
             c.matrices[s.gamma2() + r * s.m + k] * (c.in[k] - c.first[k]);
    x[r] = sum;
  }
  return x;
}

/// to = P x + Q u of the matrices that begin there.
template <class T, class States, class Inputs>
T row_times(const double* of_states, int n, const States& x, const double* of_inputs, int m,
            const Inputs& u) {
  T sum(0);
  for (int k = 0; k < n; ++k) sum += of_states[k] * x[k];
  for (int k = 0; k < m; ++k) sum += of_inputs[k] * u[k];
  return sum;
}

template <class T>
void output(const BlockCall<T>& c) {
  const Shape s = shape(c);
  const auto x = states_of(c);
  for (int r = 0; r < s.p; ++r)
    c.out[r] = row_times<T>(c.numbers + s.c() + r * s.n, s.n, x, c.numbers + s.d() + r * s.m, s.m, c.in);
}

template <class T>
void slope(const BlockCall<T>& c, T* by) {
  const Shape s = shape(c);
  for (int r = 0; r < s.p; ++r)
    for (int k = 0; k < s.m; ++k) {
      double sum = c.numbers[s.d() + r * s.m + k];
      if (!c.sampled() && c.h > 0 && c.begun)
        for (int j = 0; j < s.n; ++j)
          sum += c.numbers[s.c() + r * s.n + j] * c.matrices[s.gamma2() + j * s.m + k];
      by[r * s.m + k] = T(sum);
    }
}

template <class T>
void jets(const BlockCall<T>& c, const JetOf<T>* in, JetOf<T>* out) {
  const Shape s = shape(c);
  std::array<T, most_block_inputs> first, second;
  for (int k = 0; k < s.m; ++k) {
    first[k] = in[k].first;
    second[k] = in[k].second;
  }
  const auto x = states_of(c);
  std::array<T, most_block_states> rate, change;
  for (int r = 0; r < s.n; ++r)
    rate[r] = row_times<T>(c.numbers + r * s.n, s.n, x, c.numbers + s.b() + r * s.m, s.m, c.in);
  for (int r = 0; r < s.n; ++r)
    change[r] = row_times<T>(c.numbers + r * s.n, s.n, rate, c.numbers + s.b() + r * s.m, s.m, first);
  for (int r = 0; r < s.p; ++r) {
    const double *of_states = c.numbers + s.c() + r * s.n, *of_inputs = c.numbers + s.d() + r * s.m;
    out[r] = {row_times<T>(of_states, s.n, x, of_inputs, s.m, c.in),
              row_times<T>(of_states, s.n, rate, of_inputs, s.m, first),
              row_times<T>(of_states, s.n, change, of_inputs, s.m, second)};
  }
}

/// States of a sampled one at the next instant.
template <class T>
std::array<T, most_block_states> next_states_of(const BlockCall<T>& c) {
  const Shape s = shape(c);
  const auto now = states_of(c);
  std::array<T, most_block_states> x;
  for (int r = 0; r < s.n; ++r)
    x[r] = row_times<T>(c.numbers + r * s.n, s.n, now, c.numbers + s.b() + r * s.m, s.m, c.in);
  return x;
}

inline bool keep(const BlockCall<double>& c, double* states) {
  const auto x = c.sampled() ? next_states_of(c) : states_of(c);
  for (int r = 0; r < c.states; ++r) states[r] = x[r];
  return false;
}

/// A block's matrices, and its states at the start.
struct Realisation {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd start;
};

inline void compile(const Realisation& r, const BlockPlan& plan) {
  for (const auto* m : {&r.A, &r.B, &r.C, &r.D}) plan.add_numbers(*m);
  plan.add_numbers(Eigen::MatrixXd(r.start));
  SignalsData::Block& b = plan.block;
  b.states = static_cast<int>(r.A.rows());
  if (!(b.every > 0)) plan.signals.matrices += b.states * (b.states + 2 * b.inputs);
}

template <class T>
constexpr BlockRow<T> row{output<T>, slope<T>, jets<T>, keep, discretise};

}  // namespace mimbre::blocks::linear
