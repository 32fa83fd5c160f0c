#include "analysis/equilibria/sample_at_rest.h"

#include "simulation/describe/explain.h"
#include "simulation/observe/channels.h"
#include "simulation/observe/smallest_reactions.h"
#include "simulation/start/redundancy.h"

namespace mimbre {

AtRest sample_at_rest(const Compiled& m, relative::RelativeSystem& system, State& s) {
  AtRest out;
  Channels channels(m);
  EnergyMeter meter(m);
  Eigen::VectorXd r(m.velocities);
  const auto evaluate = [&] {
    system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  };
  system.enter_rest(s.u.data(), s.z.data());
  evaluate();
  meter.start(system, s);
  evaluate();
  if (m.equations > 0) {
    const Redundancy redundancy = find_redundancy(system, s);
    if (const std::string text = explain_near_redundancy(redundancy); !text.empty())
      out.warnings.push_back(text);
    channels.mark_undetermined(redundancy);
    evaluate();
    if (redundancy.equations + redundancy.nearly > 0 && SmallestReactions(m).find(system, s, s.multipliers))
      evaluate();
  }
  ResultsRow row;
  channels.sample(system, s, meter.balance(), {}, row);
  out.channels = channels.info();
  out.values = row.channels;
  out.output_count = channels.output_count();
  return out;
}

}  // namespace mimbre
