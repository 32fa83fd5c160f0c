#pragma once
#include <memory>
#include <vector>

#include "integrate/profiled_system.h"
#include "mimbre/simulation.h"
#include "simulation/step/contact_watch.h"
#include "simulation/step/energy.h"
#include "simulation/step/energy_keeper.h"
#include "simulation/step/free_flight.h"
#include "simulation/step/mechanism.h"
#include "simulation/step/swarm_search.h"

namespace mimbre {

/// Makes the steps of a mechanism: the integrator's, with the laws of free flight and of energy kept where
/// that is asked for, and once more in parts where an impact made one inaccurate; where it has contacts,
/// parts in parts. Allocates only when made.
class StepMaker {
 public:
  StepMaker(Mechanism& mechanism, const Method& method);
  /// After the start, and where the observation begins anew: energies count from this state, kinematics
  /// evaluated.
  void start();
  /// A step of `length` seconds. What fails leaves the state as it was.
  StepReport step(double length);
  /// From now on the state before each step is kept, for undo().
  void keep_before(bool keep) { keeps_ = keep; }
  /// Takes the last step back.
  void undo();
  /// What it remembers from step to step beside the state and the system's tangent marks.
  void transfer(StateTransfer& transfer);
  /// The integrator's part of it, which comes first there; or nothing of it is remembered.
  void transfer_integrator(StateTransfer& transfer) {
    integrator_->transfer(transfer);
    integrator_->transfer_matrix(transfer);
  }
  void forget() { integrator_->forget(); }

  /// How often the iterations of a step may begin anew: for itself and for its parts.
  int most_attempts() const;

  const EnergyMeter& meter() const { return meter_; }
  /// What went wrong at contacts since the start.
  const ContactLog& contacts() const { return log_; }
  /// Of the integrator's last step.
  const StepStatus& last() const { return last_; }
  double length() const { return length_; }  ///< of the last step, s
  /// What is round-off in energies when nothing is at play, or what contacts play with as they come to rest,
  /// J.
  double resting_energy() const { return resting_energy_; }

  /// Seconds of the evaluations and of the energies, where Method::profile asks for them.
  const PhaseSeconds& phases() const { return profiled_.seconds(); }
  double energy_seconds() const { return energy_seconds_; }

 private:
  /// Where a step began, and its parts, and their parts.
  struct Begin {
    State state;
    EnergyMeter meter;
    ContactLog log;
    std::vector<double> memory;  ///< of the integrator
  };

  void prepare();
  void begin_anew();
  void advance(StepReport& report);
  void book_beginning();
  const State& observe_end(bool known);
  void keep_in(Begin& begin) const;
  void back_to(const Begin& begin);
  void cover(double length, int level, StepReport& report);
  void cover_by_error(double length, StepReport& report);
  double growth_by_error(double part, double error) const;
  bool accurate(int level) const;
  int most_divisions() const;
  double step_error() const;
  double step_tolerance() const;

  Mechanism& mechanism_;
  const Method& method_;
  ProfiledSystem profiled_;
  std::unique_ptr<Stepper> integrator_;
  const bool conserves_;
  FreeFlight free_flight_;
  EnergyKeeper energy_keeper_;
  SwarmSearch swarms_;
  EnergyMeter meter_;
  ContactWatch contacts_;
  ContactLog log_;
  std::vector<Begin> begins_;
  State beginning_;         ///< of a step that began anew
  State end_;               ///< with the accelerations of the equations
  const bool stressed_;     ///< loads of inertia stiffen bodies
  Begin before_;            ///< of the last step, for undo()
  bool followed_ = true;    ///< contacts in the integrator's last step
  int divisions_left_ = 0;  ///< how often a part of the step under way may still be divided
  StepStatus last_;
  bool keeps_ = false;
  bool under_way_ = false;  ///< a step has been made since the start
  double length_ = 0;
  double next_part_ = 0;  ///< s, that the error of the last part asks for; 0: there was none
  double accepted_part_ = 0,
         accepted_error_ = 0;  ///< of the last part that was accepted: s, over the accuracy
  double lifting_energy_ = 0;  ///< of the whole mechanism by its length scale, J
  double resting_energy_ = 0;
  double energy_seconds_ = 0;
};

}  // namespace mimbre
