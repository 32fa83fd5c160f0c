#pragma once
#include <vector>

#include "dynamics/relative/workspace.h"
#include "forces/element.h"
#include "simulation/watch/contact_log.h"

namespace mimbre {

/// Slower impacts are not followed, m/s: what falls freely reaches as much in half a step of `whole` seconds.
double quiet_speed(const Compiled& model, double whole);

/// Looks whether a step shows what contacts did in it, and for what is pressed in too deep. Allocates only
/// when made; neither throws.
class ContactWatch {
 public:
  explicit ContactWatch(const Compiled& model);
  bool none() const { return seen_.empty(); }

  /// At the start, `states` likewise: what is pressed in too deep then.
  void look(const relative::Workspace<double>& work, const double* states);
  /// Before a step: of the states of force elements at its start. `keep`: they will have changed when the
  /// step is looked at.
  void begin(const double* states, bool keep);
  /// After a step of h seconds: whether no sphere went through a solid unseen, and impacts took many of such
  /// steps. Impacts of swarms, of which there are some in every step, do not count. `work`: of the forces at
  /// its end; `quiet`: speed of the impacts that do not count.
  bool followed(const relative::Workspace<double>& work, double h, double quiet);
  /// Adds what was seen in that step, which ends at `time` and is not made again, s.
  void note(double time, ContactLog& log) const;

 private:
  /// In the last step, by the places of a log.
  struct Seen {
    int passes = 0;
    ContactTrouble::Where passed, sank;
    double depth = 0, depth_limit = 0;
  };
  template <class F>
  void for_pairs(const relative::Workspace<double>& work, const F& f) const;
  void look_for_depth(int element, double gap, Seen& seen) const;
  void look_under_wheels(const relative::Workspace<double>& work);
  bool passes(int element, const double* start, const ElementState<const double>& s,
              const relative::Workspace<double>& work, double h, double quiet, Seen& seen) const;

  const Compiled& model_;
  int contacts_ = 0, own_surfaces_ = 0;  ///< of the model file; behind these surfaces spheres come
  int first_state_ = 0;
  const double* before_ = nullptr;  ///< states of contacts at the start of the step
  std::vector<double> kept_;        ///< where they are kept
  std::vector<Seen> seen_;
};

}  // namespace mimbre
