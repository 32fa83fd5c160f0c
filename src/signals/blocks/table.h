#pragma once
#include "signals/blocks/block.h"

/// Tables of one variable (a function of points), and of two: values on a grid, between its lines linear in
/// each variable. Both go on beyond their ends as they end.
namespace mimbre::blocks {

namespace table {

template <class T>
void output(const BlockCall<T>& c) {
  c.out[0] = value_at(*c.function, c.in[0]);
}

template <class T>
void slope(const BlockCall<T>& c, T* by) {
  by[0] = tangent_at(*c.function, c.in[0]).second;
}

inline bool keep(const BlockCall<double>&, double*) { return false; }

}  // namespace table

namespace table_2d {

// Numbers: how many lines in x and in y there are, their places, then the values by rows of x.
constexpr int lines_x = 0, lines_y = 1, first_line = 2;

/// The last of the lines that has another behind it and is not after x; the first where all are.
inline int cell(const double* lines, int count, double x) {
  int k = 0;
  while (k + 2 < count && x >= lines[k + 1]) ++k;
  return k;
}

/// Value and derivatives.
template <class T>
std::array<T, 3> look_up(const BlockCall<T>& c) {
  const int nx = static_cast<int>(c.numbers[lines_x]), ny = static_cast<int>(c.numbers[lines_y]);
  const double *x = c.numbers + first_line, *y = x + nx, *value = y + ny;
  std::array<T, 3> out;
  for (int lane = 0; lane < lane_count<T>; ++lane) {
    const int i = cell(x, nx, in_lane(c.in[0], lane)), j = cell(y, ny, in_lane(c.in[1], lane));
    const double width = x[i + 1] - x[i], height = y[j + 1] - y[j];
    const T s = (c.in[0] - x[i]) / width, t = (c.in[1] - y[j]) / height;
    const double *low = value + i * ny + j, *high = low + ny;
    const T at_low = low[0] + t * (low[1] - low[0]), at_high = high[0] + t * (high[1] - high[0]);
    put_in_lane(out[0], T(at_low + s * (at_high - at_low)), lane);
    put_in_lane(out[1], T((at_high - at_low) / width), lane);
    put_in_lane(out[2], T(((1 - s) * (low[1] - low[0]) + s * (high[1] - high[0])) / height), lane);
  }
  return out;
}

template <class T>
void output(const BlockCall<T>& c) {
  c.out[0] = look_up(c)[0];
}

template <class T>
void slope(const BlockCall<T>& c, T* by) {
  const auto found = look_up(c);
  by[0] = found[1];
  by[1] = found[2];
}

inline bool keep(const BlockCall<double>&, double*) { return false; }

}  // namespace table_2d

}  // namespace mimbre::blocks
