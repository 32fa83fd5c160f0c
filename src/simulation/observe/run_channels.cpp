#include "simulation/observe/run_channels.h"

#include <fmt/format.h>

namespace mimbre {

void add_input_info(const spec::Input& i, std::vector<ChannelInfo>& info) {
  info.push_back({fmt::format("input.{}", i.name), i.unit.empty() ? "1" : i.unit,
                  fmt::format("{} '{}'", i.tunable ? "parameter" : "input", i.name)});
}

void add_signal_info(const spec::Signal& s, std::vector<ChannelInfo>& info) {
  if (s.named)
    info.push_back({fmt::format("signal.{}", s.name), s.unit.empty() ? "1" : s.unit,
                    fmt::format("signal '{}'", s.name)});
}

void add_event_info(const spec::Event& event, std::vector<ChannelInfo>& info) {
  const std::string& name = event.name;
  info.push_back(
      {fmt::format("event.{}", name), "1", fmt::format("how often event '{}' has happened", name)});
  info.push_back({fmt::format("event.{}.time", name), "s",
                  fmt::format("when event '{}' last happened; -1: not yet", name)});
}

void read_event(const EventRecord& event, double* to) {
  to[0] = static_cast<double>(event.count);
  to[1] = event.count > 0 ? event.last : -1;
}

void add_energy_info(std::vector<ChannelInfo>& info) {
  for (const EnergyTerm& term : energy_terms)
    info.push_back({fmt::format("energy.{}", term.name), "J", term.meaning});
}

void read_energy(const EnergyBalance& e, double* to) {
  for (const EnergyTerm& term : energy_terms) *to++ = e.*term.value;
}

void add_solver_info(std::vector<ChannelInfo>& info) {
  info.push_back({"solver.iterations", "1", "iterations of the last step"});
  info.push_back({"solver.position_violation", "m", "largest violation of the constraints that are lengths"});
  info.push_back({"solver.angle_violation", "rad", "largest violation of the constraints that are angles"});
  info.push_back({"solver.velocity_violation", "m/s", "largest rate of the constraints that are lengths"});
  info.push_back(
      {"solver.angular_velocity_violation", "rad/s", "largest rate of the constraints that are angles"});
}

void read_solver(const RunStatistics& s, double* to) {
  to[0] = s.iterations;
  to[1] = s.violations.position_violation;
  to[2] = s.violations.angle_violation;
  to[3] = s.violations.velocity_violation;
  to[4] = s.violations.angular_velocity_violation;
}

}  // namespace mimbre
