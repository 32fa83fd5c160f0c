#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "dynamics/relative/workspace.h"
#include "dynamics/state_transfer.h"
#include "integrate/stepper.h"
#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "simulation/watch/held_stretch.h"
#include "simulation/watch/lag.h"

namespace mimbre {

/// Watches what the linear description of flexible bodies neglects, and keeps the worst of it by body. All
/// measures are ratios; from these limits on they make a warning:
namespace validity_limit {
/// Displacement over length. The rotations' sines and curvatures are then wrong by about 1 % (a cantilever's
/// tip turns by 0.15), and a tip load's deflection by 1 % (K. E. Bisshopp, D. C. Drucker, Large deflection of
/// cantilever beams, Quarterly of Applied Mathematics 3 (1945) 272–275); from there on it grows as the
/// square.
constexpr double deflection = 0.1;
/// The same for a body that passes motion on: one that more than one joint holds, a shaft in its bearings or
/// a link of a mechanism. What neglected terms do to its own bending, of the order of the square of the
/// deflection, they do there to the frequencies and phases of everything it moves, and it adds up over turns:
/// a rotor through its critical speed is off by 13 % at a deflection of 4.6 %, a skew four-bar by 3.5 to 8 %
/// at 3.6 %. At this limit both are off by 1 to 2.5 %.
constexpr double deflection_of_link = 0.02;
/// The same as `deflection` for bodies whose displacements or energy are of second order in the modes: what
/// is left out is then of third order, and as small at twice the deflection (0.2³ against 0.1²).
constexpr double deflection_of_second_order = 0.2;
constexpr double deflection_of_second_order_link = 0.1;
/// Bent by this a cantilever is longer by 5 % of its length than any real one, and 10 % too soft: solutions
/// of its equations, if there are any, are none of the part.
constexpr double meaningless_deflection = 0.3;
/// Shortening by bending, ½∫v'² ds over length, where it is more than what the modes stretch the body by. A
/// cantilever with a deflection of 9 % of its length under a tip load; bows and waves come to it earlier.
constexpr double foreshortening = 0.005;
/// Geometric over elastic stiffness in the shape that suffers most: a frequency is then wrong by 7 %, and a
/// vibration out of phase after seven periods. For compression this is load over buckling load of the body
/// held at its tangent frame. That frame is the right one also where joints hold the body otherwise: of a rod
/// with two hinges the linear description in the tangent frame misses three times load over (pinned) buckling
/// load, which is three quarters of this ratio.
constexpr double load = 0.15;
/// The same that tension or compression leaves out, over time: of deflections by their range. It counts where
/// they are more than this share of the length: less is what joints and their clearances move a body by.
constexpr double lag = 0.1, lag_from = 1e-3;
/// How much deflections are too large where ends or edges are held, so that bending would have to stretch the
/// body.
constexpr double held = 0.1;
/// Largest elastic energy of the highest third of the dynamic modes over the largest of all: what the missing
/// modes would hold is then no longer small. Under loads that change slowly the energies of a series fall as
/// the square of the frequency at least; a tenth in the last mode shows that they do not. Not judged for the
/// substructures of a beam: vibrations pass from one to the next, so that the share of one has no meaning.
constexpr double high_modes = 0.1;
}  // namespace validity_limit

/// Which measures make warnings depends on the body:
///   linear                 all
///   geometric stiffness    all; of loads only those it does not contain: forces on frames without static
///                          modes
///   second order           deflection and high modes: displacements or energy contain shortening and loads
///   linear substructure    deflection and loads, which stiffen or soften it alone: bent by several
///                          substructures at once, a beam shortens and buckles by more than any of them sees

/// Measures of one body that are sums of squares of linear functions of its amplitudes, and those that are
/// linear in its acceleration and in the forces on it. Made once.
class BodyValidity {
 public:
  BodyValidity(const Compiled& model, int body);

