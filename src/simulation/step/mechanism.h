#pragma once
#include <memory>

#include "dynamics/natural/system.h"
#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/method.h"

namespace mimbre {

/// A mechanism in motion, in the coordinates that the integrator works in, and as relative coordinates see
/// it: energies and outputs are evaluated in these whatever the formulation.
struct Mechanism {
  Mechanism(const Compiled& compiled, const Method& method);

  /// The state in relative coordinates; in natural coordinates that of the last observe().
  const State& view() const { return natural ? seen : state; }
  /// Kinematics at the state, for energies and output.
  void observe();
  /// The same about a common point that depends on the state alone, not on the step that led to it.
  void observe_afresh();
  /// As observe(), of another state near this one; returns it as view() does. The next observe() is to
  /// follow.
  const State& observe_other(const State& other);
  /// From now on evaluations continue from the state, by a step (s; 0: none).
  void enter(double step);
  /// Whether force elements or signals remember anything from step to step.
  bool remembers() const;
  /// After a step, and at the start: takes over what force elements and signals remember. `known`: the
  /// observer's last forces are of the state.
  void commit(bool known);
  /// Where signals have jumped: the laws of force elements remember their present values. `known`: as of
  /// commit(), of an evaluation with a step of 0 s.
  void commit_jump(bool known);

  const Compiled& model;
  relative::RelativeSystem observer;  ///< the system itself in relative coordinates
  std::unique_ptr<natural::NaturalSystem> natural;
  System& system;
  State state, seen;

 private:
  void evaluate_forces();

  Eigen::VectorXd generalised_;
};

}  // namespace mimbre
