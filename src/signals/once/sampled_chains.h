#pragma once
#include <vector>

#include "compile/compiled.h"

namespace mimbre {

/// By SignalsData::sampled: whether it takes, by way of signals too, what another one of them makes.
std::vector<char> takes_sampled(const SignalsData& d);

}  // namespace mimbre
