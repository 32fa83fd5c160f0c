#pragma once
#include "forces/element.h"

/// A force and a moment on one frame, times a signal.
namespace mimbre::forces {

/// Its direction, `linear` and `angular`, is set by what it acts on (measure.h).
template <class T>
void load_law(const LawContext<T>& c, ElementState<T>& s) {
  s.force[0] = -c.argument(0);
  s.stiffness[0] = s.damping[0] = T(0);
}

inline void load_energy(const LawContext<double>&, const ElementState<double>& s, ElementEnergy& e) {
  e.working[0] = s.force[0];
}

struct Load {
  static constexpr LawInfo info{.name = "load", .list = SpecList::loads};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    load_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    load_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
