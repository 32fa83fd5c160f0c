#pragma once
#include <optional>

#include "compile/compiled.h"

/// Trees whose matrix is factorised body by body (dynamics/relative/articulated.h), in a time proportional to
/// the number of bodies, without the sparse matrix, which is dense along a chain.
namespace mimbre {

/// One body whose own coordinates decide what an element measures, together with the motion of the frame
/// that carries the body if `carried`. plus, minus: Compiled::subspaces, −1: none.
struct OnBody {
  int body = -1, plus = -1, minus = -1;
  bool carried = false;
};

/// Of an element with a path; nothing where it couples several bodies.
std::optional<OnBody> acts_on_body(const ElementData& e, const Compiled& m);

/// Whether the matrix can be factorised so: no loops and no constraints but drives, every force element acts
/// on one body, and no body has so many coordinates that its own sparse matrix is worth while.
bool splits_by_bodies(const Compiled& m);

/// Whether that takes far fewer operations than the sparse matrix.
bool is_eliminated_by_bodies(const Compiled& m);

}  // namespace mimbre
