#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// All of a model, its reduced bodies, functions, roads and surfaces included, as one block of bytes that a
/// program of the same version reads again, on a machine of another word length too. Little-endian.
/// Throws InputError that names the elements with a force law of the user's own (spec::UserLaw), which is
/// code and cannot be written.
std::vector<std::byte> model_bytes(const spec::Model& model);

/// The model that model_bytes() wrote: compiled, it has the same fingerprint and runs with the same bits.
/// Throws InputError where the bytes are no such block, of another version, or damaged.
spec::Model model_from_bytes(std::span<const std::byte> bytes);

}  // namespace mimbre
