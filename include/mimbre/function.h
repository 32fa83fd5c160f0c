#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace mimbre {

class Expression;
class FunctionData;
struct FunctionParts;  ///< reads and writes what functions are made of (src/spec/function_parts.h)

/// A value with its first and second derivative by one variable.
struct Jet {
  double value, first, second;
};
/// A value with its derivatives by two variables.
struct Gradient {
  double value, by_first, by_second;
};

/// A scalar function of one scalar: value, first and second derivative, and antiderivative (for the energy a
/// force law stores). Used for force laws (of length or rate), loads and drives (of time). Immutable after it
/// is made; evaluating it neither allocates nor throws nor locks, and what is not finite goes through. Any
/// number of threads may share it. Outside its first and last piece a piecewise function goes on as the
/// polynomial of that piece. Bad arguments of the makers:
/// InputError without mark.
///
/// Kinds: polynomial pieces (constants, lines, polynomials), tables (linear or monotone cubic between points,
/// made into pieces when constructed; beyond the ends the end slope goes on), and expressions in one
/// variable.
class Function {
 public:
  Function() = default;  ///< the zero function

  static Function constant(double value);
  /// slope * (x - zero)
  static Function linear(double slope, double zero = 0);
  /// Σ coefficients[k] x^k
  static Function polynomial(std::vector<double> coefficients);
  /// Piece k holds on [breaks[k-1], breaks[k]) with Σ c[j] x^j in the ABSOLUTE variable x; breaks ascending,
  /// one fewer than pieces. A point on a break belongs to the piece at its right.
  static Function piecewise(std::vector<double> breaks, std::vector<std::vector<double>> pieces);
  /// The same with Σ c[j] (x − origins[k])^j, which is accurate far from x = 0.
  static Function piecewise(const std::vector<double>& breaks, const std::vector<double>& origins,
                            std::vector<std::vector<double>> pieces);
  enum class Interpolation { linear, cubic };
  /// Through (x, y); x must not decrease, and may repeat once to make a jump (linear only). At least two
  /// points. Cubic: Fritsch–Carlson, monotone where the points are. A linear table with a jump at an end is
  /// level beyond it.
  static Function table(std::vector<double> x, std::vector<double> y, Interpolation interpolation);
  /// An expression in the variable called `variable` ("sin(2*pi*t)"): operators + - * / ^, comparison, ?:,
  /// &&, || and the usual functions (docs/model-file.md), and `pi`. Derivatives are exact, those of the
  /// branch that `?:` takes and the mean of both sides at a kink of abs, min or max; antiderivative by
  /// Gauss–Legendre quadrature: 80 points from 0 to x. Throws InputError (without mark) when it does not
  /// parse, has more than 10 000 characters or 100 nested levels, or is finite at none of 0, ±0.01, ±0.1, ±1,
  /// ±10.
  static Function expression(const std::string& text, const std::string& variable);
  /// The function repeated with a period: f(x) = f(x0 + (x - x0) mod period). Piecewise kinds only.
  Function repeated(double start, double period) const;

  double value(double x) const;
  double derivative(double x) const;
  double second_derivative(double x) const;
  /// All three in one pass.
  Jet jet(double x) const;
  /// Value and derivative in one pass.
  std::pair<double, double> tangent(double x) const;
  /// ∫ f from 0 to x for piecewise kinds and expressions. (An expression that is not finite at 0, as 1/x:
  /// from the first of 1, -1, 0.1, -0.1, … where it is.)
  double antiderivative(double x) const;
  /// start + ∫ f from 0 to x, with f as its exact derivative: a drive that is given by its speed. Of
  /// piecewise kinds exact; of an expression to about 1e-13 of ∫|f| for x in [0, end], kinks and jumps
  /// included, and nearly so for some multiples of `end`.
  Function integral(double start, double end) const;
  /// Only for the default-made function; constant(0) is not meant.
  bool is_zero() const { return !data_; }
  /// What is evaluated, as models keep it.
  const FunctionData& data() const;

 private:
  friend FunctionParts;
  explicit Function(FunctionData data);
  std::shared_ptr<const FunctionData> data_;
};

/// A scalar function of several scalars, from an expression: laws that do not split into functions of one,
/// and signals. Same guarantees as Function.
class Formula {
 public:
  static constexpr std::size_t most_variables = 64;
  Formula() = default;
  /// Throws InputError (without mark) as Function::expression does, or for more than 64 variables.
  static Formula expression(const std::string& text, const std::vector<std::string>& variables);
  /// x: one value per variable, in their order.
  double value(const double* x) const;
  /// The value with its derivatives by what the variables depend on: jets and gradients, one per variable.
  Jet jet(const Jet* x) const;
  Gradient gradient(const Gradient* x) const;
  /// ∂/∂x[0] and ∂/∂x[1], exact.
  std::pair<double, double> derivatives(const double* x) const;
  std::size_t variables() const;
  bool is_zero() const { return !data_; }
  /// What is evaluated, as models keep it.
  const Expression& data() const;

 private:
  friend FunctionParts;
  std::shared_ptr<const Expression> data_;
};

}  // namespace mimbre
