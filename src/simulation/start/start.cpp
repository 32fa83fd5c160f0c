#include "simulation/start/start.h"

#include <fmt/format.h>

#include "integrate/initial.h"
#include "integrate/vectors.h"
#include "simulation/describe/explain.h"
#include "simulation/describe/names.h"
#include "simulation/start/accuracy_limits.h"
#include "simulation/start/assembly.h"
#include "simulation/start/drawn_open.h"
#include "simulation/start/held_elsewhere.h"
#include "simulation/start/locking.h"
#include "simulation/start/redundancy.h"
#include "simulation/start/start_branches.h"
#include "simulation/step/free_flight.h"
#include "simulation/step/swarm_search.h"

namespace mimbre {
namespace {

/// Why there are no accelerations to start with.
std::string explain_start(Mechanism& mechanism, int undetermined) {
  System& system = mechanism.system;
  State& s = mechanism.state;
  s.a.setZero();
  s.multipliers.setZero();
  Eigen::VectorXd forces(system.velocities());
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, forces.data());
  if (const std::string constraint = explain_lost_constraint(mechanism); !constraint.empty())
    return "at the start " + constraint;
  const int bad = find_not_finite(forces.data(), system.velocities());
  if (bad < 0) return explain_undetermined_start(mechanism.model, mechanism.natural.get(), undetermined);
  return fmt::format(
      "a force is not a number at the start, first in {}; look at the laws of what acts there: a root or a "
      "logarithm of something negative, a division by 0",
      coordinate_name(mechanism.model, mechanism.natural.get(), bad));
}

}  // namespace

Start start(Mechanism& mechanism, const Method& method, const std::map<std::string, double>& inputs,
            bool warns) {
  const Compiled& m = mechanism.model;
  relative::RelativeSystem& observer = mechanism.observer;
  Start found;
  const auto warn = [&](const std::string& text) {
    if (warns && !text.empty()) found.warnings.push_back(text);
  };
  State assembled = assembled_state(m, observer, inputs);
  if (warns) warn(drawn_open(observer, assembled));
  if (m.spec().simulation.start_at_equilibrium) {
    warn(start_at_equilibrium(observer, assembled));
    if (warns) warn(explain_sampled_laws(m));
  }
  mechanism.seen = assembled;
  if (m.equations > 0) {
    found.redundancy = find_redundancy(observer, assembled);
    warn(explain_near_redundancy(found.redundancy));
    if (warns && found.redundancy.equations + found.redundancy.nearly > 0)
      warn(explain_open_bending(m, bodies_of_open_bending(observer, assembled), found.redundancy));
    if (warns)
      for (const std::string& text : locking_warnings(observer, assembled)) warn(text);
  }
  if (warns) warn(explain_held_elsewhere(m.spec(), bodies_held_elsewhere(m.spec())));
  mechanism.state = mechanism.natural ? natural_state(*mechanism.natural, observer, assembled) : assembled;
  mechanism.state.u = assembled.u;
  mechanism.state.z = assembled.z;
  if (SwarmSearch swarms(m); !swarms.none()) {
    mechanism.observe_afresh();
    swarms.find(observer.workspace(), method.step, mechanism.state.z.data());
    for (const std::string& text : swarm_warnings(m, method.step)) warn(text);
  }
  mechanism.enter(0);
  int undetermined = -1;
  if (!solve_accelerations(mechanism.system, mechanism.state, method.step, &undetermined))
    throw InputError({m.spec().file, 0, 0}, explain_start(mechanism, undetermined));
  if (method.integrator == spec::Simulation::Integrator::conserve && !m.drives.empty())
    warn(fmt::format(
        "integrator conserve: drives prescribe velocities, so that {} to take back the energy that the "
        "numerics feed in; look at energy.numerical, or take a smaller step",
        free_groups(m).empty() ? "nothing is left" : "only turns of what flies freely are left"));
  if (method.accuracy > 0) warn(accuracy_limits(m));
  mechanism.observe();
  mechanism.commit(false);
  if (warns) warn(explain_branches(observer, mechanism.view()));
  return found;
}

}  // namespace mimbre
