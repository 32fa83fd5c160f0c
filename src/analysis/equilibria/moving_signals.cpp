#include "analysis/equilibria/moving_signals.h"

#include <algorithm>
#include <cmath>

#include "simulation/observe/channels.h"
#include "simulation/step/signal_state.h"

namespace mimbre {
namespace {

/// Changes of a signal below this share of it are round-off.
constexpr double still_signal = 1e-9;

}  // namespace

std::vector<std::string> moving_signals(const Compiled& m, relative::RelativeSystem& system,
                                        const State& rest) {
  const double h = m.spec().simulation.step;
  State s = rest;
  Eigen::VectorXd r(m.velocities);
  const auto values = [&](double step) {
    system.enter(s.u.data(), s.z.data(), step);
    system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
    const auto& made = system.workspace().signals.value;
    return std::vector<double>(made.begin(), made.end());
  };
  const std::vector<double> before = values(0);
  if (m.signals.clock >= 0) {
    commit_blocks(m, system, s);
    s.u[m.signals.clock] = s.time - h;
    values(h);
    commit_blocks(m, system, s);
  }
  const bool outside = std::any_of(m.spec().blocks.begin(), m.spec().blocks.end(),
                                   [](const spec::Block& b) { return static_cast<bool>(b.outside); });
  if (!m.signals.sampled.empty() && !outside) {
    // What a block makes may answer as many instants later as it has states, and one signal after the other.
    int states = 0;
    for (const SignalsData::Block& b : m.signals.blocks)
      if (b.every > 0) states = std::max(states, std::min(b.states, 32));
    const int instants = 2 + static_cast<int>(std::ssize(m.signals.sampled)) + states;
    Sampler sampler(m, 0);
    const Channels channels(m);
    for (int k = 0; k < instants; ++k) {
      for (const SignalsData::Sampled& of : m.signals.sampled) s.u[of.held + of.values] = s.time;  // due
      values(0);
      sampler.sample(channels, system, rest, h, s);
    }
  }
  const std::vector<double> after = values(0);
  std::vector<std::string> names;
  for (std::size_t k = 0; k < m.spec().signals.size(); ++k) {
    const spec::Signal& signal = m.spec().signals[k];
    const int slot = m.signals.slot_of_signal[k];
    if (!signal.named || slot < 0 || (signal.block < 0 && !(signal.every > 0))) continue;
    if (signal.block >= 0 && m.spec().blocks[static_cast<std::size_t>(signal.block)].type == "noise")
      continue;
    const double from = before[static_cast<std::size_t>(slot)], to = after[static_cast<std::size_t>(slot)];
    if (std::abs(to - from) > still_signal * std::max(std::abs(from), std::abs(to)))
      names.push_back(signal.name);
  }
  s = rest;
  values(0);
  system.enter_rest(rest.u.data(), rest.z.data());
  return names;
}

}  // namespace mimbre
