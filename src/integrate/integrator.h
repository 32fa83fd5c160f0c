#pragma once
#include <Eigen/Core>

#include "integrate/anderson.h"
#include "integrate/system.h"

namespace mimbre {

/// What must be saved to go on: copying it and stepping gives the same bits.
struct State {
  double time = 0;
  Eigen::VectorXd q;            ///< positions
  Eigen::VectorXd v;            ///< velocities
  Eigen::VectorXd a;            ///< accelerations
  Eigen::VectorXd algorithmic;  ///< generalised-α's algorithmic accelerations; Newmark: equal to a
  Eigen::VectorXd multipliers;  ///< λ, N or N m
  bool started = false;  ///< the first step replaces a and algorithmic by what a step of its length sees
};

struct IntegratorOptions {
  double step = 0.01;
  /// Generalised-α (Chung, Hulbert 1993; Arnold, Brüls 2007) of this spectral radius at infinity, 0..1; or,
  /// when `newmark`, Newmark's rule with ξ ≤ 0: β = (1 − ξ)²/4, γ = (1 − 2ξ)/2 (Lugrís 2008, 2.167).
  double rho = 0.3;
  bool newmark = false;
  double xi = 0;
  double tolerance = 1e-5;  ///< of the accelerations in an iteration, relative to the largest one or 9.81
  double position_tolerance = 1e-9;  ///< of the equations, m (angles: times the length scale)
  double velocity_tolerance = 1e-9;  ///< m/s
  double penalty = 1e7;              ///< κ: the penalty is κ times the mean body mass over β h²
  int max_iterations = 30;
};

enum class StepCode { ok, not_converged, not_finite, singular };

struct StepStatus {
  StepCode code = StepCode::ok;
  int iterations = 0;
  int factorisations = 0;
  int coordinate = -1;            ///< of the largest correction, or the culprit
  double correction = 0;          ///< last Newton correction, largest entry
  double position_violation = 0;  ///< max |Φ| after the step
  double velocity_violation = 0;  ///< max |Φ̇| after the step
};

/// The index-3 augmented Lagrangian with Newmark or generalised-α in positions, then projections of
/// velocities and accelerations with the same factorised matrix (Lugrís 2008, 2.165–2.183). Quaternion
/// coordinates are integrated as a Lie group (Brüls, Cardona, Arnold 2012): the increment of a step is a
/// rotation vector.
class Integrator {
 public:
  Integrator(System& system, const IntegratorOptions& options);

  /// One step of options().step. On failure the state is unchanged. Allocates nothing, throws nothing.
  /// The system's last evaluation is then of the new positions and velocities (accelerations before their
  /// projection).
  StepStatus step(State& state);

  const IntegratorOptions& options() const { return options_; }
  /// Changes the step, s > 0.
  void set_step(double step);

 private:
  void start(const State& s);
  void motion_from_increment(const State& s);
  linalg::FactorStatus factor();
  void project(double* target, const double* violation, double tolerance);

  System& system_;
  IntegratorOptions options_;
  double alpha_m_, alpha_f_, beta_, gamma_;
  MatrixWeights weights_;
  Anderson mixing_;
  Eigen::VectorXd q_, v_, a_, algorithmic_, lambda_, x_, r_;  // at the end of the step
  Eigen::VectorXd start_a_, start_algorithmic_;               // at its start
  Eigen::VectorXd g_, impulse_, force_;                       // violation that is left; multipliers
};

}  // namespace mimbre
