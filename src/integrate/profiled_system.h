#pragma once
#include <chrono>

#include "dynamics/system.h"

namespace mimbre {

/// Seconds of wall time spent in a system's evaluations, by phase.
struct PhaseSeconds {
  double residual = 0;    ///< inverse dynamics in the iterations
  double matrix = 0;      ///< assembly and factorisation
  double solution = 0;    ///< back substitutions and Jacobian products
  double kinematics = 0;  ///< for the projections
};

/// Passes everything on to another system and adds up the time that it takes.
class ProfiledSystem final : public System {
 public:
  explicit ProfiledSystem(System& system) : system_(system) {}
  const PhaseSeconds& seconds() const { return seconds_; }

  int positions() const override { return system_.positions(); }
  int velocities() const override { return system_.velocities(); }
  int equations() const override { return system_.equations(); }
  const double* penalty() const override { return system_.penalty(); }
  const Scales& scales() const override { return system_.scales(); }
  void begin_step(const double* q) override { system_.begin_step(q); }
  void enter(const double* held, const double* states, double step) override {
    system_.enter(held, states, step);
  }
  void enter_rest(const double* held, const double* states) override { system_.enter_rest(held, states); }
  void set_rate_time(double time) override { system_.set_rate_time(time); }
  void residual(double t, const double* q, const double* v, const double* a, const double* multipliers,
                double factor, double* r) override {
    const Timer timer(seconds_.residual);
    system_.residual(t, q, v, a, multipliers, factor, r);
  }
  void kinematics(double t, const double* q, const double* v, const double* a) override {
    const Timer timer(seconds_.kinematics);
    system_.kinematics(t, q, v, a);
  }
  const double* phi() const override { return system_.phi(); }
  const double* phi_dot() const override { return system_.phi_dot(); }
  const double* phi_ddot() const override { return system_.phi_ddot(); }
  linalg::FactorStatus factor(const double* q, const MatrixWeights& weights) override {
    const Timer timer(seconds_.matrix);
    return system_.factor(q, weights);
  }
  linalg::FactorStatus factor_tangents(const double* q, const MatrixWeights& weights) override {
    const Timer timer(seconds_.matrix);
    return system_.factor_tangents(q, weights);
  }
  linalg::FactorStatus factor_inertia(const double* q, double penalty) override {
    const Timer timer(seconds_.matrix);
    return system_.factor_inertia(q, penalty);
  }
  void solve(double* x) const override {
    const Timer timer(seconds_.solution);
    system_.solve(x);
  }
  bool solve_with_constraint_forces(double scale, double penalty, const double* phi, double* x,
                                    double* moved) const override {
    const Timer timer(seconds_.solution);
    return system_.solve_with_constraint_forces(scale, penalty, phi, x, moved);
  }
  void dense_matrix(const double* q, const MatrixWeights& weights, double* out) override {
    const Timer timer(seconds_.matrix);
    system_.dense_matrix(q, weights, out);
  }
  const linalg::BlockSymbolic& pattern() const override { return system_.pattern(); }
  void matrix_values(const double* q, const MatrixWeights& weights, double* values) override {
    const Timer timer(seconds_.matrix);
    system_.matrix_values(q, weights, values);
  }
  bool tangent_changed(const double* q, const MatrixWeights& weights) const override {
    return system_.tangent_changed(q, weights);
  }
  void keep_turns(double* states) const override { system_.keep_turns(states); }
  bool hold_sticking(bool on) override { return system_.hold_sticking(on); }
  bool tangent_fell(const MatrixWeights& weights) const override { return system_.tangent_fell(weights); }
  std::span<double> tangent_marks() override { return system_.tangent_marks(); }
  int matrices() const override { return system_.matrices(); }
  bool keeps_matrix() const override { return system_.keeps_matrix(); }
  void transfer_matrix(StateTransfer& transfer) override { system_.transfer_matrix(transfer); }
  void add_jacobian_transposed(const double* y, double weight, double* out) const override {
    const Timer timer(seconds_.solution);
    system_.add_jacobian_transposed(y, weight, out);
  }
  void jacobian_times(const double* x, double* out) const override {
    const Timer timer(seconds_.solution);
    system_.jacobian_times(x, out);
  }
  std::vector<JacobianEntry> jacobian_entries() const override { return system_.jacobian_entries(); }
  void temper_prediction(double h, double* x) const override { system_.temper_prediction(h, x); }
  void retract(const double* q, const double* x, double* out) const override { system_.retract(q, x, out); }
  void increment_rate(const double* x, const double* v, double* rate) const override {
    system_.increment_rate(x, v, rate);
  }
  void compose(double* x, const double* d) const override { system_.compose(x, d); }
  CoordinateKinds coordinate_kinds() const override { return system_.coordinate_kinds(); }
  Eigen::VectorXd unloaded_residual(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                    const Eigen::VectorXd& a) override {
    return system_.unloaded_residual(t, q, v, a);
  }
  Eigen::MatrixXd element_loads(double t, const Eigen::VectorXd& q) override {
    return system_.element_loads(t, q);
  }
  std::span<const int> driven_coordinates() const override { return system_.driven_coordinates(); }
  bool has_loads_of_inertia() const override { return system_.has_loads_of_inertia(); }
  void add_loads_of_inertia(const double* q, const double* a, double* r) override {
    system_.add_loads_of_inertia(q, a, r);
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Timer {
    explicit Timer(double& seconds) : total(seconds) {}
    ~Timer() { total += std::chrono::duration<double>(Clock::now() - start).count(); }
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;
    double& total;
    Clock::time_point start = Clock::now();
  };

  System& system_;
  mutable PhaseSeconds seconds_;
};

}  // namespace mimbre
