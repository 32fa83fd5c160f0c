#pragma once
#include <array>
#include <string>
#include <vector>

#include "math/recorded.h"

/// What is recorded of a model: phases of a step as operations on numbers in arrays.
namespace mimbre::portable {

/// The arrays that phases read and write, by their names in the code.
enum class Memory {
  origin,  ///< the common point
  start,   ///< positions at the start of the step
  q,       ///< of an evaluation, as the next three
  v,
  a,
  multipliers,
  held,    ///< inputs and what signals remember
  states,  ///< of force elements
  time,
  holds,  ///< 1: what sticks as the step begins goes on sticking
  slot,   ///< signals, with two derivatives by time
  rate,
  second,
  by_measure,  ///< of the signal that an element follows, by its own measure and its rate
  by_rate,
  increment,  ///< of the positions
  correction,
  moved,     ///< positions that were moved by the increment
  composed,  ///< the increment with the correction
  residual,
  phi,  ///< equations, their rates, and the rates of these
  phi_dot,
  phi_ddot,
  matrix,      ///< in the places of the factorisation
  jacobian,    ///< of the equations, entry by entry
  subspace,    ///< of contacts: motion subspaces that the matrix was assembled with
  rows,        ///< of what elements measure
  mark,        ///< size of an element's tangent
  tangent,     ///< of the elements that have marks
  difference,  ///< of such a tangent
  assembled,   ///< the matrix before it was factorised
  next_states,
  next_held,
  output,
  sampled,  ///< what is made at an instant, then what a block keeps of it
  loads,    ///< of inertia that stiffen bodies: their part of the residual
  ahead,    ///< what blocks make that close loops of signals, before and after a round
  made,
  unsettled,  ///< in that round: of each of them whether it changes, and whether by more than round-off
  lost,
  delayed,      ///< of blocks that delay: their input of then
  delay_rate,   ///< and by which that changes with the time
  event_value,  ///< of events
  event_set,    ///< what they set inputs to
  event_count,  ///< of each event how often, and when it happened last
  event_time,
  algorithmic,
  flight,       ///< of what flies freely, at the start of a step: what it keeps
  flight_rate,  ///< of coordinates, by which the step changed its shape
  flight_gain,  ///< of energy of rotation, at one end
  flight_sum,   ///< at both
  flown,        ///< of its root, where it keeps that: positions, velocities, accelerations, algorithmic ones
  // Of model exchange alone.
  mass,            ///< entry by entry, the lower triangle
  increment_rate,  ///< of x
  state_rate,      ///< of what force elements and signals remember
  // How numbers vary along a direction: those that others vary with, and those that vary.
  d_q,
  d_v,
  d_a,
  d_multipliers,
  d_held,
  d_states,
  d_increment,
  d_slot,
  d_rate,
  d_second,
  d_phi,
  d_phi_dot,
  d_phi_ddot,
  d_residual,
  d_increment_rate,
  d_state_rate,
  d_output,
  d_time,
  count
};
inline constexpr std::size_t memories = static_cast<std::size_t>(Memory::count);
inline bool of_exchange(Memory memory) { return memory >= Memory::mass; }
/// As in the code.
const char* name_of(Memory memory);

struct Store {
  Memory to;
  int at;
  Recorded value;
  bool adds = false;
};

/// Operations that are made together. `after`: phases whose results are still there when it is made, those
/// that were made last.
struct Phase {
  std::string name;
  std::vector<Store> stores;
  std::vector<int> after;
};

struct Program {
  Recording recording;
  std::vector<Phase> phases;
  std::array<int, memories> sizes{};

  Recorded input(Memory memory, int at);
  std::vector<Recorded> inputs(Memory memory, int count);
  /// Begins a phase; its number.
  int begin(const std::string& name, const std::vector<int>& after);
  void store(Memory to, int at, const Recorded& value, bool adds = false);
};

/// C99 of all phases: functions `name_phase(name *s)` of bounded size, and how many numbers they keep in
/// s->kept. `tables`: the functions that they call.
struct PhaseCode {
  std::string text;
  int kept = 0;
  std::vector<long> operations;  ///< by phase
};
PhaseCode write_phases(const Program& program, const std::string& name);

/// `static double name(double x)`: the result as a function of the one input of a recording. What it calls is
/// named `name_call_…`, and comes before it.
std::string write_function(const Recording& recording, const Recorded& result, const std::string& name);

/// A number of C.
std::string literal(double x);

}  // namespace mimbre::portable
