#pragma once
#include "math/rotation.h"
#include "model/compiled.h"

namespace mimbre {

/// Force on a frame's origin and moment, global axes.
template <class T>
struct LoadWrench {
  Vec3<T> force, moment;
};

/// What a load exerts at a time on its frame with these axes; its power is force · velocity of the frame's
/// origin + moment · angular velocity.
template <class T>
LoadWrench<T> load_wrench(const LoadData& l, const Mat3<T>& axes, double time) {
  const double scale = l.scale.value(time);
  LoadWrench<T> w{(scale * l.force).template cast<T>(), (scale * l.moment).template cast<T>()};
  if (l.follower) {
    w.force = (axes * w.force).eval();
    w.moment = (axes * w.moment).eval();
  }
  return w;
}

}  // namespace mimbre
