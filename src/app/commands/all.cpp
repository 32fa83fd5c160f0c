#include "app/common.h"

namespace mimbre::app {

std::vector<Command> add_commands(CommandLine& program) {
  return {add_run(program),        add_live(program),
          add_plan(program),       add_check(program),
          add_static(program),     add_modes(program),
          add_linearise(program),  add_trim(program),
          add_kinematics(program), add_inverse_dynamics(program),
          add_report(program),     add_compare(program),
          add_bench(program),      add_verify(program),
          add_reduce(program),     add_select(program),
          add_terms(program),      add_convert(program),
          add_stress(program),     add_export(program),
          add_generate(program),   add_fmu(program),
          add_page(program),       add_reproduce(program)};
}

}  // namespace mimbre::app
