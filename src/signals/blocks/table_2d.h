#pragma once
#include "signals/blocks/block.h"
#include "signals/blocks/matrix_shape.h"

/// A table of two variables: values on a grid, between its lines linear in each variable. It goes on beyond
/// its ends as it ends.
namespace mimbre::blocks {

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

struct Table2d {
  static constexpr std::array<BlockMatrix, 3> matrices{{{"x"}, {"y"}, {"values"}}};
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    const Eigen::MatrixXd &x = b.matrices[0], &y = b.matrices[1], &values = b.matrices[2];
    for (const auto& [name, m] : {std::pair("x", &x), std::pair("y", &y)}) {
      if (m->rows() != 1 || m->cols() < 2)
        return item.error(fmt::format("{} is {}; a row of two places or more is needed", name, shape_of(*m)));
      for (Eigen::Index k = 1; k < m->cols(); ++k)
        if (!((*m)(0, k) > (*m)(0, k - 1)))
          return item.error(
              fmt::format("{} does not ascend: {} comes after {}", name, (*m)(0, k), (*m)(0, k - 1)));
    }
    check_shape(item, "values", values, x.cols(), y.cols());
  }
  static void compile(const spec::Block& b, const BlockPlan& plan) {
    for (const int axis : {0, 1})
      plan.signals.numbers.push_back(static_cast<double>(b.matrices[static_cast<std::size_t>(axis)].size()));
    for (const Eigen::MatrixXd& m : b.matrices) plan.add_numbers(m);
  }
  static constexpr BlockInfo info{.name = "table_2d",
                                  .key = "table",
                                  .list = true,
                                  .inputs = 2,
                                  .matrices = matrices,
                                  .check = check,
                                  .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row{table_2d::output<T>, table_2d::slope<T>, nullptr, table_2d::keep};
};

}  // namespace mimbre::blocks
