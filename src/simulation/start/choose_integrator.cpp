#include "simulation/start/choose_integrator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "integrate/explicit/fastest_motion.h"
#include "math/elementary.h"
#include "simulation/start/assembly.h"
#include "simulation/step/mechanism.h"

namespace mimbre {
namespace {

using Rule = spec::Simulation::Integrator;

/// By the mechanism's pace: the steps whose estimated error is a part of the mechanism's size, by the order
/// of the estimate.
constexpr double whole_error_step = 2;
constexpr double order_of_dopri853 = 8, order_of_radau = 4;
/// Evaluations of the forces in a step, matrices counted as evaluations.
constexpr double cost_of_dopri853 = 12, cost_of_radau = 40;
/// Without a pattern the matrices of radau are dense: from this many coordinates on they cost more than that.
constexpr int most_dense = 100;

Method with(Method method, Rule rule, std::string why) {
  method.integrator = rule;
  method.chosen = std::move(why);
  return method;
}

}  // namespace

Method choose_integrator(const Compiled& model, Method method, const std::map<std::string, double>& inputs) {
  if (method.integrator != Rule::automatic) return method;
  method.integrator = Rule::radau;
  if (!model.spec().contacts.empty())
    return with(method, Rule::radau, "the model has contacts, which are stiff while they are closed");
  Mechanism mechanism(model, method);
  State state = assembled_state(model, mechanism.observer, inputs);
  if (mechanism.natural) {
    const State relative = state;
    state = natural_state(*mechanism.natural, mechanism.observer, relative);
    state.u = relative.u;
    state.z = relative.z;
  }
  System& system = mechanism.system;
  system.enter(state.u.data(), state.z.data(), 0);
  const double fastest = fastest_motion(system, state);
  if (!(fastest > 0) && model.velocities > 0) {
    Eigen::VectorXd r(system.velocities());
    system.residual(state.time, state.q.data(), state.v.data(), state.a.data(), state.multipliers.data(), 0,
                    r.data());
    if (!system.factor_inertia(state.q.data(), 1e6).ok())
      return with(method, Rule::radau, "something that moves has no mass");
  }
  const Scales& scales = system.scales();
  const double pace = std::max(scales.rate(state.v.data()), scales.of_coordinates(state.v.data()));
  const auto accurate = [&](double order) {
    return pace > 0 ? std::min(method.step, whole_error_step / pace * mimbre::pow(method.accuracy, 1 / order))
                    : method.step;
  };
  const double stable = fastest > 0 ? stable_reach(Rule::dopri853) / fastest : method.step;
  const double wanted = accurate(order_of_dopri853), explicitly = std::min(wanted, stable);
  const double implicitly = accurate(order_of_radau);
  if (system.pattern().size() == 0 && system.velocities() > most_dense)
    return with(method, Rule::dopri853,
                fmt::format("its time grows with the number of bodies only, of which the chains have many "
                            "(fastest motion at the start: {:.3g} 1/s)",
                            fastest));
  if (explicitly / cost_of_dopri853 >= implicitly / cost_of_radau)
    return with(
        method, Rule::dopri853,
        fmt::format("nothing is stiff at the start: the fastest motion there, {:.3g} 1/s, permits it steps "
                    "of {:.2g} s, and the accuracy asks for about {:.2g} s",
                    fastest, std::min(stable, method.step), wanted));
  return with(
      method, Rule::radau,
      fmt::format("the fastest motion at the start, {:.3g} 1/s, would hold dopri853 to steps of {:.2g} s, "
                  "and the accuracy asks for about {:.2g} s",
                  fastest, stable, wanted));
}

}  // namespace mimbre
