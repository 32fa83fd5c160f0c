#pragma once
#include <cstdint>

#include "mimbre/channels.h"
#include "mimbre/method.h"
#include "mimbre/model.h"

namespace mimbre {

/// A number that identifies model and method: a hash of the model's text, its channels, its image (every
/// number that a step uses) and the method. Never 0. Equal models have equal fingerprints in every process
/// and on every machine.
std::uint64_t fingerprint(const Model& model, const Method& method, const std::vector<ChannelInfo>& channels);

}  // namespace mimbre
