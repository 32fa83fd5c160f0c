#pragma once
#include "simulation/step/energy.h"
#include "simulation/step/free_flight.h"

namespace mimbre {

/// Takes back what a step of the rule fed in or took out, so that the energy balance holds: the integrator
/// `conserve`. The rule damps vibrations that the step does not resolve (conserving_rho): what they lose goes
/// to the motion as a whole. What can change without breaking the laws of free flight is the size of the
/// velocities (of what nothing ties to the ground: relative to its mean motion, a rigid body's of the same
/// momentum) and the attitude of free groups: a turn at constant angular momentum changes the energy of
/// rotation. Both get a part by the energy that they have, so that a correction is as small as it can be
/// against the motion that it corrects. Loops stay closed: the constraints on velocities are homogeneous;
/// models with drives get turns only. Allocates only when made.
class EnergyKeeper {
 public:
  EnergyKeeper(const Compiled& model, const std::vector<FreeGroup>& groups);
  /// At the end of a step, after kinematics at the state; arguments as FreeFlight::end. `meter`: of the
  /// balance at its start. Takes back State::energy_error, too: what corrections before left, because more
  /// than a correction of sensible size was asked for (a pendulum at its turning point), or because they
  /// moved the places of loads.
  void end(relative::RelativeSystem& observer, natural::NaturalSystem* natural, const State& relative,
           const EnergyMeter& meter, State& state);

 private:
  void scale(relative::RelativeSystem& observer, natural::NaturalSystem* natural, double by, State& state);
  double gain(double share) const;
  Mat3d turn_of(std::size_t group, double share) const;

  const Compiled& model_;
  const std::vector<FreeGroup>& groups_;
  const std::vector<FloatingSet> sets_;
  EnergyMeter meter_;
  std::vector<relative::Momentum> momenta_, set_momenta_;
  std::vector<flight::Rotation<double>> rotations_;
  double inner_ = 0;  ///< kinetic energy of what moves relative to the mean motion, J
};

}  // namespace mimbre
