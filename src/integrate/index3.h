#pragma once
#include "integrate/anderson.h"
#include "integrate/newton.h"
#include "integrate/prediction.h"
#include "integrate/step_motion.h"

namespace mimbre {

/// The index-3 augmented Lagrangian with Newmark or generalised-α in positions, then projections of
/// velocities and accelerations with the same factorised matrix (Lugrís 2008, 2.165–2.183). Quaternion
/// coordinates are integrated as a Lie group (Brüls, Cardona, Arnold 2012): the increment of a step is a
/// rotation vector. Allocates nothing in a step.
class IndexThree final : public Stepper {
 public:
  IndexThree(System& system, const IntegratorOptions& options);
  /// The system's last evaluation is then of the new positions and velocities (accelerations before their
  /// projection).
  StepStatus step(State& state) override;
  void begun(State& s) const override { motion_.begun(s); }
  void ended(State& s) const override { s.a = unprojected_; }
  /// Near singular positions, which only constraints have, a step is repeated; along corrections that leap
  /// across friction the residual is evaluated further.
  int most_attempts() const override {
    const int attempts = options_.fixed_cost || system_.equations() == 0 ? 1 : 2;
    return searches_ ? searching_attempts * attempts : attempts;
  }
  void set_step(double step) override;
  void transfer(StateTransfer& transfer) override { prediction_.transfer(transfer); }
  void transfer_matrix(StateTransfer& transfer) override;
  void forget() override {
    prediction_.forget();
    kept_ = false;
    uses_ = pause_ = waits_ = 0;
  }

 private:
  /// Positions are accepted with violations of up to this multiple of their tolerance.
  static constexpr double accepted_positions = 10;
  /// Evaluations of an attempt that searches along corrections, in IntegratorOptions::max_iterations, at
  /// most.
  static constexpr int searching_attempts = 5;
  /// An attempt at a step, handed from phase to phase.
  struct Attempt {
    bool precise = false;  ///< with a larger penalty and a smaller tolerance, near singular positions
    double time = 0;       ///< at the end of the step, s
    double position_tolerance = 0;
    bool inherits = false;  ///< a short part: violations that the step before left stay
    // Of the iterate.
    double violation = 0;      ///< |Φ|, in the mechanism's own units (Scales), as all violations here
    double accelerations = 0;  ///< the largest, Scales::accelerations
    bool refactored = false;   ///< the last correction is by a new matrix
    bool by_kept = false;      ///< the first ones are by that of an earlier step
    bool assembled = false;    ///< one is by a matrix of the step, not only by exchanged tangents
    bool held = false;         ///< the iterate's forces are those of friction that goes on sticking
    bool shortened = false;    ///< the last correction went too far
    bool leaps = false;        ///< one of them did
    bool settled = false;      ///< the multipliers do not change any more
    bool converged = false;
    bool lost = false;       ///< by a matrix of an earlier step
    bool predicted = false;  ///< the iterate is the prediction
    NewtonProgress newton;
    double first_correction = 0;
    // Of the velocities at the end.
    bool projected = false;  ///< before they were evaluated
    double rate_violation = 0, velocity_tolerance = 0;
    bool near_singular = false;
    double projected_away = 0;  ///< of velocities or accelerations, by what a kept matrix may
    StepStatus status;
  };
  Attempt attempt(State& state, bool precise);

  // The phases of an attempt, in order. Those that return bool fail with Attempt::status.
  Attempt begin(State& state, bool precise);
  void predict(const State& state, Attempt& t);
  void begin_again(const State& state, Attempt& t);
  void evaluate(const State& state, Attempt& t);
  void leave_inherited();
  /// Φ that the step is to correct.
  const double* violation(const Attempt& t) const;
  bool replace_prediction(const State& state, const Attempt& t);
  bool fail(Attempt& t, StepCode code, int coordinate);
  bool find_correction(Attempt& t);
  void solve_for_correction(const double* phi);
  void update_multipliers(Attempt& t, int iteration);
  bool apply_correction(const State& state, Attempt& t);
  // How far it goes (line_search.cpp).
  void return_to_constraints(const State& state, Attempt& t);
  double along_correction(const State& state, Attempt& t, double share);
  bool shorten_correction(const State& state, Attempt& t);
  // Where the step ends (step_end.cpp).
  void decide_convergence(Attempt& t);
  void keep_nearest(const Attempt& t);
  void end_positions(const State& state, Attempt& t);
  void project_expected_velocities(Attempt& t);
  bool accept_positions(Attempt& t);
  // After it.
  void project_velocities(Attempt& t);
  void project_accelerations(Attempt& t);
  void project(double* target, const double* violation, double tolerance);
  void judge_matrix(const Attempt& t);
  void pause_keeping();

  System& system_;
  const Scales& scales_;
  const double usual_step_;  ///< s; parts of it may be much shorter
  StepMotion motion_;
  Prediction prediction_;
  MatrixWeights weights_;
  /// The matrix decides how fast the iterations converge, not where to, and is kept over steps; with
  /// equations over a few (judge_matrix), and by a rule that damps what an old one projects wrongly.
  const bool keeps_;
  /// Corrections that leap across friction are shortened (line_search.cpp).
  const bool searches_;
  bool kept_ = false;    ///< it may be used in the next step,
  int kept_matrix_ = 0;  ///< if it is still this one
  MatrixWeights kept_weights_;
  int kept_corrections_ = 0;  ///< of the step that made it
  int uses_ = 0;              ///< steps that it has led through
  /// Steps that make their own matrices before one is kept again: more, the more often a kept one has not led
  /// through a step.
  int pause_ = 0, waits_ = 0;
  Anderson mixing_;
  Eigen::VectorXd lambda_, r_;
  Eigen::VectorXd unprojected_;  ///< velocities, then accelerations
  /// With a fixed iteration budget: the iterate with the least correction.
  struct {
    double off = 0;
    Eigen::VectorXd x, lambda;
  } nearest_;
  Eigen::VectorXd before_;                       ///< multipliers before an iteration
  Eigen::VectorXd g_;                            ///< remaining violation of a projection
  Eigen::VectorXd impulse_, force_;              ///< per equation: Φz δ or α Φ; change of the multipliers
  Eigen::VectorXd inherited_, own_;              ///< Φ at the start of a short part, and what has come since
  Eigen::VectorXd line_, line_x_, line_lambda_;  ///< a correction, and from where it goes
  Eigen::VectorXd rates_;                        ///< of the constraints, expected after the last correction
};

}  // namespace mimbre
