#pragma once
#include <vector>

#include "dynamics/natural/system.h"
#include "dynamics/relative/momentum.h"
#include "dynamics/relative/system.h"
#include "dynamics/rigid_shift.h"
#include "simulation/step/flight_laws.h"

namespace mimbre {

/// Bodies that nothing but a floating joint ties to the rest of the world: no loop, spring, tyre or drive.
/// Gravity and loads act on them; `loads`: slots of what scales these.
struct FreeGroup {
  int root = -1;  ///< the body of the floating joint
  std::vector<int> bodies, loads;
  std::vector<char> has;  ///< by body
  bool rigid = false;     ///< nothing in it moves relative to the rest
};

std::vector<FreeGroup> free_groups(const Compiled& model);

/// Several trees of bodies with floating joints that loops, springs or contacts tie to each other, and
/// nothing to the ground: momentum is theirs together.
struct FloatingSet {
  std::vector<int> roots, bodies;
  std::vector<char> has;  ///< by body
};

std::vector<FloatingSet> floating_sets(const Compiled& model);

/// The laws that no rule of integration in coordinates keeps by itself: linear and angular momentum of what
/// flies freely are constant but for gravity, and the centre of mass is on its parabola; of what is rigid
/// also the energy of its rotation is constant. After a step the group is moved as one rigid body to where
/// they hold, by as much as the step was wrong. Where loads act, nothing is done. Knows of the last step only
/// what the state at its start determines. Allocates only when made.
class FreeFlight {
 public:
  explicit FreeFlight(const Compiled& model);
  bool none() const { return groups_.empty(); }
  const std::vector<FreeGroup>& groups() const { return groups_; }

  /// At the start of a step, after kinematics at the state.
  void begin(relative::RelativeSystem& observer, const State& relative);
  /// At its end, likewise; the state is then the corrected one, of which no kinematics was seen yet.
  /// `natural`: null, or the system that `state` belongs to, then `relative` is the same in relative
  /// coordinates; else both are one.
  void end(relative::RelativeSystem& observer, natural::NaturalSystem* natural, const State& relative,
           double h, State& state);

 private:
  bool loaded(const FreeGroup& group, const SignalValues<double>& signals) const;
  void find_gains(relative::RelativeSystem& observer, const State& relative, double h);

  struct Start : flight::Start<double> {
    bool loaded = false;
  };
  const Compiled& model_;
  std::vector<FreeGroup> groups_;
  std::vector<Start> starts_;
  Vec3d origin_ = Vec3d::Zero();
  bool changes_shape_ = false;       ///< any of the groups
  Eigen::VectorXd start_q_, rates_;  ///< coordinates at the start, and their rates over the step
};

/// Applies a shift, about the observer's common point, to one group of the state.
void shift_group(relative::RelativeSystem& observer, natural::NaturalSystem* natural, const FreeGroup& group,
                 const RigidShift& shift, State& state);

}  // namespace mimbre
