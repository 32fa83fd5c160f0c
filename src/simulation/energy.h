#pragma once
#include "dynamics/relative/system.h"
#include "integrate/stepper.h"
#include "mimbre/energy.h"

namespace mimbre {

/// Follows the balance from step to step. Potentials are exact; works and dissipation over a step are mean
/// force times displacement, so `numerical` also holds that quadrature's error, of the order of the square of
/// the step.
class EnergyMeter {
 public:
  explicit EnergyMeter(const Compiled& model);
  /// After initialisation, and after every accepted step: the system's last kinematics must be of this state.
  /// Neither allocates nor throws.
  void start(relative::RelativeSystem& system, const State& state);
  void update(relative::RelativeSystem& system, const State& state);

  const EnergyBalance& balance() const { return balance_; }
  /// Energy that the numerics put in during the last step.
  double last_input() const { return last_input_; }
  /// Energy that jumps of the road under the tyres released or stored in it.
  double last_jump() const { return jump_; }
  /// Something that stores energy.
  struct Place {
    enum class Kind { none, spring, joint_spring, tyre, body } kind = Kind::none;
    int index = -1;
  };
  /// What exchanged most energy in it.
  Place last_place() const { return place_; }
  /// Where most energy came and went faster than the steps can follow: the largest sum of second differences.
  struct Unresolved {
    Place place;
    double steps_per_period = 0;  ///< of the vibration that would have these differences, roughly
    double at_play = 0;           ///< J, between the highest and the lowest energy there
  };
  Unresolved most_unresolved() const;

 private:
  struct Flow {
    double length = 0, force = 0, damping = 0, general = 0;
  };
  /// What a place stores, and how that has changed from step to step.
  struct Store {
    Place place;
    double energy = 0, change = 0, highest = 0, lowest = 0;
    double exchanged = 0, unresolved = 0;  ///< sums of first and second differences, in size
  };
  void observe(relative::RelativeSystem& system, const State& state);
  void observe_store(std::size_t store, double energy);
  void observe_geometric(const GeometricData& geometric, const StressMotion<double>& motion, int first,
                         const double* y, double* forces);

  const Compiled* model_;
  EnergyBalance balance_;
  double start_total_ = 0, last_input_ = 0, jump_ = 0;
  Place place_;
  double most_exchanged_ = 0;  ///< in the last step, at place_
  bool started_ = false;
  std::vector<Flow> springs_, joint_springs_;
  std::vector<Store> stores_;  ///< springs, joint springs, tyres, bodies
  std::vector<double> tyre_height_, tyre_road_, tyre_x_, generalised_, drive_position_, drive_force_;
  std::vector<Eigen::Vector3d> load_position_, load_force_;
  std::vector<double> load_power_;
  Eigen::VectorXd damping_force_, modal_, geometric_force_;
  double time_ = 0;
};

/// Kinetic energy from the bodies' motion (the last kinematics), J; uses the workspace's scratch.
double kinetic_energy(const Compiled& model, relative::Workspace<double>& work, const double* q,
                      const double* v);

}  // namespace mimbre
