#pragma once
#include <string_view>
#include <utility>
#include <vector>

#include "forces/table.h"
#include "signals/blocks/table.h"

/// Rates by time of what force elements and continuous blocks remember. Laws and blocks integrate it over a
/// step by themselves; these are the differential equations that they integrate, as their headers state them.
namespace mimbre::portable {

/// Whether what the law of an element remembers follows differential equations, or is not there.
inline bool has_rates(const ElementData& e) {
  const std::string_view law = forces::infos[static_cast<std::size_t>(e.law)]->name;
  return law_states(e) == e.own_states || law == "hydraulic_damper" || law == "bushing" ||
         (law == "cable" && e.argument_count == 0);
}

/// Of the law of an element that has_rates(): which of its states, counted from ElementData::own_states on,
/// and their rates. `s`: what it measures; `states`, `numbers`: the model's.
template <class T>
std::vector<std::pair<int, T>> element_rates(const ElementData& e, const ElementState<T>& s,
                                             const std::vector<T>& states, const std::vector<T>& numbers) {
  std::vector<std::pair<int, T>> out;
  const std::string_view law = forces::infos[static_cast<std::size_t>(e.law)]->name;
  if (law_states(e) == e.own_states) return out;
  const T* const now = states.data() + e.states + e.own_states;
  const T* const p = numbers.data() + e.numbers;
  if (law == "hydraulic_damper") {
    // Ḟ = K (ẋ − w(F)).
    using namespace forces::hydraulic_damper;
    out.emplace_back(force, T(p[stiffness] * (s.v[0] - flow<T>(p, now[force], T(0)).speed)));
  } else if (law == "bushing") {
    // ė = ẋ − e/τ of the springs of each branch; the first six states are the place.
    using namespace forces::bushing;
    const int count = (e.state_count - e.own_states) / 6 - 1;
    for (int b = 0; b < count; ++b)
      for (int k = 0; k < 6; ++k) {
        const int at = 6 * (1 + b) + k;
        out.emplace_back(at, T(s.v[k] - now[at] / p[branches + b * branch_size + 36]));
      }
  }
  return out;
}

/// Of the states of a continuous block of that type. Empty: it has none.
template <class T>
std::vector<T> block_rates(const BlockCall<T>& c, std::string_view type) {
  std::vector<T> out;
  if (type == "pid") {
    // İ = ki (r − y), but not over a limit; ḟ = (w − f)/T.
    using namespace blocks::pid;
    const double* p = c.numbers;
    const T y = c.in[measured], r = c.in[setpoint], w = T(p[derivative_weight]) * r - y,
            f = c.before[filtered];
    T rest = T(p[kp]) * (T(p[weight]) * r - y);
    if (p[kd] != 0) rest += T(p[kd] / p[filter]) * (w - f);
    const T winds = T(p[ki]) * (r - y), held = c.before[integral];
    const auto stops =
        (held >= T(p[upper]) - rest && winds > T(0)) || (held <= T(p[lower]) - rest && winds < T(0));
    out.push_back(select(stops, T(0), winds));
    out.push_back(p[kd] != 0 ? T((w - f) / T(p[filter])) : T(0));
  } else if (type == "transfer_function" || type == "state_space") {
    // ẋ = A x + B u.
    const blocks::linear::Shape s = blocks::linear::shape(c);
    for (int k = 0; k < s.n; ++k)
      out.push_back(blocks::linear::row_times<T>(c.numbers + k * s.n, s.n, c.before,
                                                 c.numbers + s.b() + k * s.m, s.m, c.in));
  }
  return out;
}

}  // namespace mimbre::portable
