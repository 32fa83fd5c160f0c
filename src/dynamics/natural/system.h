#pragma once
#include <memory>

#include "dynamics/natural/workspace.h"
#include "dynamics/pair_couplings.h"
#include "dynamics/rigid_shift.h"
#include "dynamics/state.h"
#include "dynamics/system.h"
#include "dynamics/tangent_marks.h"
#include "dynamics/turns.h"

namespace mimbre::natural {

/// The formulation in natural coordinates (Lugrís 2008, 2.2.1 and 3.1; García de Jalón, Bayo 1994) behind the
/// System interface: points and unit vectors shared between bodies, constant mass matrices of rigid bodies,
/// constraints of rigidity and of joints, all of them quadratic at most for rigid bodies.
/// q: unknowns (as in v and a), then the coordinates of the tree's joints, which follow from the unknowns and
/// are kept to count turns.
class NaturalSystem final : public System {
 public:
  explicit NaturalSystem(const Compiled& model,
                         spec::Simulation::Inertia inertia = spec::Simulation::Inertia::integrals);

  int positions() const override { return layout_.positions; }
  int velocities() const override { return layout_.unknowns; }
  int equations() const override { return layout_.equations; }
  const double* penalty() const override { return penalty_.data(); }
  const Scales& scales() const override { return scales_; }
  void begin_step(const double*) override {}
  void enter(const double* held, const double* states, double step) override {
    work_.signals.enter(held, states, step);
  }
  void enter_rest(const double* held, const double* states) override {
    work_.signals.enter(held, states, 0);
    work_.signals.moves = false;
  }
  bool hold_sticking(bool on) override {
    work_.signals.holds = on && marks_.sticks() ? 1 : 0;
    return marks_.sticks();
  }
  void keep_turns(double* states) const override {
    mimbre::keep_turns(model_, work_.elements.data(), work_.constraint_states.data(), states);
  }
  void set_rate_time(double time) override { work_.rate_time = time; }
  void residual(double t, const double* q, const double* v, const double* a, const double* multipliers,
                double factor, double* r) override;
  void kinematics(double t, const double* q, const double* v, const double* a) override;
  const Workspace<double>& workspace() const { return work_; }
  const double* phi() const override { return work_.phi.data(); }
  const double* phi_dot() const override { return work_.phi_dot.data(); }
  const double* phi_ddot() const override { return work_.phi_ddot.data(); }
  linalg::FactorStatus factor(const double* q, const MatrixWeights& weights) override;
  linalg::FactorStatus factor_tangents(const double* q, const MatrixWeights& weights) override {
    return factor(q, weights);
  }
  void solve(double* x) const override {
    couplings_.solve(x, [this](double* y) { factor_.solve(y); });
  }
  void dense_matrix(const double* q, const MatrixWeights& weights, double* out) override;
  const linalg::BlockSymbolic& pattern() const override { return *layout_.symbolic; }
  void matrix_values(const double* q, const MatrixWeights& weights, double* values) override;
  bool tangent_changed(const double* q, const MatrixWeights& weights) const override;
  bool tangent_fell(const MatrixWeights& weights) const override {
    return marks_.fell(model_, work_.elements.data(), weights);
  }
  std::span<double> tangent_marks() override { return marks_.values(); }
  void add_jacobian_transposed(const double* y, double weight, double* out) const override;
  void jacobian_times(const double* x, double* out) const override;
  std::vector<JacobianEntry> jacobian_entries() const override;
  void temper_prediction(double h, double* x) const override;
  void retract(const double* q, const double* x, double* out) const override;
  void increment_rate(const double* x, const double* v, double* rate) const override;
  void compose(double* x, const double* d) const override;
  bool has_loads_of_inertia() const override;
  void add_loads_of_inertia(const double* q, const double* a, double* r) override;

  /// State in relative coordinates, with the same time: from and to this formulation's. Multipliers of drives
  /// and constraints are carried along; others have no counterpart and are zero. `relative` must be sized.
  void to_relative(const State& natural, State& relative);
  /// From the bodies' motion in a relative formulation at that state.
  State from_relative(const State& relative, const std::vector<Motion<double>>& bodies,
                      const Vec3d& common_point) const;

  /// Moves the bodies `of` (by body) by a shift about a common point, without gravity in its c̈ as in a
  /// relative formulation; the accelerations that the integrator remembers change as the true ones do. No
  /// variable of theirs may be shared with other bodies.
  void shift(const std::vector<char>& of, RigidShift shift, const Vec3d& common_point, State& s) const;

  /// Adds `times` the velocities of a rigid motion, of the point at a common point and angular, to those of
  /// the bodies' points and vectors.
  void add_rigid_motion(const std::vector<char>& of, double times, const Vec3d& velocity, const Vec3d& spin,
                        const Vec3d& common_point, State& s) const;

  /// Tree body of an unknown.
  int body_of(int unknown) const;
  const Layout& layout() const { return layout_; }
  const Compiled& model() const { return model_; }

 private:
  void assemble(const double* q, const MatrixWeights& weights);
  void joint_positions(double* q) const;

  const Compiled& model_;
  const Layout layout_;
  mutable Workspace<double> work_;  // `poses` also in retract
  linalg::BlockFactor<double> factor_;
  std::vector<double> penalty_, mu_;
  Scales scales_;
  TangentMarks marks_;
  PairCouplings couplings_;
};

}  // namespace mimbre::natural
