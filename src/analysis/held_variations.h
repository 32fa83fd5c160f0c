#pragma once
#include <memory>
#include <span>

#include "mimbre/simulation.h"

namespace mimbre {

/// Derivatives of channels by inputs, tunable parameters and the time at an instant. The motion and all
/// states are held, so that only what shows these at once varies.
///
/// Signals and the forces of springs, tyres, loads and other elements are evaluated over dual numbers, so
/// that their derivatives are exact. Reactions, section forces, contacts and the wheel quantities of tyres
/// are extrapolated differences (Ridders): along a direction they are nearly always affine, and then exact
/// but for round-off. Energies, events and statistics of the solver do not vary.
class HeldVariations {
 public:
  /// Of simulations of this model and method. `redundant`: some constraints are, or nearly.
  HeldVariations(std::shared_ptr<const Model> model, const Method& method, bool redundant);
  ~HeldVariations();

  /// Derivatives at a simulation's state along a direction: `inputs` has the change of each of the model's
  /// inputs, `time` that of the time. Inputs with `hold: linear` do not act at once. Writes one number for
  /// each channel. Throws InputError for a state of another model.
  void along(const Simulation::Snapshot& state, std::span<const double> inputs, double time,
             std::span<const int> channels, double* derivatives);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre
