#pragma once
#include <cstdint>

#include "mimbre/channels.h"
#include "mimbre/method.h"
#include "model/compiled.h"

namespace mimbre {

/// A number that tells models and methods apart: a hash of the model's text, its channels, the forces that it
/// computes in a few arbitrary states and the method. Never 0. The same wherever the model is compiled;
/// forces count to five digits, so that another processor's rounding changes nothing.
std::uint64_t fingerprint(const Compiled& model, const Method& method,
                          const std::vector<ChannelInfo>& channels);

}  // namespace mimbre
