#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/array.h"

namespace mimbre {

/// A formula as instructions for a machine with a stack. Jumps only lead forward, so that one pass ends.
struct ExpressionProgram {
  enum class Op : std::uint8_t {
    // What is put on the stack: `number`, variable `at`.
    number,
    variable,
    // Of the top of the stack.
    negative,
    square,
    cube,
    fourth,
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    sinh,
    cosh,
    tanh,
    asinh,
    acosh,
    atanh,
    log2,
    log10,
    ln,
    exp,
    sqrt,
    sign,
    rint,
    abs,
    divided_by_number,
    // Of the two on top.
    add,
    subtract,
    multiply,
    divide,
    power,
    atan2,
    min,
    max,
    less,
    greater,
    less_or_equal,
    greater_or_equal,
    equal,
    not_equal,
    both,
    either,
    // To instruction `at`: always; where the top, which is taken off, is 0.
    jump,
    jump_if_zero
  };
  struct Instruction {
    Op op;
    std::uint32_t at = 0;
    double number = 0;
  };
  static constexpr std::size_t deepest_stack = 256;

  Array<Instruction> code;
  std::size_t stack = 0;  ///< its largest depth
};

/// The program of a formula in the named variables: operators + - * / ^ (from the right), comparisons, &&,
/// ||, `?:`, functions and the constants pi, _pi and _e. Throws std::invalid_argument that says what is
/// wrong. Hostile texts cost no more than long ones.
ExpressionProgram parse_expression(const std::string& text, const std::vector<std::string>& variables);

}  // namespace mimbre
