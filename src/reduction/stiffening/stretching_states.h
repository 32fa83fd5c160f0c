#pragma once

namespace mimbre {

/// States of stress that a body's Stretching has at most.
constexpr int most_stretching_states = 8;

}  // namespace mimbre
