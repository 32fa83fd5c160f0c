#include "mimbre/statics.h"

#include <stdexcept>

#include "base/cpu_time.h"
#include "simulation/describe/explain.h"
#include "simulation/observe/channels.h"
#include "simulation/observe/smallest_reactions.h"
#include "simulation/start/assembly.h"
#include "simulation/start/drawn_open.h"
#include "simulation/start/redundancy.h"

namespace mimbre {

StaticResult static_equilibrium(std::shared_ptr<const Model> model, const RunOptions& options) {
  const double start = thread_cpu_seconds();
  const Compiled& m = model->compiled();
  const Method method = resolve_method(m.spec().simulation, options);
  relative::RelativeSystem system(m, method.inertia);
  const auto natural = make_natural(m, method);
  State s = assembled_state(m, system, options.inputs);
  StaticResult result;
  const auto warn = [&](const std::string& text) {
    if (!text.empty()) result.warnings.push_back(text);
  };
  warn(drawn_open(system, s));
  const StaticsStatus status = equilibrium(natural.get(), system, s);
  if (!status.converged) throw std::runtime_error(explain_imbalance(m, natural.get(), status));
  result.stable = !(status.growth > 0);
  warn(explain_instability(m, natural.get(), status));
  Channels channels(m);
  EnergyMeter meter(m);
  Eigen::VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  meter.start(system, s);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  if (m.equations > 0) {
    const Redundancy redundancy = find_redundancy(system, s);
    warn(explain_near_redundancy(redundancy));
    channels.mark_undetermined(redundancy);
    system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
    if (redundancy.equations + redundancy.nearly > 0 && SmallestReactions(m).find(system, s, s.multipliers))
      system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  }
  ResultsRow row;
  channels.sample(system, s, meter.balance(), {}, row);
  result.channels = channels.info();
  result.values = row.channels;
  result.output_count = channels.output_count();
  result.iterations = status.iterations;
  result.residual = status.residual;
  result.sparse = status.sparse;
  result.load_steps = status.load_steps;
  result.cpu_seconds = thread_cpu_seconds() - start;
  return result;
}

}  // namespace mimbre
