#pragma once
#include <vector>

#include "base/array.h"

namespace mimbre {

struct FunctionParts;

/// Polynomial pieces in flat arrays, ready to be evaluated in an inner loop. Piece k holds on
/// [breaks[k-1], breaks[k]) and is Σ c[j] (x - origin[k])^j; the first and last go on beyond the ends.
class Pieces {
 public:
  struct Piece {
    double origin = 0;
    std::vector<double> coefficients;
  };

  Pieces() = default;  ///< none: of no use
  /// Throws InputError when breaks do not ascend strictly, a number is not finite or the sizes do not fit.
  Pieces(const std::vector<double>& breaks, const std::vector<Piece>& pieces);

  /// The same pieces with x wrapped into [start, start + period). Throws InputError for a bad period or when
  /// they are wrapped already.
  Pieces repeated(double start, double period) const;

  double value(double x) const;
  double derivative(double x) const;
  double second_derivative(double x) const;
  double antiderivative(double x) const;

  struct Wrap {
    double start = 0, period = 0;  ///< period 0: not wrapped
    double integral = 0;           ///< over one period
  };
  /// What it evaluates, for code that does the same elsewhere: piece k has coefficients [first[k], first[k +
  /// 1]).
  struct Arrays {
    const Array<double>&breaks, &origins;
    const Array<std::size_t>& first;
    const Array<double>&coefficients, &integral_at_origin;
    double integral_at_zero;
    Wrap wrap;
  };
  Arrays arrays() const {
    return {breaks_, origins_, first_, coefficients_, integral_at_origin_, integral_at_zero_, wrap_};
  }

 private:
  friend FunctionParts;
  struct Wrapped {
    double x;      ///< in [start, start + period)
    double turns;  ///< periods taken off
  };
  Wrapped wrapped(double x) const;
  std::size_t piece_at(double x) const;
  double integral_from_origin(std::size_t k, double x) const;
  double integrated(double x) const;  ///< unwrapped, continuous over breaks, up to a constant

  Array<double> breaks_;
  Array<double> origins_;             ///< of piece k
  Array<std::size_t> first_;          ///< piece k: coefficients_[first_[k] .. first_[k+1])
  Array<double> coefficients_;        ///< ascending powers, every piece at least one
  Array<double> integrals_;           ///< coefficients_[i] / (its power + 1)
  Array<double> integral_at_origin_;  ///< integration constant of piece k
  double integral_at_zero_ = 0;       ///< so that antiderivative(0) = 0
  Wrap wrap_;
};

/// Straight lines through the points; a repeated x is a jump, and beyond a jump at an end the value stays.
Pieces linear_table(const std::vector<double>& x, const std::vector<double>& y);

/// Cubic through the points, monotone where the points are (Fritsch and Carlson, SIAM J. Numer. Anal. 17,
/// 1980, with the slope of the parabola through three neighbours as first guess); straight beyond the ends.
Pieces cubic_table(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace mimbre
