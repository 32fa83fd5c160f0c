#pragma once
#include <span>
#include <vector>

#include "dynamics/coordinate_kinds.h"
#include "dynamics/scales.h"
#include "dynamics/state_transfer.h"
#include "linalg/block_sparse.h"

namespace mimbre {

/// Weights of the leading matrix  M + damping·C + stiffness·K + penalty·Φzᵀ α Φz.
struct MatrixWeights {
  double damping = 0, stiffness = 0, penalty = 0;
  bool operator==(const MatrixWeights&) const = default;
};

/// ∂Φ(equation)/∂(velocity coordinate).
struct JacobianEntry {
  int equation = 0, coordinate = 0;
  double value = 0;
};

/// A mechanism in some set of coordinates, as integrators and statics see it: they know no joints and no
/// bodies. q: positions (unit quaternions among them), v, a: velocity coordinates and their rates, x:
/// increments in the tangent space (size velocities). One virtual call per evaluation; nothing here
/// allocates, throws or locks. One thread at a time.
class System {
 public:
  virtual ~System() = default;

  virtual int positions() const = 0;
  virtual int velocities() const = 0;
  virtual int equations() const = 0;
  /// α of each equation (equations × 1): its share of MatrixWeights::penalty; kg or kg m².
  virtual const double* penalty() const = 0;
  virtual const Scales& scales() const = 0;

  /// Moves the common reference point to where the mechanism is at q. Between two calls results refer to one
  /// point.
  virtual void begin_step(const double* q) = 0;
  /// What evaluations take from now on as held inputs (State::u) and as the states of force elements at
  /// the start of a step of that length (State::z; 0: at its start). Both have to stay where they are.
  virtual void enter(const double* held, const double* states, double step) = 0;
  /// The same with a step of 0 where time stands still: what signals change by time is no motion.
  virtual void enter_rest(const double* held, const double* states) = 0;
  /// From now on evaluations are with SignalValues::holds, or no longer. False: nothing in the model heeds
  /// that.
  virtual bool hold_sticking(bool on) = 0;
  /// Equations of velocities alone (rolling) have no value by positions. Where an integrator makes velocities
  /// of an increment x by ∂v/∂x = 1/`time`, their value is Φ = time · Φ̇, whose derivative by x is the
  /// Jacobian as of any other equation. With 0, as at first, they hold in velocities and accelerations only.
  virtual void set_rate_time(double time) = 0;
  /// r = M(q) a − Q(t, q, v) + Φzᵀ μ with μ = multipliers + factor·α Φ(q). Also evaluates the equations.
  virtual void residual(double t, const double* q, const double* v, const double* a,
                        const double* multipliers, double factor, double* r) = 0;
  /// Takes over into `states` (State::z) which turn things are in as of the last residual (dynamics/turns.h).
  virtual void keep_turns(double* states) const = 0;
  /// Evaluates positions, velocities, accelerations and the equations only.
  virtual void kinematics(double t, const double* q, const double* v, const double* a) = 0;
  /// Φ, Φ̇, Φ̈ of the last evaluation.
  virtual const double* phi() const = 0;
  virtual const double* phi_dot() const = 0;
  virtual const double* phi_ddot() const = 0;

