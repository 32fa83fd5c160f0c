#pragma once
#include "math/elementary.h"
#include "signals/blocks/block.h"

/// A PID controller of what is measured, y, towards its setpoint r:
///
///     u = kp (b r − y) + I + kd (w − f) / T,   İ = ki (r − y),   ḟ = (w − f) / T,   w = c r − y
///
/// within its limits (Åström, Hägglund, Advanced PID Control, 2006, chapter 3: setpoint weights b and c,
/// filter T of the derivative). The integral stops where it would push the output over a limit, and is free
/// to come back. I and f are exact for inputs on straight lines; sampled, these lines join the instants: the
/// trapezoidal rule.
namespace mimbre::blocks::pid {

// Inputs.
constexpr int measured = 0, setpoint = 1;
// Numbers.
constexpr int kp = 0, ki = 1, kd = 2, filter = 3, lower = 4, upper = 5, weight = 6, derivative_weight = 7,
              integral_start = 8;
// Matrices, of a continuous one's step: what the filter takes up of its input, and of a change of it on a
// straight line.
constexpr int taken_up = 0, passed_on = 1;
// States: the integral and what the filter of the derivative has.
constexpr int integral = 0, filtered = 1;

inline void take_up(double filter, double h, double* matrices) {
  const double z = h / filter, decay = -mimbre::expm1(-z);
  matrices[taken_up] = decay;
  matrices[passed_on] = 1 - decay / z;
}
inline void prepare(const SignalsData::Block&, const double* numbers, double h, double* matrices) {
  if (numbers[kd] != 0) take_up(numbers[filter], h, matrices);
}

/// The output; where they are asked for, states now and derivatives by the inputs.
template <class T>
T output_and(const BlockCall<T>& c, T* integral_now, T* filtered_now, T* by) {
  const double* p = c.numbers;
  const T y = c.in[measured], r = c.in[setpoint], error = r - y, wanted = p[derivative_weight] * r - y;
  const bool moves = c.begun && c.h > 0;
  T before = c.begun ? c.before[integral] : T(p[integral_start]), trial = before;
  if (moves) trial = before + 0.5 * p[ki] * c.h * (error + c.first[setpoint] - c.first[measured]);
  T rest = p[kp] * (p[weight] * r - y), f = c.begun ? c.before[filtered] : wanted;
  double derivative = 0;  // of the derivative part, by w
  if (p[kd] != 0) {
    double passed = 0;
    if (moves) {
      double of_sampled[2];
      if (c.sampled()) take_up(p[filter], c.h, of_sampled);
      const double* m = c.sampled() ? of_sampled : c.matrices;
      const double decay = m[taken_up];
      passed = m[passed_on];
      const T w = p[derivative_weight] * c.first[setpoint] - c.first[measured];
      f = f + decay * (w - f) + passed * (wanted - w);
    }
    derivative = c.begun ? p[kd] / p[filter] * (1 - passed) : 0;
    rest += p[kd] / p[filter] * (wanted - f);
  }
  // Over a limit the integral may only come back.
  const T above = p[upper] - rest, below = p[lower] - rest;
  const T least = select(trial < before, trial, before), most = select(trial < before, before, trial);
  T kept = select(trial > above, select(above > least, above, least), trial);
  kept = select(trial < below, select(below < most, below, most), kept);
  const T free = rest + kept;
  const auto over = free > T(p[upper]), under = free < T(p[lower]);
  if (integral_now) *integral_now = kept;
  if (filtered_now) *filtered_now = f;
  if (by) {
    const double integrates = moves ? 0.5 * p[ki] * c.h : 0;
    const T at_limit(0);
    const auto limits = (trial > above) || (trial < below);
    by[measured] = select(limits, at_limit, T(-p[kp] - derivative - integrates));
    by[setpoint] =
        select(limits, at_limit, T(p[kp] * p[weight] + derivative * p[derivative_weight] + integrates));
  }
  return select(over, T(p[upper]), select(under, T(p[lower]), free));
}

template <class T>
void output(const BlockCall<T>& c) {
  c.out[0] = output_and<T>(c, nullptr, nullptr, nullptr);
}

template <class T>
void slope(const BlockCall<T>& c, T* by) {
  output_and<T>(c, nullptr, nullptr, by);
}

inline bool keep(const BlockCall<double>& c, double* states) {
  double i = 0, f = 0;
  output_and<double>(c, &i, &f, nullptr);
  states[integral] = i;
  states[filtered] = f;
  return false;
}

}  // namespace mimbre::blocks::pid

namespace mimbre::blocks {

struct Pid {
  static constexpr std::array<LawNumber, 9> numbers{{
      {.key = "kp", .about = "proportional gain", .otherwise = 0},
      {.key = "ki", .about = "integral gain, per s", .otherwise = 0},
      {.key = "kd", .about = "derivative gain, s", .otherwise = 0},
      {.key = "filter",
       .unit = "s",
       .about = "time constant of the derivative's filter",
       .otherwise = 0,
       .least = 0},
      {.key = "lower", .about = "limit of the output", .otherwise = -1e300},
      {.key = "upper", .about = "limit of the output", .otherwise = 1e300},
      {.key = "setpoint_weight", .about = "of the setpoint in the proportional part", .otherwise = 1},
      {.key = "derivative_weight", .about = "of the setpoint in the derivative part", .otherwise = 0},
      {.key = "integral", .about = "the integral part at the start", .otherwise = 0},
  }};
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    using namespace pid;
    const std::vector<double>& n = b.numbers;
    if (n[kd] != 0 && !(n[filter] > 0))
      item.error("kd needs a filter, the time constant over which it sees a rate: 'filter', some steps long");
    if (!(n[lower] < n[upper]))
      item.error(fmt::format("lower is {}, not below upper, {}", n[lower], n[upper]));
    if (n[kp] == 0 && n[ki] == 0 && n[kd] == 0) item.error("has no gain: kp, ki or kd");
  }
  static void compile(const spec::Block& b, const BlockPlan& plan) {
    plan.block.states = 2;
    plan.add_numbers(b.numbers);
    plan.signals.matrices += 2;
  }
  static constexpr BlockInfo info{.name = "pid",
                                  .key = "pid",
                                  .inputs = 2,
                                  .second = "setpoint",
                                  .numbers = numbers,
                                  .check = check,
                                  .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row{pid::output<T>, pid::slope<T>, nullptr, pid::keep, pid::prepare};
};

}  // namespace mimbre::blocks
