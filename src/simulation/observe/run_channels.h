#pragma once
#include <span>
#include <vector>

#include "compile/compiled.h"
#include "mimbre/channels.h"
#include "mimbre/simulation.h"
#include "simulation/step/energy.h"

/// The standard channels of inputs, signals and events, of energies and of the solver.
namespace mimbre {

struct RunStatistics {
  double iterations = 0;
  Violations violations;
  std::span<const EventRecord> events = {};
};

void add_input_info(const spec::Input& input, std::vector<ChannelInfo>& info);
/// None of a signal without a name.
void add_signal_info(const spec::Signal& signal, std::vector<ChannelInfo>& info);

void add_event_info(const spec::Event& event, std::vector<ChannelInfo>& info);
void read_event(const EventRecord& event, double* to);

void add_energy_info(std::vector<ChannelInfo>& info);
void read_energy(const EnergyBalance& energy, double* to);

void add_solver_info(std::vector<ChannelInfo>& info);
void read_solver(const RunStatistics& statistics, double* to);

}  // namespace mimbre