  /// Assembles the leading matrix at the last residual's state (q as given there) and factorises it.
  virtual linalg::FactorStatus factor(const double* q, const MatrixWeights& weights) = 0;
  /// The same where only the forces' tangents have changed since factor(), with the same weights: the rest of
  /// the matrix may stay as it was assembled then.
  virtual linalg::FactorStatus factor_tangents(const double* q, const MatrixWeights& weights) = 0;
  /// Factorises M + penalty·Φzᵀ α Φz at the last residual's state, for solve() and Jacobian products: what
  /// explicit integrators need.
  virtual linalg::FactorStatus factor_inertia(const double* q, double penalty) {
    return factor(q, {0, 0, penalty});
  }
  virtual void solve(double* x) const = 0;
  /// Where the factorisation has the forces of the constraints as unknowns: x ← −A⁻¹ (scale·x +
  /// penalty·Φzᵀ α φ) and moved ← Φz x, with the penalty of the matrix. α (φ + Φz x) then has all digits,
  /// which solve() loses there as the penalty grows. False: it has not, and nothing is done.
  virtual bool solve_with_constraint_forces(double /*scale*/, double /*penalty*/, const double* /*phi*/,
                                            double* /*x*/, double* /*moved*/) const {
    return false;
  }
  /// Assembles as factor() does, but only copies the matrix: velocities × velocities, both triangles,
  /// column-major. For formalisms that are not made for speed; solve() must not follow, Jacobian products
  /// may.
  virtual void dense_matrix(const double* q, const MatrixWeights& weights, double* out) = 0;
  /// The pattern of the leading matrix; of no unknowns where it is factorised body by body (long trees). For
  /// whoever factorises it in another scalar.
  virtual const linalg::BlockSymbolic& pattern() const = 0;
  /// Assembles as factor() does, but only copies the values of the pattern (without pairs of swarms).
  /// Jacobian products may follow, solve() must not.
  virtual void matrix_values(const double* q, const MatrixWeights& weights, double* values) = 0;
  /// Whether the tangents of the forces at the last residual differ so much from those in the factorised
  /// matrix that it should not be used further: a contact closed or opened, a spring reached its stop.
  virtual bool tangent_changed(const double* q, const MatrixWeights& weights) const = 0;
  /// Whether an element's tangent has fallen by as much as tangent_changed() heeds, and to less than nine
  /// tenths: something breaks away.
  virtual bool tangent_fell(const MatrixWeights& weights) const = 0;
  /// The tangents in the factorised matrix, which tangent_changed() compares with. The first iteration of a
  /// step may ask for those of the step before, so that they belong to what must be saved to go on.
  virtual std::span<double> tangent_marks() = 0;
  /// Counts factorised matrices: who keeps one over steps sees whether it is still that.
  virtual int matrices() const { return 0; }
  /// Whether the factorised matrix can be saved and is worth keeping over steps.
  virtual bool keeps_matrix() const { return false; }
  /// Saves it with its Jacobian, or factorises the saved one anew.
  virtual void transfer_matrix(StateTransfer&) {}
  /// Jacobian of the equations as of the last factor() or dense_matrix(): out += weight Φzᵀ y, and out = Φz
  /// x.
  virtual void add_jacobian_transposed(const double* y, double weight, double* out) const = 0;
  virtual void jacobian_times(const double* x, double* out) const = 0;
  /// The same Jacobian's entries that may not vanish, each once; it allocates, so not in a step.
  virtual std::vector<JacobianEntry> jacobian_entries() const = 0;

  /// Takes back the part of a predicted increment over a step h that should not be extrapolated: that of
  /// modal amplitudes faster than the step.
  virtual void temper_prediction(double h, double* x) const = 0;
  /// out = q moved by the increment x; out may be q.
  virtual void retract(const double* q, const double* x, double* out) const = 0;
  /// How the increment x from any positions changes where the mechanism moves with velocities v: v itself,
  /// but for rotations, which x turns.
  virtual void increment_rate(const double* x, const double* v, double* rate) const = 0;
  /// x ← increment that does first x, then d.
  virtual void compose(double* x, const double* d) const = 0;

  /// Velocity coordinates that nothing else depends on and that the matrix couples with nothing: modes of
  /// bodies by linear elastodynamics, which all of the motion drives.
  virtual std::span<const int> driven_coordinates() const { return {}; }
  /// What the coordinates are, for formalisms that make tables of them; none: they are of another kind. It
  /// allocates, so not in a step.
  virtual CoordinateKinds coordinate_kinds() const { return {}; }
  /// Likewise: r of inertia and weight alone, without force elements, loads and multipliers.
  virtual Eigen::VectorXd unloaded_residual(double, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                            const Eigen::VectorXd&) {
    return {};
  }
  /// Likewise: generalised forces (as columns) of unit forces and moments at all places where force elements,
  /// loads, contacts and tyres may act, whether or not they do.
  virtual Eigen::MatrixXd element_loads(double, const Eigen::VectorXd&) { return {}; }

  /// Whether forces go by accelerations: loads of inertia that stiffen bodies.
  virtual bool has_loads_of_inertia() const = 0;
  /// r += what these loads put into a residual at (q, a), whose kinematics were the last evaluation.
  virtual void add_loads_of_inertia(const double* q, const double* a, double* r) = 0;
};

}  // namespace mimbre
