#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace mimbre {

/// Which way each `?:` of an expression went.
struct Choices {
  static constexpr std::size_t most = 64;  ///< further ones go their own way
  std::array<signed char, most> taken{};   ///< 1 and 2: no and yes; 0: not met
};

/// A formula in up to three variables, compiled once. Evaluation neither allocates nor throws. Threads may
/// share an expression: the compiled form has one stack and one set of variables, so they take turns (a spin
/// lock; one evaluation takes some tens of nanoseconds). Give each thread its own model where that matters.
class Expression {
 public:
  /// Throws InputError when the text is not a formula in these variables.
  Expression(const std::string& text, std::vector<std::string> variables);
  ~Expression();
  Expression(const Expression&) = delete;
  Expression& operator=(const Expression&) = delete;

  static constexpr std::size_t most_variables = 3;
  /// One value per variable, in their order; surplus values are ignored.
  double value(std::span<const double, most_variables> values) const;
  /// Whether there is any `?:`.
  bool has_choices() const;
  /// How the conditions of `?:` turn out there.
  Choices choices(std::span<const double, most_variables> values) const;
  /// The value with these choices, however the conditions turn out: the branch that holds elsewhere,
  /// continued.
  double value(std::span<const double, most_variables> values, const Choices& choices) const;

 private:
  struct Compiled;
  double evaluate(std::span<const double, most_variables> values) const;
  std::unique_ptr<Compiled> compiled_;
};

}  // namespace mimbre
