#pragma once
#include <array>

#include "signals/blocks/block.h"
#include "signals/blocks/delay.h"
#include "signals/blocks/fmu.h"
#include "signals/blocks/hysteresis.h"
#include "signals/blocks/noise.h"
#include "signals/blocks/pid.h"
#include "signals/blocks/rate_limit.h"
#include "signals/blocks/state_space.h"
#include "signals/blocks/table_1d.h"
#include "signals/blocks/table_2d.h"
#include "signals/blocks/transfer_function.h"

/// The blocks. A new one is a file like rate_limit.h and its name in this list.
namespace mimbre::blocks {

template <class... Types>
struct BlockList {};
/// In the order of SignalsData::Block::type.
using Blocks =
    BlockList<Pid, TransferFunction, StateSpace, Table, Table2d, RateLimit, Delay, Hysteresis, Noise, Fmu>;

template <class T, class... Type>
constexpr std::array<BlockRow<T>, sizeof...(Type)> rows_of(BlockList<Type...>) {
  return {{Type::template row<T>...}};
}
template <class T>
constexpr auto rows = rows_of<T>(Blocks());

template <class... Type>
constexpr std::array<const BlockInfo*, sizeof...(Type)> infos_of(BlockList<Type...>) {
  return {&Type::info...};
}
inline constexpr auto infos = infos_of(Blocks());

}  // namespace mimbre::blocks
