#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "linalg/block_sparse.h"
#include "math/choice.h"
#include "math/multiply_add.h"

/// The factorisation over any scalar, for the unit that instantiates it: block_factor.cpp does for double.
namespace mimbre::linalg {
namespace block_factor {
/// `n` scalars side by side. A scalar that is itself a pack needs no further vectors.
template <class T, int n>
struct Lanes {
  using Scalar = T;
  using Vector = T;
  static constexpr int count = 1;
};

template <int n>
struct Lanes<double, n> {
  using Scalar = double;
  typedef double Vector __attribute__((vector_size(n * sizeof(double))));
  typedef std::int64_t Index __attribute__((vector_size(n * sizeof(double))));
  static constexpr int count = n;
};

/// Products want wide vectors, substitution short ones: there each block of four columns waits for the one
/// before it.
template <class T>
using Wide = Lanes<T, kLanes>;
template <class T>
using Narrow = Lanes<T, std::min(kLanes, 4)>;

template <class L>
typename L::Vector load(const typename L::Scalar* p) {
  typename L::Vector v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

template <class L>
void store(typename L::Scalar* p, const typename L::Vector& v) {
  std::memcpy(p, &v, sizeof v);
}

/// Vector of value(0), value(1), …, built in a register: a vector load just after scalar stores would stall.
template <class L, class F>
typename L::Vector build(F&& value) {
  if constexpr (L::count == 1)
    return value(0);
  else if constexpr (L::count == 2)
    return typename L::Vector{value(0), value(1)};
  else
    return typename L::Vector{value(0), value(1), value(2), value(3)};
}

/// sum + a b by lanes, rounded once.
template <class L>
typename L::Vector add_product(const typename L::Vector& a, const typename L::Scalar& b,
                               const typename L::Vector& sum) {
  if constexpr (L::count == 1) {
    return multiply_add(a, b, sum);
  } else {
    typename L::Vector out;
    for (int i = 0; i < L::count; ++i) out[i] = __builtin_fma(a[i], b, sum[i]);
    return out;
  }
}
template <class L>
typename L::Vector add_product(const typename L::Vector& a, const typename L::Vector& b,
                               const typename L::Vector& sum) requires(L::count > 1) {
  typename L::Vector out;
  for (int i = 0; i < L::count; ++i) out[i] = __builtin_fma(a[i], b[i], sum[i]);
  return out;
}

/// Lanes [0, n) of a, the others of b.
template <class L>
typename L::Vector blend(int n, const typename L::Vector& a, const typename L::Vector& b) {
  if constexpr (L::count == 1) {
    return n > 0 ? a : b;
  } else {
    typename L::Index index;
    for (int i = 0; i < L::count; ++i) index[i] = i;
    return index < n ? a : b;
  }
}

template <class L>
typename L::Scalar lane_sum(const typename L::Vector& v) {
  typename L::Scalar a[L::count];
  std::memcpy(a, &v, sizeof v);
  for (int half = L::count / 2; half > 0; half /= 2)
    for (int i = 0; i < half; ++i) a[i] += a[i + half];
  return a[0];
}

/// Whether a pivot of this inverse can be divided by. Of a pack, whether all lanes' can: others are marked,
/// so that their solution is not a number, and leave the other lanes alone.
template <class T>
bool usable_inverse(T& inverse) {
  using std::abs, std::isfinite;
  const auto usable = abs(inverse) > T(0) && isfinite(inverse);
  if constexpr (is_pack<T>) inverse = select(usable, inverse, T(std::numeric_limits<double>::quiet_NaN()));
  return all(usable);
}

/// Calls f with 1 … 4 as a compile-time constant.
template <class F>
static decltype(auto) with_width(int width, F&& f) {
  switch (width) {
    case 1:
      return f(std::integral_constant<int, 1>{});
    case 2:
      return f(std::integral_constant<int, 2>{});
    case 3:
      return f(std::integral_constant<int, 3>{});
    default:
      return f(std::integral_constant<int, 4>{});
  }
}

/// One register tile of the product below: `vectors` vectors of rows (the last one may be cut), `width`
/// columns.
template <class T, int vectors, int width>
static void subtract_tile(T* target, int target_stride, const T* left, const T* right, int stride, int rows,
                          int depth) {
  constexpr int lanes = Wide<T>::count;
  typename Wide<T>::Vector sum[vectors][width] = {};
  for (int k = 0; k < depth; ++k, left += stride, right += stride)
    for (int v = 0; v < vectors; ++v) {
      const auto l = load<Wide<T>>(left + v * lanes);
      for (int c = 0; c < width; ++c) sum[v][c] = add_product<Wide<T>>(l, right[c], sum[v][c]);
    }
  for (int c = 0; c < width; ++c, target += target_stride) {
    for (int v = 0; v < vectors; ++v) {
      const auto old = load<Wide<T>>(target + v * lanes);
      const auto fresh = old - sum[v][c];
      store<Wide<T>>(target + v * lanes,
                     v + 1 < vectors ? fresh : blend<Wide<T>>(rows - v * lanes, fresh, old));
    }
  }
}

/// target(rows, width) -= left(rows, depth) right(width, depth)ᵀ. Reads, and writes back unchanged, up to a
/// vector beyond the last row.
template <class T, int width>
static void subtract_strip(T* target, int target_stride, const T* left, const T* right, int stride, int rows,
                           int depth) {
  constexpr int lanes = Wide<T>::count;
  for (; rows > lanes; rows -= 2 * lanes, target += 2 * lanes, left += 2 * lanes)
    subtract_tile<T, 2, width>(target, target_stride, left, right, stride, rows, depth);
  if (rows > 0) subtract_tile<T, 1, width>(target, target_stride, left, right, stride, rows, depth);
}

/// Factorises `width` columns from `first` on, which the columns before them have already updated: the small
/// diagonal block with scalars, then all rows at once. Fills L into the panel, L D into `scaled`, 1/D into
/// `inverse`.
template <class T, int width>
static void factor_columns(T* panel, T* scaled, T* inverse, int stride, int first) {
  constexpr int lanes = Wide<T>::count;
  T a[width][width], l[width][width];
  for (int c = 0; c < width; ++c)
    for (int r = c; r < width; ++r) a[r][c] = panel[first + r + c * stride];
  for (int k = 0; k < width; ++k) {
    inverse[k] = T(1) / a[k][k];
    for (int r = k + 1; r < width; ++r) l[r][k] = a[r][k] * inverse[k];
    for (int c = k + 1; c < width; ++c)
      for (int r = c; r < width; ++r) a[r][c] -= a[r][k] * l[c][k];
  }
  for (int row = first / lanes * lanes; row < stride; row += lanes) {
    typename Wide<T>::Vector x[width];
    for (int c = 0; c < width; ++c) {
      x[c] = load<Wide<T>>(panel + row + c * stride);
      for (int k = 0; k < c; ++k) x[c] = add_product<Wide<T>>(x[k], T(-l[c][k]), x[c]);
      store<Wide<T>>(scaled + row + c * stride, x[c]);
      store<Wide<T>>(panel + row + c * stride, x[c] * inverse[c]);
    }
  }
}

}  // namespace block_factor

template <class T>
BlockFactor<T>::BlockFactor(const BlockSymbolic& symbolic) : symbolic_(&symbolic) {
  int stride = 0, columns = 0;
  for (const Panel& panel : symbolic.panels()) {
    stride = std::max(stride, panel.stride);
    columns = std::max(columns, panel.columns);
  }
  // Rectangles are handled in whole vectors, which may reach past the end.
  values_.resize(symbolic.value_count() + 2 * kLanes);
  scaled_.resize(static_cast<std::size_t>(stride) * columns);
  inverse_.resize(symbolic.size());
  column_.resize(stride);
}

template <class T>
void BlockFactor<T>::set_zero() noexcept {
  std::fill(values_.begin(), values_.end(), T(0));
}

template <class T>
FactorStatus BlockFactor<T>::factor() noexcept {
  using namespace block_factor;
  FactorStatus status;
  constexpr int lanes = Wide<T>::count;
  T* const scaled = scaled_.data();
  for (const Panel& p : symbolic_->panels()) {
    T* const panel = values_.data() + p.offset;
    T* const inverse = inverse_.data() + p.first;
    for (int j = 0; j < p.columns; j += 4) {
      const int width = std::min(4, p.columns - j), row = j / lanes * lanes;
      with_width(width, [&](auto w) {
        T* const column = panel + j * p.stride;
        if (j > 0)
          subtract_strip<T, w>(column + row, p.stride, panel + row, scaled + j, p.stride, p.stride - row, j);
        factor_columns<T, w>(column, scaled + j * p.stride, inverse + j, p.stride, j);
      });
      for (int k = j; k < j + width; ++k)
        if (!usable_inverse(inverse[k]) && status.ok()) {
          status.unknown = symbolic_->unknowns()[p.first + k];
          // The other lanes of a pack go on.
          if constexpr (!is_pack<T>) return status;
        }
    }
    for (int i = p.first_update; i < p.last_update; ++i) {
      const PanelUpdate& u = symbolic_->updates()[i];
      for (int j = 0; j < u.columns; j += 4) {
        const int row = u.row == u.column ? j / lanes * lanes : 0;  // nothing is needed above a diagonal
        with_width(std::min(4, u.columns - j), [&](auto w) {
          subtract_strip<T, w>(values_.data() + u.target + j * u.target_stride + row, u.target_stride,
                               panel + u.row + row, scaled + u.column + j, p.stride, u.rows - row, p.columns);
        });
      }
    }
  }
  return status;
}

template <class T>
void BlockFactor<T>::solve(T* x) const noexcept {
  using namespace block_factor;
  using L = Narrow<T>;
  const auto& panels = symbolic_->panels();
  T* const column = column_.data();

  // L z = b, panel by panel: `column` collects what its columns contribute to each row.
  for (const Panel& p : panels) {
    const int* const rows = symbolic_->rows().data() + p.first_row;
    const int* const own = symbolic_->unknowns().data() + p.first;
    for (int row = 0; row < p.stride; row += L::count) store<L>(column + row, typename L::Vector{});
    for (int j = 0; j < p.columns; j += 4) {
      with_width(std::min(4, p.columns - j), [&](auto width) {
        const T* const l = values_.data() + p.offset + j * p.stride;
        T s[width];
        for (int c = 0; c < width; ++c) {
          s[c] = x[own[j + c]] - column[j + c];
          for (int k = 0; k < c; ++k) s[c] = multiply_add(T(-l[j + c + k * p.stride]), s[k], s[c]);
        }
        for (int c = 0; c < width; ++c) x[own[j + c]] = s[c];
        for (int row = j + 4; row < p.stride; row += L::count) {
          auto sum = load<L>(column + row);
          for (int c = 0; c < width; ++c) sum = add_product<L>(load<L>(l + row + c * p.stride), s[c], sum);
          store<L>(column + row, sum);
        }
      });
    }
    for (int row = p.below; row < p.stride; ++row) x[rows[row - p.below]] -= column[row];
  }

  // Lᵀ x = D⁻¹ z, backwards: `column` holds the solution in the panel's rows.
  for (std::size_t i = panels.size(); i-- > 0;) {
    const Panel& p = panels[i];
    const int* const rows = symbolic_->rows().data() + p.first_row;
    const T* const inverse = inverse_.data() + p.first;
    const int* const own = symbolic_->unknowns().data() + p.first;
    for (int row = p.below; row < p.stride; row += L::count)
      store<L>(column + row, build<L>([&](int k) { return x[rows[row - p.below + k]]; }));
    for (int j = (p.columns - 1) / 4 * 4; j >= 0; j -= 4) {
      with_width(std::min(4, p.columns - j), [&](auto width) {
        const T* const l = values_.data() + p.offset + j * p.stride;
        typename L::Vector dot[width] = {};
        for (int row = j + 4; row < p.stride; row += L::count) {
          const auto known = load<L>(column + row);
          for (int c = 0; c < width; ++c)
            dot[c] = add_product<L>(load<L>(l + row + c * p.stride), known, dot[c]);
        }
        T s[4] = {};
        for (int c = width - 1; c >= 0; --c) {
          s[c] = x[own[j + c]] * inverse[j + c] - lane_sum<L>(dot[c]);
          for (int k = c + 1; k < width; ++k) s[c] = multiply_add(T(-l[j + k + c * p.stride]), s[k], s[c]);
          x[own[j + c]] = s[c];
        }
        for (int c = 0; c < 4; c += L::count)
          store<L>(column + j + c, build<L>([&](int k) { return s[c + k]; }));
      });
    }
  }
}

template <class T>
void multiply(const BlockSymbolic& symbolic, const T* values, const T* x, T* y) {
  std::fill(y, y + symbolic.size(), T(0));
  for (int i = 0; i < symbolic.blocks(); ++i) {
    for (int j = 0; j <= i; ++j) {
      if (!symbolic.coupled(i, j)) continue;
      const BlockPlace place = symbolic.place(i, j);
      for (int r = symbolic.start(i); r < symbolic.start(i + 1); ++r) {
        for (int c = symbolic.start(j); c < std::min(symbolic.start(j + 1), r + 1); ++c) {
          const T& a = values[place.offset + (r - symbolic.start(i)) * place.row_stride +
                              (c - symbolic.start(j)) * place.col_stride];
          y[r] = multiply_add(a, x[c], y[r]);
          if (r != c) y[c] = multiply_add(a, x[r], y[c]);
        }
      }
    }
  }
}

template <class T>
void to_dense(const BlockSymbolic& symbolic, const T* values, T* out) {
  const std::ptrdiff_t n = symbolic.size();
  std::fill(out, out + n * n, T(0));
  for (int i = 0; i < symbolic.blocks(); ++i) {
    for (int j = 0; j <= i; ++j) {
      if (!symbolic.coupled(i, j)) continue;
      const BlockPlace place = symbolic.place(i, j);
      for (int c = symbolic.start(j); c < symbolic.start(j + 1); ++c) {
        for (int r = i == j ? c : symbolic.start(i); r < symbolic.start(i + 1); ++r)
          out[r + n * c] = out[c + n * r] = values[place.offset + (r - symbolic.start(i)) * place.row_stride +
                                                   (c - symbolic.start(j)) * place.col_stride];
      }
    }
  }
}

}  // namespace mimbre::linalg
