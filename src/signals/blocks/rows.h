#pragma once
#include "compile/compiled.h"
#include "signals/blocks/delay.h"
#include "signals/blocks/hysteresis.h"
#include "signals/blocks/linear.h"
#include "signals/blocks/noise.h"
#include "signals/blocks/pid.h"
#include "signals/blocks/rate_limit.h"
#include "signals/blocks/table.h"
#include "spec/block_types.h"

namespace mimbre {

inline bool is_linear(const SignalsData::Block& b) {
  const auto type = static_cast<BlockType>(b.type);
  return type == BlockType::transfer_function || type == BlockType::state_space;
}

}  // namespace mimbre

namespace mimbre::blocks {

/// In the order of block_table.
template <class T>
constexpr std::array<BlockRow<T>, block_table.size()> rows{{
    {pid::output, pid::slope, nullptr, pid::keep},
    {linear::output, linear::slope, linear::jets, linear::keep},
    {linear::output, linear::slope, linear::jets, linear::keep},
    {table::output, table::slope, nullptr, table::keep},
    {table_2d::output, table_2d::slope, nullptr, table_2d::keep},
    {rate_limit::output, rate_limit::slope, nullptr, rate_limit::keep},
    {delay::output, delay::slope, nullptr, delay::keep},
    {hysteresis::output, hysteresis::slope, nullptr, hysteresis::keep},
    {noise::output, noise::slope, nullptr, noise::keep},
}};

}  // namespace mimbre::blocks
