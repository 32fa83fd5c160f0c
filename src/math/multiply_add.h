#pragma once
#include <type_traits>

#include "math/choice.h"

namespace mimbre {

/// a b + c, rounded once where all are doubles or lanes of them. The build rounds products and sums one by
/// one, so that results do not depend on what the compiler makes of an expression; inner loops say here where
/// they want the fused instruction, which has the same bits everywhere.
template <class A, class B, class C>
auto multiply_add(const A& a, const B& b, const C& c) {
  if constexpr (std::is_same_v<A, double> && std::is_same_v<B, double> && std::is_same_v<C, double>) {
    return __builtin_fma(a, b, c);
  } else if constexpr (is_pack<C>) {
    C out = c;
    for (int i = 0; i < C::lanes; ++i) out[i] = __builtin_fma(C(a)[i], C(b)[i], c[i]);
    return out;
  } else {
    return C(a * b + c);
  }
}

}  // namespace mimbre
