#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace mimbre {

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

 private:
  struct Compiled;
  std::unique_ptr<Compiled> compiled_;
};

}  // namespace mimbre
