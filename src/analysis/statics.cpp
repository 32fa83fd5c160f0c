#include "mimbre/statics.h"

#include <fmt/format.h>

#include <stdexcept>

#include "base/cpu_time.h"
#include "simulation/assembly.h"
#include "simulation/channels.h"

namespace mimbre {

StaticResult static_equilibrium(std::shared_ptr<const Model> model, const RunOptions& options) {
  const double start = thread_cpu_seconds();
  const Compiled& m = model->compiled();
  const Method method = resolve_method(m.spec.simulation, options);
  relative::RelativeSystem system(m, method.inertia);
  const auto natural = make_natural(m, method);
  State s = assembled_state(m, system);
  const StaticsStatus status = equilibrium(natural.get(), system, s);
  if (!status.converged)
    throw std::runtime_error(
        fmt::format("no static equilibrium was found: unbalanced force {:.3g}, constraints off by "
                    "{:.3g} after {} iterations",
                    status.residual, status.violation, status.iterations));
  StaticResult result;
  Channels channels(m);
  EnergyMeter meter(m);
  Eigen::VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  meter.start(system, s);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  ResultsRow row;
  channels.sample(system, s, meter.balance(), {}, row);
  result.channels = channels.info();
  result.values = row.channels;
  result.output_count = channels.output_count();
  result.iterations = status.iterations;
  result.residual = status.residual;
  result.cpu_seconds = thread_cpu_seconds() - start;
  return result;
}

}  // namespace mimbre
