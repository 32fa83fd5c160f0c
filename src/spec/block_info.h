#pragma once
#include <span>
#include <string_view>
#include <vector>

#include "mimbre/spec.h"
#include "spec/force_law.h"

/// The description of a type of block: all but its equations. Each is one file of src/signals/blocks, which
/// owns both; signals/blocks/table.h lists them.
namespace mimbre {

struct BlockPlan;
namespace checks {
class CheckedItem;
}

/// Of blocks whose matrices say how many they have; others have no more either.
constexpr int most_block_inputs = 8, most_block_outputs = 8, most_block_states = 16;

/// A matrix of a block by its key in the model file.
struct BlockMatrix {
  std::string_view key;
  bool optional = false;  ///< empty where it is not given
  bool column = false;    ///< numbers in a row of the file are a column
};

struct BlockInfo {
  std::string_view name;         ///< in spec::Block::type
  std::string_view key;          ///< in the model file: of its input, or of what it is
  bool list = false;             ///< where two types have a key: this one has a list of inputs there
  int inputs = 1;                ///< −1: as many as its matrices say
  std::string_view second = {};  ///< key of its second input, 0 where it is not given
  std::span<const LawNumber> numbers = {};     ///< spec::Block::numbers
  std::span<const BlockMatrix> matrices = {};  ///< spec::Block::matrices
  bool points = false;                         ///< it has a function of points
  /// What stands at its key in place of an input; its number is the last of `numbers`.
  std::span<const char* const> words = {};
  bool named_outputs = false;  ///< it may have several outputs, each of which has a name
  bool continuous = true;      ///< it may be; sampled all of them may
  bool outside = false;        ///< code from elsewhere computes it (spec::Block::outside)
  bool relay = false;          ///< a continuous one switches between steps, at a threshold
  /// Its outputs have derivatives by time where its inputs have.
  bool smooth = false;

  /// Numbers that follow from others where they are not given.
  void (*complete)(std::vector<double>& numbers) = nullptr;
  /// How many outputs it has; null: 1.
  int (*outputs)(const spec::Block&) = nullptr;
  /// Faults of numbers and matrices that are right one by one.
  void (*check)(const spec::Block&, const checks::CheckedItem&) = nullptr;
  /// Whether its outputs follow its inputs at the same instant, so that it closes no loop; null: they do.
  bool (*feeds_through)(const spec::Block&) = nullptr;
  /// Its number of states, and its constants; null: it has no states, and its numbers are its constants.
  void (*compile)(const spec::Block&, const BlockPlan&) = nullptr;
};

/// All of them, in the order of SignalsData::Block::type.
std::span<const BlockInfo* const> all_blocks();
const BlockInfo& block_info(int type);
/// -1: there is none of that name.
int find_block(std::string_view name);

/// How many signals a block makes.
inline int output_count(const spec::Block& block) {
  const int type = find_block(block.type);
  const BlockInfo* info = type < 0 ? nullptr : &block_info(type);
  return info && info->outputs ? info->outputs(block) : 1;
}

}  // namespace mimbre
