#include "portable/program.h"

namespace mimbre::portable {

const char* name_of(Memory memory) {
  static constexpr std::array names{"origin",
                                    "state.q",
                                    "q",
                                    "v",
                                    "a",
                                    "multipliers",
                                    "state.u",
                                    "state.z",
                                    "now",
                                    "holds",
                                    "slot",
                                    "rate",
                                    "second",
                                    "by_measure",
                                    "by_rate",
                                    "x",
                                    "r",
                                    "moved",
                                    "composed",
                                    "r",
                                    "phi",
                                    "phi_dot",
                                    "phi_ddot",
                                    "matrix",
                                    "jacobian",
                                    "subspace",
                                    "rows",
                                    "mark",
                                    "tangent",
                                    "difference",
                                    "assembled",
                                    "next_z",
                                    "next_u",
                                    "output",
                                    "sampled",
                                    "loads",
                                    "ahead",
                                    "made",
                                    "unsettled",
                                    "lost",
                                    "delayed",
                                    "delay_rate",
                                    "event_value",
                                    "event_set",
                                    "state.happened",
                                    "state.when",
                                    "algorithmic",
                                    "flight",
                                    "flight_rate",
                                    "flight_gain",
                                    "flight_sum",
                                    "flown",
                                    "mass",
                                    "x_rate",
                                    "w_rate",
                                    "d_q",
                                    "d_v",
                                    "d_a",
                                    "d_multipliers",
                                    "d_u",
                                    "d_z",
                                    "d_x",
                                    "d_slot",
                                    "d_rate",
                                    "d_second",
                                    "d_phi",
                                    "d_phi_dot",
                                    "d_phi_ddot",
                                    "d_r",
                                    "d_x_rate",
                                    "d_w_rate",
                                    "d_output",
                                    "d_now"};
  static_assert(names.size() == memories);
  return names[static_cast<std::size_t>(memory)];
}

Recorded Program::input(Memory memory, int at) {
  int& size = sizes[static_cast<std::size_t>(memory)];
  size = std::max(size, at + 1);
  return Recorded::input(static_cast<int>(memory), at);
}

std::vector<Recorded> Program::inputs(Memory memory, int count) {
  std::vector<Recorded> all;
  for (int k = 0; k < count; ++k) all.push_back(input(memory, k));
  return all;
}

int Program::begin(const std::string& name, const std::vector<int>& after) {
  phases.push_back({name, {}, after});
  return static_cast<int>(phases.size()) - 1;
}

void Program::store(Memory to, int at, const Recorded& value, bool adds) {
  int& size = sizes[static_cast<std::size_t>(to)];
  size = std::max(size, at + 1);
  phases.back().stores.push_back({to, at, value, adds});
}

}  // namespace mimbre::portable
