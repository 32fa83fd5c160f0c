#pragma once
#include "compile/compiled.h"

/// The part of compile() that makes the blocks of the spec. The spec is checked.
namespace mimbre {

/// Whether its outputs follow its inputs at the same instant, so that it closes no loop.
bool feeds_through(const spec::Block& block);
/// Whether its outputs have derivatives by time, where its inputs have.
bool is_smooth(const spec::Block& block);

/// Its constants, which go to `signals`, and sizes; places in what is held are left to be given. `step`: the
/// model's, s.
SignalsData::Block compile_block(const spec::Block& block, double step, SignalsData& signals);

}  // namespace mimbre
