#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/energy.h"
#include "mimbre/method.h"
#include "mimbre/model.h"
#include "mimbre/violations.h"

namespace mimbre {

/// How a step ended. Everything but ok leaves the state as it was before the step.
struct StepReport : Violations {
  enum class Code {
    ok,
    not_converged,
    not_finite,
    singular,
    drifted,
    unstable,
    beyond_table,  ///< of a loop by formalism global_modes
    block_failed
  } code = Code::ok;
  int iterations = 0;
  int factorisations = 0;
  int coordinate = -1;            ///< where it went wrong
  int equation = -1;              ///< likewise, where it was in a constraint equation
  double equation_violation = 0;  ///< of that equation, where the constraints came apart: m or rad
  double part = 0;                ///< s, that the accuracy asked for, where it asked for too short ones
  int substeps = 1;               ///< parts that the step was made in
  bool unconverged = false;       ///< taken before its iterations converged (RunOptions::fixed_cost)
  bool ok() const { return code == Code::ok; }
};

/// What the linear description of a flexible body neglected at worst in a run so far (see docs/theory.md),
/// each with the time when it was worst, s. All are ratios.
struct Validity {
  struct Peak {
    double value = 0, time = 0;
    bool watched = false;  ///< otherwise 0 has no meaning
  };
  std::string body;
  Peak deflection;      ///< largest displacement by the modes over the body's length
  Peak foreshortening;  ///< ½∫v'² ds over length: how much bending would shorten its lines on average
  double axial = 0;     ///< what the modes changed the lines' length by then, likewise (root mean square)
  Peak compression;     ///< load over buckling load, held at the tangent frame
  Peak tension;         ///< geometric over elastic stiffness in the shape that it stiffens most
  /// Largest error of the deflections, over their range, since vibrations are faster under tension and slower
  /// under compression than linear theory has them
  Peak lag;
  /// By how much deflections are too large since bending would stretch the body between what holds it
  Peak held;
  Peak high_modes;  ///< largest energy of the highest third of the dynamic modes over the largest of all
};

/// Constraint equations that repeat others, in the assembled position: of the reactions of the
/// joints concerned rigid bodies determine only sums, and those given are the smallest ones.
struct Redundancy {
  int equations = 0;                ///< so many could be left out
  std::vector<std::string> joints;  ///< whose reactions depend on it, in the order of the model
  /// The same where equations are not redundant, but so nearly that reactions are arbitrary: axes that are
  /// meant to be in line, or parallel, and are off by a little.
  int nearly = 0;
  std::vector<std::string> nearly_joints;
  std::vector<std::string> constraints, nearly_constraints;  ///< the same of constraints
};

/// An event of the model, and how often it happened so far (spec::Event).
struct EventRecord {
  std::string name;
  std::int64_t count = 0;
  double first = std::numeric_limits<double>::quiet_NaN();  ///< s, when it happened
  double last = std::numeric_limits<double>::quiet_NaN();
  bool stops = false;  ///< it ends a run
};

/// A compiled model in motion. One thread at a time; any number of simulations may share a Model.
///
/// Names that the model does not have throw UnknownName where a handle is asked for. A handle of nothing (an
/// index out of range) throws std::out_of_range, and a number that is not finite std::invalid_argument, from
/// every call that takes one; the message begins with the call's name, and nothing has changed. The checks
/// take constant time. Nothing else is thrown while stepping.
class Simulation {
 public:
  /// Closes the loops, finds consistent velocities, the equilibrium if asked for, and accelerations.
  /// Throws InputError when the loops do not close, the given initial values contradict each other, or there
  /// is no input that RunOptions::inputs names.
  explicit Simulation(std::shared_ptr<const Model> model, const RunOptions& options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;

  /// One step. Allocates nothing, throws nothing, makes a bounded number of iterations. Where an event
  /// happens within it, it is made in parts, of which one ends there; where that stops the run, it ends there
  /// itself.
  StepReport step();
  /// The same, of the length that ends at `time` (later than now): for the rest of a run that is no whole
  /// number of steps. Throws std::invalid_argument for a time that is not later.
  StepReport step_to(double time);
  double time() const;
  double step_size() const;
  /// What the run takes: formulation, integrator, tolerances, …
  const Method& method() const;
  /// What went wrong where, for people ("the iterations of the step to t = 1.23 s did not converge; largest
  /// correction in 'front_left.arm'").
  std::string explain(const StepReport& report) const;

  /// Whether an event ended the last step and stops the run. Another step makes the rest of it.
  bool stopped() const;
  /// The model's events, in its order.
  std::vector<EventRecord> events() const;

  /// Wall seconds spent so far in the phases of the steps, when RunOptions::profile was set: inverse
  /// dynamics, assembly and factorisation of the matrix, its solutions, kinematics of the projections, energy
  /// balance, the rest.
  struct Phases {
    double residual = 0, matrix = 0, solution = 0, projection = 0, energy = 0, other = 0;
  };
  Phases phases() const;

  /// How often at most the iterations of a step begin anew: where it is made again in parts, where a part is
  /// divided further, and near singular positions. Each time there are at most Method::max_iterations.
  /// Events, whose instants are searched for, are not counted.
  int most_attempts() const;

  /// Unknowns and constraint equations of the formulation in use.
  int coordinates() const;
  int constraints() const;

  /// Seconds of this thread's CPU that initialisation took, with equilibrium.
  double initialisation_seconds() const;

  /// Everything that the next step depends on, and all that was observed so far: restoring it gives the same
  /// bits from there on, of the motion, all channels and warnings, in this simulation, in another one of the
  /// same model and method, and in another process of the same program. A copy of it is a clone.
  struct Snapshot {
    std::uint64_t model = 0;  ///< Simulation::fingerprint(); 0: of no particular model
    double time = 0;          ///< s
    Eigen::VectorXd q, v, a, algorithmic, multipliers;
    Eigen::VectorXd z;  ///< internal states of force elements
    Eigen::VectorXd u;  ///< inputs, sampled signals, integrals of signals
    bool started = false;
    double energy_error = 0;  ///< J, that the integrator `conserve` has still to take back
    Eigen::VectorXd marks;    ///< the tangents in the factorised matrix: when it is made anew depends on them
    Eigen::VectorXd memory;   ///< of the integrator, the energy balance and all that watches, one flat block

    /// All of it as one block, with the version of its layout and a checksum (docs/states.md).
    std::vector<std::byte> bytes() const;
    /// Throws InputError where that is no such block, damaged, or of another version.
    static Snapshot from_bytes(std::span<const std::byte> bytes);
  };
  Snapshot save() const;
  /// The same into memory that is reused: does not allocate where `snapshot` is one of this model.
  void save(Snapshot& snapshot) const;
  /// Why restore() will refuse the snapshots of a run that has begun: a block that is computed by code from
  /// elsewhere cannot save its state. Empty: it will not.
  std::string not_saved() const;
  /// Throws InputError, and changes nothing, when the snapshot is of another model or method, or when it
  /// lacks the state of a block that cannot save it.
  void restore(const Snapshot& snapshot);
  /// Goes on from the motion of a snapshot, which may be made by hand, and observes anew: energies and
  /// warnings count from there. Throws InputError when its sizes are not the model's.
  void restart(const Snapshot& snapshot);
  /// Identifies model and method: the model's text, what it computes, and the method. Never 0.
  std::uint64_t fingerprint() const;

  /// Named channels: the model's outputs first (`output_count` of them), then the standard ones.
  const std::vector<ChannelInfo>& channels() const;
  int output_count() const;
  /// Place of a channel in channels(). Throws UnknownName, with a name that is like it, when there is none.
  struct Channel {
    int index = -1;
  };
  Channel channel(const std::string& name) const;
  /// A channel's value now. Allocates nothing, and evaluates what the channel needs: kinematics, forces or
  /// reactions, once per step for all channels. Throws std::out_of_range.
  double value(Channel channel);
  /// The same for bodies, of the model as it was given.
  struct Body {
    int index = -1;
  };
  Body body(const std::string& name) const;
  /// Position and rotation of a body's frame now, global. Allocates nothing. Throws std::out_of_range.
  spec::Pose pose(Body body);
  /// Time, all channels, poses and modal amplitudes now. Reuses the row's memory.
  void sample(ResultsRow& row);
  /// The same without the channels, which stay as they are in the row: what a picture needs.
  void picture(ResultsRow& row);
  /// Everything a results file needs to explain itself.
  ResultsHeader header(const std::string& options_json) const;

  /// Inputs and tunable parameters, and the number of one by its name. Throws UnknownName if there is none.
  const std::vector<spec::Input>& inputs() const;
  int input(const std::string& name) const;
  /// Sets one for the steps that follow. What lies beyond its range is cut to it, and warnings() has how
  /// often. Allocates nothing. Throws std::out_of_range, and std::invalid_argument for NaN and infinities: a
  /// host that takes values from elsewhere in a real-time thread checks them first.
  void set_input(int input, double value);
  /// Throws std::out_of_range.
  double input_value(int input) const;

  /// The energy balance so far (see docs/theory.md); not a number where it is not watched
  /// (RunOptions::energies).
  const EnergyBalance& energy() const;
  /// Warnings that arose (energy fed in by the numerics, flexible bodies beyond linear theory), with time and
  /// place; grows while stepping.
  std::vector<std::string> warnings() const;
  /// The flexible bodies, in tree order. Deflections and energies are of every step, loads of every 16th.
  /// None where RunOptions::validity is off.
  std::vector<Validity> validity() const;
  /// Independent motions at the current position: coordinates less the rank of the constraints.
  int degrees_of_freedom();

  /// Redundant constraints at the current position.
  Redundancy redundancy();

  const Model& model() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre
