#pragma once
#include <array>
#include <span>
#include <string_view>

#include "mimbre/spec.h"
#include "spec/force_law.h"

/// The properties of the types of blocks besides their equations, which are in src/signals/blocks: the
/// table here and that in signals/blocks/rows.h have the same rows.
namespace mimbre {

/// Of linear blocks; others have no more inputs and outputs either.
constexpr int most_block_inputs = 8, most_block_outputs = 8, most_block_states = 16;
/// Numbers of a linear block of n states and m inputs that the length of a step decides.
constexpr int step_matrices(int n, int m) { return n * (n + 2 * m); }
/// States of a delay: how many points there are and where the newest is, then the points, times and values.
constexpr int delay_states(int points) { return 2 + 2 * points; }

struct BlockInfo {
  std::string_view name;                    ///< in spec::Block::type
  std::string_view key;                     ///< in the model file: of its input, or of what it is
  std::span<const LawNumber> numbers = {};  ///< spec::Block::numbers
  int inputs = 1;                           ///< −1: as many as its matrices have
  /// spec::Block::matrices, by their keys.
  std::span<const std::string_view> matrices = {};
  bool continuous = true;  ///< it may be; sampled all of them may
};

/// The rows, and so SignalsData::Block::type.
enum class BlockType {
  pid,
  transfer_function,
  state_space,
  table,
  table_2d,
  rate_limit,
  delay,
  hysteresis,
  noise
};

constexpr std::array<LawNumber, 9> pid_numbers{{
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

constexpr std::array<LawNumber, 2> rate_limit_numbers{{
    {.key = "rising", .about = "largest rate upwards, per s", .above = 0},
    {.key = "falling", .about = "largest rate downwards, per s, below 0", .most = -1e-300},
}};

constexpr std::array<LawNumber, 1> delay_numbers{{
    {.key = "time", .unit = "s", .about = "by which it comes later", .above = 0},
}};

constexpr std::array<LawNumber, 5> hysteresis_numbers{{
    {.key = "rises_at", .about = "from which on it is high"},
    {.key = "falls_at", .about = "down to which it stays high"},
    {.key = "low", .about = "what it gives when it is low", .otherwise = 0},
    {.key = "high", .about = "what it gives when it is high", .otherwise = 1},
    {.key = "starts_high",
     .about = "whether it is high at the start, between the thresholds",
     .otherwise = 0,
     .least = 0,
     .most = 1},
}};

constexpr std::array<LawNumber, 4> noise_numbers{{
    {.key = "mean", .otherwise = 0},
    {.key = "deviation", .about = "standard deviation", .otherwise = 1, .least = 0},
    {.key = "seed", .about = "a whole number", .otherwise = 0, .least = 0, .most = 9007199254740992.0},
    {.key = "uniform", .about = "1: uniform; 0: normal", .otherwise = 0, .least = 0, .most = 1},
}};

constexpr std::array<std::string_view, 2> transfer_function_matrices{{"numerator", "denominator"}};
constexpr std::array<std::string_view, 5> state_space_matrices{{"A", "B", "C", "D", "initial"}};
constexpr std::array<std::string_view, 3> table_2d_matrices{{"x", "y", "values"}};

// clang-format off
constexpr std::array<BlockInfo, 9> block_table{{
    {"pid", "pid", pid_numbers, 2},
    {"transfer_function", "transfer_function", {}, 1, transfer_function_matrices},
    {"state_space", "state_space", {}, -1, state_space_matrices},
    {"table", "table"},
    {"table_2d", "table", {}, 2, table_2d_matrices},
    {"rate_limit", "rate_limit", rate_limit_numbers},
    {"delay", "delay", delay_numbers},
    {"hysteresis", "hysteresis", hysteresis_numbers},
    {"noise", "noise", noise_numbers, 0, {}, false},
}};
// clang-format on

/// How many signals a block makes: those of a state-space block are the rows of its C.
inline int output_count(const spec::Block& block) {
  return block.type == "state_space" && block.matrices.size() > 2 ? static_cast<int>(block.matrices[2].rows())
                                                                  : 1;
}

/// -1: there is none of that name.
constexpr int find_block(std::string_view name) {
  for (std::size_t k = 0; k < block_table.size(); ++k)
    if (block_table[k].name == name) return static_cast<int>(k);
  return -1;
}

}  // namespace mimbre
