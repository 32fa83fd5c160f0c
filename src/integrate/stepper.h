#pragma once
#include <Eigen/Core>
#include <memory>

#include "dynamics/state.h"
#include "dynamics/state_transfer.h"
#include "dynamics/system.h"
#include "mimbre/spec.h"
#include "mimbre/violations.h"

namespace mimbre {

struct IntegratorOptions {
  using Rule = spec::Simulation::Integrator;
  double step = 0.01;
  /// Generalised-α (Chung, Hulbert 1993; Arnold, Brüls 2007) or HHT (Hilber, Hughes, Taylor 1977) of the
  /// spectral radius `rho` at infinity; or Newmark's rule with ξ ≤ 0: β = (1 − ξ)²/4, γ = (1 − 2ξ)/2 (Lugrís
  /// 2008, 2.167).
  Rule rule = Rule::generalized_alpha;
  double rho = 0.3;  ///< 0..1; HHT exists for 0.5..1 and takes the nearest of these
  double xi = 0;
  double accuracy = 0;  ///< the error that a step may have, by the scales of the coordinates
  // In the mechanism's own units (Scales).
  double tolerance = 1e-5;  ///< of the accelerations in an iteration, relative to the largest one or gravity
  double position_tolerance = 1e-9;      ///< of the equations
  double velocity_tolerance = 1e-10;     ///< of their rates, by what is neither slow nor fast
  double acceleration_tolerance = 1e-7;  ///< of their second derivatives, by the accelerations at play
  double penalty =
      1e7;  ///< κ: the penalty is κ times the mean body mass (index3: over β h²; penalty alone: 100 κ)
  int max_iterations = 30;
  /// A step whose iterations have not converged when there have been that many is taken as it is then. Of
  /// index3 alone.
  bool fixed_cost = false;
  // Formalisms that impose Φ̈ + 2ζω Φ̇ + ω² Φ = 0 instead of Φ = 0 (Lugrís 2008, 2.159). The usual ω of
  // 10 rad/s is what explicit integrators tolerate; the rules here take any, and a larger one holds the loops
  // better.
  double constraint_frequency = 20;  ///< ω by the mechanism's own pace (Scales::rate)
  double constraint_damping = 1;     ///< ζ: critical damping
  double drift_limit = 0.02;  ///< a step that ends with a larger |Φ| fails, in the mechanism's own units
};

/// drifted: the loops have come apart by more than the formalism should be trusted with. unstable: the step
/// is too long for an explicit rule, which vibrations faster than that would blow up. beyond_table: a loop
/// leaves the table that its motion comes from.
enum class StepCode { ok, not_converged, not_finite, singular, drifted, unstable, beyond_table };

struct StepStatus : Violations {
  StepCode code = StepCode::ok;
  int iterations = 0;
  int factorisations = 0;
  int coordinate = -1;            ///< of the largest correction, or the culprit
  int equation = -1;              ///< the culprit, where it is an equation (singular, drifted)
  double equation_violation = 0;  ///< |Φ| of that equation, where it drifted: m or rad, see Scales::is_angle
  double correction = 0;          ///< last Newton correction, largest entry
  bool unconverged = false;       ///< taken as it was (IntegratorOptions::fixed_cost)
  double error = 0;               ///< the estimate over IntegratorOptions::accuracy, where that is given
};

/// A way to advance the equations of motion M z̈ + Φzᵀ λ = Q, Φ = 0 of a system by steps.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Before the first step, at the state that it begins with: makes what the formalism needs beforehand. It
  /// may allocate and throw. True: the system has been evaluated elsewhere. Later calls do
  /// nothing. Without this call the first step makes it.
  virtual bool prepare(const State&) { return false; }
  /// One step of options().step. On failure the state is unchanged. Throws nothing, makes a bounded number of
  /// iterations, and gives the same bits for the same state, system (its tangent marks) and memory (transfer,
  /// transfer_matrix). The system's last evaluation is then of the new positions and velocities.
  virtual StepStatus step(State& state) = 0;
  /// After a step that took accelerations of its own (State::started was false): puts those with which it
  /// began, and their multipliers, into the state where it did.
  virtual void begun(State& state) const = 0;
  /// After a step: puts the accelerations of its equations at the end into a copy of the state, where those
  /// of the state are their projection onto the constraints. Forces that go by accelerations acted by these.
  virtual void ended(State&) const {}
  /// How often at most the iterations of a step begin anew; each time there are at most
  /// IntegratorOptions::max_iterations of them.
  virtual int most_attempts() const { return 1; }
  /// The power of the step with which StepStatus::error grows.
  virtual int order_of_error() const { return 8; }
  /// Changes the step, s > 0.
  virtual void set_step(double step) = 0;
  /// What it remembers from step to step beside the state.
  virtual void transfer(StateTransfer&) {}
  /// The factorised matrix, where steps use that of steps before: with it a saved state goes on with the same
  /// bits. A step that is taken back need not take back the matrix.
  virtual void transfer_matrix(StateTransfer&) {}
  /// Forgets it: the next step does not follow the last one.
  virtual void forget() {}
  const IntegratorOptions& options() const { return options_; }

 protected:
  explicit Stepper(const IntegratorOptions& options) : options_(options) {}
  IntegratorOptions options_;
};

/// The stepper of a formalism. The system must outlive it.
std::unique_ptr<Stepper> make_stepper(System& system, spec::Simulation::Formalism formalism,
                                      const IntegratorOptions& options);

}  // namespace mimbre
