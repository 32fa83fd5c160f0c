#pragma once
#include "model_file/sections/signals.h"

/// Signals that are made by blocks: {pid: angle, setpoint: wanted, kp: 200}.
namespace mimbre::model_file {

/// The block that a description names by its key; −1 where it names none.
int block_of(const Tree& description);

/// Names of a block's signals, behind that of the block: none but of a block of several outputs, {"x", "y"}.
std::vector<std::string> output_names(const Tree& description);

/// Reads the block of type `type`; its signals, which are there, become its outputs.
void read_block(Builder& builder, const Part& part, const Value& value, const std::string& name, int type,
                const std::vector<std::size_t>& signals);

}  // namespace mimbre::model_file
