#include "mimbre/trim.h"

#include "analysis/trim_point.h"
#include "base/cpu_time.h"
#include "simulation/observe/channels.h"
#include "simulation/start/assembly.h"

namespace mimbre {

std::optional<double>* held_condition(TrimConditions& conditions, std::string_view name) {
  return name == "speed"                  ? &conditions.speed
         : name == "lateral_acceleration" ? &conditions.lateral_acceleration
         : name == "yaw_rate"             ? &conditions.yaw_rate
         : name == "radius"               ? &conditions.radius
                                          : nullptr;
}

TrimResult trim(std::shared_ptr<const Model> model, const TrimConditions& conditions,
                const RunOptions& options) {
  const double start = thread_cpu_seconds();
  const Compiled& m = model->compiled();
  relative::RelativeSystem system(m);
  const State assembled = assembled_state(m, system, options.inputs);
  const linear::Trim found = linear::find_trim(m, system, assembled, options.inputs, conditions);
  TrimResult out;
  out.body =
      m.spec().bodies[static_cast<std::size_t>(m.bodies[static_cast<std::size_t>(found.body)].spec)].name;
  out.speed = found.speed;
  out.yaw_rate = found.yaw_rate;
  out.lateral_acceleration = found.yaw_rate * found.speed;
  out.sideslip = found.sideslip;
  for (const std::string& name : conditions.find) {
    for (const spec::Input& input : m.spec().inputs)
      if (input.name == name) out.found.push_back({name, input.unit, found.inputs.at(name)});
  }
  const State& s = found.state;
  system.enter(s.u.data(), s.z.data(), 0);
  system.begin_step(s.q.data());
  Eigen::VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  Channels channels(m);
  EnergyMeter meter(m);
  meter.start(system, s);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  ResultsRow row;
  channels.sample(system, s, meter.balance(), {}, row);
  out.channels = channels.info();
  out.values = row.channels;
  out.output_count = channels.output_count();
  out.iterations = found.iterations;
  out.residual = found.residual;
  out.cpu_seconds = thread_cpu_seconds() - start;
  return out;
}

}  // namespace mimbre
