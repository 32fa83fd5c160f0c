#pragma once
#include <cmath>

#include "forces/element.h"
#include "math/elementary.h"

/// A bushing between two frames: six components by a stiffness and a damping matrix, or by a law for each,
/// and branches of a spring in row with a damper for rubber, whose stiffness depends on the frequency.
namespace mimbre::forces {

namespace bushing {
/// Among the law's numbers: stiffness, damping (36 each), then of each branch stiffness and relaxation time.
constexpr int stiffness = 0, damping = 36, branches = 72, branch_size = 37;

template <class T>
int branch_count(const LawContext<T>& c) {
  // States: what was measured at the start of the step, and the elongation of each branch's springs.
  const int own = c.element.state_count - c.element.own_states;
  return own == 0 ? 0 : own / 6 - 1;
}
/// With laws by axis: six elastic ones, then six dampers.
template <class T>
bool by_axis(const LawContext<T>& c) {
  return c.element.functions >= 0;
}

template <class T>
void add_times(const T* matrix, const T* x, T* out) {
  for (int r = 0; r < 6; ++r)
    for (int k = 0; k < 6; ++k) out[r] += matrix[6 * r + k] * x[k];
}
inline double form(const double* matrix, const double* x) {
  double out[6] = {};
  add_times(matrix, x, out);
  double sum = 0;
  for (int k = 0; k < 6; ++k) sum += out[k] * x[k];
  return sum;
}

/// Share of the change of x that a branch's springs still hold at the end of a step in which x changes
/// evenly.
template <class T>
T held(double step, const T& relaxation) {
  using mimbre::expm1;
  const T r = step / relaxation;
  return select(r > T(0), T(-expm1(-r) / r), T(1));
}
}  // namespace bushing

template <class T>
void bushing_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace bushing;
  using mimbre::exp;
  const T* p = c.numbers();
  for (int k = 0; k < 6; ++k) s.force[k] = T(0);
  for (int k = 0; k < 36; ++k) {
    s.stiffness[k] = p[stiffness + k];
    s.damping[k] = p[damping + k];
  }
  add_times(p + stiffness, s.x, s.force);
  add_times(p + damping, s.v, s.force);
  if (by_axis(c))
    for (int k = 0; k < 6; ++k) {
      const auto [pull, slope] = tangent_at(c.function(k), s.x[k]);
      const auto [resistance, viscosity] = tangent_at(c.function(6 + k), s.v[k]);
      s.force[k] += pull + resistance;
      s.stiffness[7 * k] += slope;
      s.damping[7 * k] += viscosity;
    }
  const int count = branch_count(c);
  if (count == 0) return;
  const T* before = c.states + c.element.own_states;
  T* after = s.states + c.element.own_states;
  for (int k = 0; k < 6; ++k) after[k] = s.x[k];
  for (int b = 0; b < count; ++b) {
    const T *branch = p + branches + b * branch_size, *elongation = before + 6 * (1 + b);
    T* next = after + 6 * (1 + b);
    const T relaxation = branch[36], share = c.step > 0 ? held(c.step, relaxation) : T(0),
            kept = c.step > 0 ? T(exp(-c.step / relaxation)) : T(1);
    // Exact for an x that changes evenly over the step; at rest what is held stays.
    for (int k = 0; k < 6; ++k) next[k] = kept * elongation[k] + share * (s.x[k] - before[k]);
    add_times(branch, next, s.force);
    for (int k = 0; k < 36; ++k) s.stiffness[k] += share * branch[k];
  }
}

inline void bushing_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace bushing;
  const double *p = c.numbers(), *start = c.states + c.element.own_states,
               *end = s.states + c.element.own_states;
  e.stored = 0.5 * form(p + stiffness, s.x);
  add_times(p + damping, s.v, e.dissipating);
  if (by_axis(c))
    for (int k = 0; k < 6; ++k) {
      e.stored += c.function(k).antiderivative(s.x[k]);
      e.dissipating[k] += c.function(6 + k).value(s.v[k]);
    }
  for (int b = 0; b < branch_count(c); ++b) {
    const double *branch = p + branches + b * branch_size, *now = end + 6 * (1 + b);
    e.stored += 0.5 * form(branch, now);
    if (c.step <= 0) continue;
    // ∫ eᵀ K e dt/τ of the damper: e goes from what it was towards g, at which an even rate would hold it.
    const double r = c.step / branch[36], lost = -mimbre::expm1(-r), *before = start + 6 * (1 + b);
    double g[6], off[6], pull[6] = {};
    for (int k = 0; k < 6; ++k) {
      g[k] = (s.x[k] - start[k]) / r;
      off[k] = before[k] - g[k];
    }
    add_times(branch, g, pull);
    double mixed = 0;
    for (int k = 0; k < 6; ++k) mixed += pull[k] * off[k];
    e.lost += r * form(branch, g) + 2 * lost * mixed + 0.5 * lost * (2 - lost) * form(branch, off);
  }
}

struct Bushing {
  static void check(const spec::Element& e, std::vector<std::string>& faults) {
    if (e.numbers.size() != 72) {
      faults.push_back(
          fmt::format("a bushing has 72 numbers (stiffness and damping, 6 x 6), not {}", e.numbers.size()));
      return;
    }
    for (int block = 0; block < 2; ++block) {
      const Eigen::Map<const Eigen::Matrix<double, 6, 6>> m(e.numbers.data() + 36 * block);
      if (m.allFinite() && !m.isApprox(m.transpose(), 1e-9) && !m.isZero(0))
        faults.emplace_back(block == 0 ? "stiffness is not symmetric" : "damping is not symmetric");
    }
  }
  static constexpr LawInfo info{
      .name = "bushing", .section = "bushings", .relative = true, .functions = 12, .check = check};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    bushing_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    bushing_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