  /// Amplitudes of an accepted step. Neither allocates nor throws.
  void watch(const double* positions, double time);
  /// Forces and motion: the workspace after the residual of an accepted step. Likewise.
  void watch_loads(const relative::Workspace<double>& work, double time);
  /// Modes of the body in the mechanism that it starts in, `response`: response_at() of its amplitudes.
  void start_lag(const Compiled& model, const Eigen::MatrixXd& response, const double* positions,
                 double time);
  int first_velocity() const { return first_velocity_; }
  int modes() const { return modes_; }
  /// The same of a stretch that is neglected, see HeldStretch::find.
  void forget_energies() { passed_.high_modes = -1; }
  void watch_held(const HeldStretch::Ratios& ratios, double time);
  /// Forgets everything.
  void start();
  /// What it has seen so far.
  void transfer(StateTransfer& transfer);
  const Validity& worst() const { return worst_; }
  /// What is beyond its limit and what helps; empty when nothing is.
  std::string warning() const;
  /// That it is bent so far that its equations mean nothing, and what helps; empty when it is not.
  std::string meaningless() const;

 private:
  /// Rows [first, last) of functionals_.
  struct Range {
    int first = 0, last = 0;
  };
  /// When a measure passed its limit first; negative: never.
  struct Passed {
    double deflection = -1, foreshortening = -1, compression = -1, tension = -1, lag = -1, held = -1,
           high_modes = -1;
  };
  void add_points(const ReducedBody& body);
  void add_lines(const ReducedBody& body);
  void add_energies(const ReducedBody& body);
  void add_loads(const Compiled& model, const ReducedBody& body);
  /// Geometric stiffness knows of stress by inertia and gravity, and of forces where static modes represent
  /// them.
  void leave_out_known_loads(const GeometricStiffness& known);
  void watch_lag(const double* amplitudes, double time);
  Range add_rows(const Eigen::MatrixXd& rows);
  Range add_form(const Eigen::MatrixXd& form);
  double squares(Range range) const;
  /// Keys of the model file with which a body may bend farther.
  const char* nonlinear() const;

  int body_ = 0, first_amplitude_ = 0, first_velocity_ = 0, modes_ = 0, first_frame_ = 0, last_frame_ = 0,
      outboard_frame_ = 0;
  double length_ = 0, deflection_limit_ = validity_limit::deflection;
  bool second_order_ = false, piece_ = false, feels_stress_ = false, bars_ = false;
  Eigen::MatrixXd functionals_;  ///< rows × modes
  Eigen::VectorXd values_;       ///< functionals times amplitudes
  Range points_;                 ///< three rows each
  Range shortening_, stretch_, energy_, high_energy_;

  /// Geometric stiffness between pairs of the lowest modes, over their elastic one: coefficients by pair of
  /// the acceleration (3), its gradient (9, row-major) and the forces on the frames (3 each), body axes.
  int load_modes_ = 0;
  Eigen::MatrixXd load_coefficients_;  ///< pairs × (12 + 3 (frames + 1)), the last frame the outboard one
  Eigen::VectorXd load_values_, stiffening_;
  Lag lag_;

  Validity worst_;
  Passed passed_;
  double most_energy_ = 0, most_high_energy_ = 0;
  bool too_stiff_ = false;  ///< what held ends make of it: deflections are too small
};

/// All flexible bodies of a model.
class ValidityMonitor {
 public:
  explicit ValidityMonitor(const Compiled& model);
  bool empty() const { return bodies_.empty(); }
  /// From this state on (State::u and z are those of `inputs`).
  void start(const State& state, const State& inputs);
  void transfer(StateTransfer& transfer);
  /// Whether forces and motion are watched of any body.
  bool watches_loads() const;
  /// After every accepted step, with the state in relative coordinates. Neither allocates nor throws.
  void watch(const State& state);
  /// The same of one instant, which decides nothing about what modes are missing: a load along a beam strains
  /// its highest modes alone.
  void watch_instant(const State& state);
  void watch_loads(const relative::Workspace<double>& work, double time);
  /// Before the first loads, with a system that computes at this state.
  void start_lag(relative::RelativeSystem& system, const State& state);

  std::vector<Validity> worst() const;
  std::vector<std::string> warnings() const;
  /// Of the body that is bent the farthest, where that means nothing; else empty.
  std::string meaningless() const;

 private:
  std::vector<BodyValidity> bodies_;
  HeldStretch held_;
  std::vector<std::size_t> of_held_;  ///< which of bodies_ each of its bodies is
};

}  // namespace mimbre
