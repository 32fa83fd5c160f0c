#pragma once
#include "dynamics/flexible.h"
#include "dynamics/frame_turn.h"

/// Where the modes move a frame on its body.
namespace mimbre {

/// Displacement and turn of a flexible frame in body axes, with rates.
template <class T>
struct Deformation {
  Vec3<T> position;  ///< r̄u + X y
  Vec3<T> velocity;  ///< X ẏ
  Vec3<T> acceleration;
  Mat3<T> rotation;  ///< R(θ) times the undeformed rotation: frame axes to body axes
  Vec3<T> omega;     ///< relative to the body, body axes
  Vec3<T> alpha;
};

template <class T>
void deform(const FrameData& f, const T* y, const T* yd, const T* ydd, Deformation<T>& d) {
  d.position = f.position.template cast<T>() + times(f.X, y);
  d.velocity = times(f.X, yd);
  d.acceleration = times(f.X, ydd);
  if (!f.turns) {
    d.rotation = f.rotation.template cast<T>();
    d.omega.setZero();
    d.alpha.setZero();
    return;
  }
  turn_motion(f, y, yd, ydd, d.rotation, d.omega, d.alpha);
  d.rotation = d.rotation * f.rotation.template cast<T>();
}

}  // namespace mimbre
