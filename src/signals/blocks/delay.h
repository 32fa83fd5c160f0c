#pragma once
#include <algorithm>
#include <cmath>

#include "signals/blocks/block.h"

/// A transport delay, y(t) = u(t − τ), from a list of past points (time, value) with straight lines between
/// them; before its first point the value of that. Points closer to each other than what the list can hold
/// over τ are thinned out.
namespace mimbre::blocks::delay {

constexpr int time = 0;  ///< numbers: τ, s
// States: how many points there are and where the newest is, then the points, times and values.
constexpr int count = 0, newest = 1, first_point = 2;

constexpr int states_of(int points) { return first_point + 2 * points; }
inline int room(int states) { return (states - first_point) / 2; }

/// Where in the list a moment lies in a lane: between two places, and how far.
struct Between {
  int a, b;
  double share;
};

template <class T>
Between find(const BlockCall<T>& c, double moment, int lane) {
  const int n = room(c.states), points = static_cast<int>(in_lane(c.before[count], lane)),
            last = static_cast<int>(in_lane(c.before[newest], lane));
  const auto place = [&](int k) { return first_point + 2 * ((last - (points - 1 - k) + n) % n); };
  const auto at = [&](int k) { return in_lane(c.before[place(k)], lane); };
  int low = 0,
      high = points;  // times of points below `low` are not after the moment, from `high` on they are
  while (low < high) {
    const int middle = (low + high) / 2;
    if (at(middle) <= moment)
      low = middle + 1;
    else
      high = middle;
  }
  if (low == 0) return {place(0), place(0), 0};
  if (low == points) return {place(points - 1), place(points - 1), 0};
  return {place(low - 1), place(low), (moment - at(low - 1)) / (at(low) - at(low - 1))};
}

/// Share of the input of now in the output: where the delay is shorter than the step.
template <class T>
double share_of_now(const BlockCall<T>& c) {
  const double moment = c.time - c.numbers[time], start = c.time - c.h;
  return c.h > 0 && moment > start ? (moment - start) / c.h : 0;
}

template <class T>
void output(const BlockCall<T>& c) {
  if (!c.begun) {
    c.out[0] = c.in[0];
    return;
  }
  if (const double share = c.sampled() ? 0 : share_of_now(c); share > 0) {
    c.out[0] = c.first[0] + share * (c.in[0] - c.first[0]);
    return;
  }
  for (int lane = 0; lane < lane_count<T>; ++lane) {
    const Between p = find(c, c.time - c.numbers[time], lane);
    const T &a = c.before[p.a + 1], &b = c.before[p.b + 1];
    put_in_lane(c.out[0], T(a + p.share * (b - a)), lane);
  }
}

template <class T>
void slope(const BlockCall<T>& c, T* by) {
  by[0] = T(!c.begun ? 1 : c.sampled() ? 0 : share_of_now(c));
}

inline bool keep(const BlockCall<double>& c, double* states) {
  const int n = room(c.states);
  int points = c.begun ? static_cast<int>(states[count]) : 0,
      last = points > 0 ? static_cast<int>(states[newest]) : 0;
  const auto at = [&](int back) { return states + first_point + 2 * ((last - back + n) % n); };
  // Nothing but a jump is passed on twice for one moment.
  if (points > 0 && at(0)[0] == c.time && at(0)[1] == c.in[0]) return false;
  const bool jumps = points > 0 && at(0)[0] == c.time;
  const bool close = points > 1 && !jumps && c.time - at(1)[0] < 3 * c.numbers[time] / n;
  if (!close) {
    last = points > 0 ? (last + 1) % n : 0;
    points = std::min(points + 1, n);
  }
  at(0)[0] = c.time;
  at(0)[1] = c.in[0];
  states[count] = points;
  states[newest] = last;
  return false;
}

}  // namespace mimbre::blocks::delay

namespace mimbre::blocks {

struct Delay {
  static constexpr std::array<LawNumber, 1> numbers{{
      {.key = "time", .unit = "s", .about = "by which it comes later", .above = 0},
  }};
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    if (!(b.every > 0)) return;
    const double time = b.numbers[delay::time], instants = time / b.every;
    if (std::abs(instants - std::round(instants)) > 1e-6 * instants)
      item.error(fmt::format("time is {}, no whole number of 'every', {}", time, b.every));
  }
  static bool feeds_through(const spec::Block&) { return false; }
  /// Points: three and more per step, so that halved steps and jumps at their ends fit, but never more than
  /// 4096; and room for shorter steps, which the model does not know.
  static void compile(const spec::Block& b, const BlockPlan& plan) {
    const double each = b.every > 0 ? b.every : plan.step, least = b.every > 0 ? 0 : 1024;
    plan.block.states = delay::states_of(
        static_cast<int>(std::clamp(16 + 4 * std::ceil(b.numbers[delay::time] / each), least, 4096.0)));
    plan.add_numbers(b.numbers);
  }
  static constexpr BlockInfo info{.name = "delay",
                                  .key = "delay",
                                  .numbers = numbers,
                                  .check = check,
                                  .feeds_through = feeds_through,
                                  .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row{delay::output<T>, delay::slope<T>, nullptr, delay::keep};
};

}  // namespace mimbre::blocks
