#pragma once
#include <vector>

#include "forces/motion.h"
#include "linalg/block_sparse.h"

namespace mimbre {

template <class T>
using AlignedVector = std::vector<T, linalg::CacheAligned<T>>;

}  // namespace mimbre
