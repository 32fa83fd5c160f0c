#pragma once
#include "compile/compiled.h"
#include "dynamics/ancf.h"

/// Elastic and damping forces of flexible bodies on their extended amplitudes: linear, or of a beam in
/// absolute nodal coordinates.
namespace mimbre {

/// Adds the forces K y + C ẏ, or those of the beam's strains, to `elastic` (padded).
template <class T>
void add_elasticity(const FlexibleData& f, const T* y, const T* yd, T* elastic) {
  if (f.absolute())
    ancf::add_forces(f, 1, 1, y, yd, elastic);
  else if (f.diagonal_stiffness)
    for (int k = 0; k < f.modes; ++k) elastic[k] += f.stiffness(k, k) * y[k] + f.damping(k, k) * yd[k];
  else
    for (int l = 0; l < f.modes; ++l)
      for (int k = 0; k < f.stride; ++k) elastic[k] += f.stiffness(l, k) * y[l] + f.damping(l, k) * yd[l];
}

}  // namespace mimbre
