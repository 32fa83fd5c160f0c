#pragma once
#include "dynamics/relative/system.h"
#include "dynamics/state_transfer.h"
#include "integrate/stepper.h"
#include "mimbre/energy.h"
#include "signals/law.h"

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
  /// Before a step that begins anew, with other accelerations than those in which the last one ended: inputs,
  /// events or controllers may have changed forces, and what elements store. From here on the forces of now
  /// count. The system has entered the state with a step of 0 s, and its last kinematics are of it; the
  /// forces are then, too.
  void jump(relative::RelativeSystem& system, const State& state);
  /// Whether anything does work by the accelerations: drives, and loads of inertia that stiffen bodies.
  bool follows_accelerations() const;
  /// After a step that began anew, before update(): with the accelerations and multipliers with which it
  /// began, which are known then. The system's last kinematics are of that state.
  void begin(relative::RelativeSystem& system, const State& state);

  const EnergyBalance& balance() const { return balance_; }
  /// Energy that the numerics put in during the last step.
  double last_input() const { return last_input_; }
  /// Energy that jumps of the road under the tyres released or stored in it.
  double last_jump() const { return jump_; }
  /// Something that stores energy.
  struct Place {
    enum class Kind { none, element, body } kind = Kind::none;
    int index = -1;
    void transfer(StateTransfer& transfer) {
      int number = static_cast<int>(kind);
      transfer(number, index);
      kind = static_cast<Kind>(number);
    }
  };
  /// What exchanged most energy in it.
  Place last_place() const { return place_; }
  /// Where most energy came and went faster than the steps can follow: the largest sum of second differences.
  struct Unresolved {
    Place place;
    double steps_per_period = 0;  ///< of the vibration that would have these differences, roughly
    double at_play = 0;           ///< J, between the highest and the lowest energy there
  };
  /// Of places with more than `nothing` J at play: less is round-off.
  Unresolved most_unresolved(double nothing) const;

  /// All that it remembers from step to step.
  void transfer(StateTransfer& transfer) {
    for (const EnergyTerm& term : energy_terms) transfer(balance_.*term.value);
    transfer(start_total_, last_input_, jump_, pending_jump_, most_exchanged_, started_, time_);
    place_.transfer(transfer);
    for (Flow& f : flows_) f.transfer(transfer);
    for (Store& s : stores_) transfer(s.energy, s.change, s.highest, s.lowest, s.exchanged, s.unresolved);
    transfer(drive_position_, drive_force_, damping_force_, modal_, geometric_force_);
  }

 private:
  /// What an element was after the step before. `progress`: what it measured, or where its force moves along
  /// a rate that is none of that, the rate.
  struct Flow {
    double progress[6] = {}, dissipating[6] = {}, working[6] = {}, inner[6] = {};
    double held = 0;
    double height = 0, road = 0, along = 0, slope = 0;                                 ///< on a road
    double gap = 0, spring = 0, surroundings[surroundings_size(Measure::wheel)] = {};  ///< of a wheel
    Eigen::Vector3d load_position = Eigen::Vector3d::Zero(), load_force = Eigen::Vector3d::Zero();
    double load_power = 0;
    void transfer(StateTransfer& transfer) {
      for (double* component : {progress, dissipating, working, inner})
        for (int k = 0; k < 6; ++k) transfer(component[k]);
      for (double& x : surroundings) transfer(x);
      for (int k = 0; k < 3; ++k) transfer(load_position[k], load_force[k]);
      transfer(held, height, road, along, slope, gap, spring, load_power);
    }
  };
  /// What a place stores, and how that has changed from step to step.
  struct Store {
    Place place;
    double energy = 0, change = 0, highest = 0, lowest = 0;
    double exchanged = 0, unresolved = 0;  ///< sums of first and second differences, in size
  };
  void observe(relative::RelativeSystem& system, const State& state);
  void observe_element(std::size_t element, relative::Workspace<double>& work, double h);
  static void keep(const ElementData& element, const ElementState<double>& state, const ElementEnergy& now,
                   Flow& flow);
  void observe_load(const ElementState<double>& state, const Motion<double>& frame, const Vec3d& origin,
                    double h, Flow& flow);
  void observe_road(std::size_t element, const LawContext<double>& context, const ElementState<double>& state,
                    relative::Workspace<double>& work, double stored, Flow& flow);
  void observe_wheel(const LawContext<double>& context, const ElementState<double>& state,
                     const ElementEnergy& now, double h, Flow& flow);
  static void keep_wheel(const ElementState<double>& state, const ElementEnergy& now, Flow& flow);
  void jump_element(std::size_t element, relative::Workspace<double>& work);
  void observe_store(std::size_t store, double energy);
  void inertial_forces(std::size_t body, const relative::Workspace<double>& work, const State& state,
                       const double* y, double* forces) const;
  void observe_geometric(std::size_t body, const relative::Workspace<double>& work, const State& state,
                         const double* y, double* forces);

  const Compiled* model_;
  EnergyBalance balance_;
  double start_total_ = 0, last_input_ = 0;
  double jump_ = 0, pending_jump_ = 0;  ///< in the last step; of a road that has jumped since then
  Place place_;
  double most_exchanged_ = 0;  ///< in the last step, at place_
  bool started_ = false;
  std::vector<Flow> flows_;    ///< of elements
  std::vector<Store> stores_;  ///< elements, bodies
  std::vector<double> generalised_, drive_position_, drive_force_;
  Eigen::VectorXd damping_force_, modal_, geometric_force_;
  double time_ = 0;
};

/// Kinetic energy from the bodies' motion (the last kinematics) and of what elements with inertia measure
/// (the last forces), J; uses the workspace's scratch.
double kinetic_energy(const Compiled& model, relative::Workspace<double>& work, const double* q,
                      const double* v);
/// Adds that of the body with this number.
void add_kinetic_energy(const Compiled& model, relative::Workspace<double>& work, std::size_t body,
                        const double* q, const double* v, double& energy);

}  // namespace mimbre
