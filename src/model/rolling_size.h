#pragma once
#include "mimbre/spec.h"

namespace mimbre {

/// What a tyre that rolls measures the road with, besides its radius.
struct RollingSize {
  double share;      ///< of its deflection, by which it rolls as if it were smaller
  double footprint;  ///< half its length, m
};

RollingSize rolling_size(const spec::Tyre& tyre);

}  // namespace mimbre
