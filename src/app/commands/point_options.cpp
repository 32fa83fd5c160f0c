#include "app/commands/point_options.h"

#include <fmt/format.h>

#include "app/common.h"
#include "app/method_options.h"
#include "app/start_inputs.h"

namespace mimbre::app {
void add_point_options(Parser& parser, PointArguments& a) {
  parser
      .add_option(
          "--at", a.at,
          "Point: equilibrium, steady (constant velocities), start, or a time in s of a run; by default the "
          "equilibrium where there is one, else steady motion, else the start")
      .type_name("POINT");
  add_start_inputs_option(parser, a.inputs);
  parser.add_option("--delay-order", a.delay_order, "Order of the rational functions that replace delays")
      .within(1, 8)
      .show_default()
      .type_name("N");
  add_method_options(parser, a.method);
}

LinearOptions linear_options(const PointArguments& a, const spec::Simulation& given) {
  LinearOptions options;
  options.run = run_options(a.method, given);
  options.delay_order = a.delay_order;
  using At = LinearPoint::At;
  if (a.at == "automatic")
    options.point.at = At::automatic;
  else if (a.at == "equilibrium")
    options.point.at = At::equilibrium;
  else if (a.at == "steady")
    options.point.at = At::steady;
  else if (a.at == "start")
    options.point.at = At::start;
  else {
    options.point.at = At::time;
    options.point.time =
        number_of(a.at, fmt::format("--at {}: equilibrium, steady, start or a time in s is needed", a.at));
    if (options.point.time < 0) throw UsageError(fmt::format("--at {}: the time is negative", a.at));
  }
  for (const auto& [name, value] : start_inputs(a.inputs)) options.run.inputs[name] = value;
  return options;
}

}  // namespace mimbre::app
