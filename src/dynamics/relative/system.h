#pragma once
#include <memory>

#include "dynamics/pair_couplings.h"
#include "dynamics/relative/element_tangents.h"
#include "dynamics/relative/workspace.h"
#include "dynamics/system.h"
#include "dynamics/tangent_marks.h"
#include "dynamics/turns.h"

namespace mimbre::relative {

template <class T>
class ArticulatedBodies;
template <class T>
class TransferMatrices;

/// The semi-recursive formulation in relative coordinates (Lugrís 2008, chapter 2) behind the System
/// interface.
class RelativeSystem final : public System {
 public:
  /// Inertia other than by shape integrals throws InputError when a flexible body has no mesh for it.
  explicit RelativeSystem(const Compiled& model,
                          spec::Simulation::Inertia inertia = spec::Simulation::Inertia::integrals);
  ~RelativeSystem() override;

  int positions() const override { return model_.positions; }
  int velocities() const override { return model_.velocities; }
  int equations() const override { return model_.equations; }
  const double* penalty() const override { return penalty_.data(); }
  const Scales& scales() const override { return scales_; }
  void begin_step(const double* q) override;
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
  const double* phi() const override { return work_.phi.data(); }
  const double* phi_dot() const override { return work_.phi_dot.data(); }
  const double* phi_ddot() const override { return work_.phi_ddot.data(); }
  linalg::FactorStatus factor(const double* q, const MatrixWeights& weights) override;
  linalg::FactorStatus factor_tangents(const double* q, const MatrixWeights& weights) override;
  linalg::FactorStatus factor_inertia(const double* q, double penalty) override;
  void solve(double* x) const override;
  bool solve_with_constraint_forces(double scale, double penalty, const double* phi, double* x,
                                    double* moved) const override;
  void dense_matrix(const double* q, const MatrixWeights& weights, double* out) override;
  const linalg::BlockSymbolic& pattern() const override { return model_.symbolic; }
  void matrix_values(const double* q, const MatrixWeights& weights, double* values) override;
  bool tangent_changed(const double* q, const MatrixWeights& weights) const override;
  bool tangent_fell(const MatrixWeights& weights) const override {
    return marks_.fell(model_, work_.elements.data(), weights);
  }
  std::span<double> tangent_marks() override { return marks_.values(); }
  int matrices() const override { return matrices_; }
  bool keeps_matrix() const override { return keeps_matrix_; }
  void transfer_matrix(StateTransfer& transfer) override;
  void add_jacobian_transposed(const double* y, double weight, double* out) const override;
  void jacobian_times(const double* x, double* out) const override;
  std::vector<JacobianEntry> jacobian_entries() const override;
  void temper_prediction(double h, double* x) const override;
  void retract(const double* q, const double* x, double* out) const override;
  void increment_rate(const double* x, const double* v, double* rate) const override;
  void compose(double* x, const double* d) const override;
  std::span<const int> driven_coordinates() const override { return driven_; }
  CoordinateKinds coordinate_kinds() const override;
  Eigen::VectorXd unloaded_residual(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                    const Eigen::VectorXd& a) override;
  Eigen::MatrixXd element_loads(double t, const Eigen::VectorXd& q) override;
  bool has_loads_of_inertia() const override;
  void add_loads_of_inertia(const double* q, const double* a, double* r) override;

  /// From now on factor() sweeps along the bodies, whatever their number and what couples them. Allocates.
  void use_transfer_matrices();

  /// Assembles the sparse matrix without factorising: for tests and analyses. Same arguments as factor().
  void assemble(const double* q, const MatrixWeights& weights);
  /// Multiplies the assembled (not factorised) matrix: y = A x.
  void multiply(const double* x, double* y) const;

  const Compiled& model() const { return model_; }
  Workspace<double>& workspace() { return work_; }
  const Workspace<double>& workspace() const { return work_; }

 private:
  /// After an evaluation of the motion: r of inertia, weight and a unit force (direction 0 to 2) or moment (3
  /// to 5) at a frame; −1: none.
  Eigen::VectorXd residual_of_wrenches(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                       const Eigen::VectorXd& a, int frame, int direction);
  linalg::FactorStatus factor_by_bodies(const double* q, const MatrixWeights& weights);
  linalg::FactorStatus factor_by_transfer(const double* q, const MatrixWeights& weights);

  const Compiled& model_;
  Workspace<double> work_;
  linalg::BlockFactor<double> factor_;
  std::vector<double> penalty_, mu_;
  Scales scales_;
  TangentMarks marks_;
  PairCouplings couplings_;
  ElementTangents tangents_;
  std::vector<int> driven_;
  bool keeps_matrix_ = false;
  int matrices_ = 0;
  /// Of trees: their matrix by bodies. Always, where there is no sparse one; and whether solve() takes it.
  std::unique_ptr<ArticulatedBodies<double>> articulated_;
  bool always_by_bodies_ = false, by_bodies_ = false;
  std::unique_ptr<TransferMatrices<double>> transfer_;  ///< of that formalism, whose solve() takes it
};

/// Velocity at the common point and angular velocity etc. of a frame that is not needed in the step, for
/// output.
Motion<double> output_motion(const RelativeSystem& system, int frame, const double* q, const double* v,
                             const double* a);

/// The same as one would see it: with the deflections of a body by elastodynamics, in which the mechanism has
/// no part.
Motion<double> observed_motion(const RelativeSystem& system, int frame, const double* q, const double* v,
                               const double* a);

}  // namespace mimbre::relative
