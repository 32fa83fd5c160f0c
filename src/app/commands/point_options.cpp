#include "app/commands/point_options.h"

#include <fmt/format.h>

#include <optional>

#include "app/common.h"
#include "app/method_options.h"
#include "app/start_inputs.h"
#include "mimbre/trim.h"
#include "mimbre/usage_error.h"

namespace mimbre::app {

void add_trim_options(Parser& parser, PointArguments& a) {
  parser
      .add_option("--hold", a.hold,
                  "Steady driving: speed=M/S, and for a turn to the left lateral_acceleration=M/S2, "
                  "yaw_rate=RAD/S or "
                  "radius=M")
      .repeated()
      .type_name("NAME=VALUE");
  parser.add_option("--find", a.find, "An input whose value makes the motion steady; one for each --hold")
      .repeated()
      .type_name("INPUT");
  parser.add_option("--body", a.body, "Whose speed it is; default: the first body on a floating joint")
      .type_name("BODY");
}

bool drives_steadily(const PointArguments& a) {
  return !a.hold.empty() || !a.find.empty() || !a.body.empty();
}

TrimConditions trim_conditions(const PointArguments& a) {
  TrimConditions out;
  out.body = a.body;
  out.find = a.find;
  for (const std::string& text : a.hold) {
    const std::size_t sign = text.find('=');
    const std::string name = text.substr(0, sign);
    std::optional<double>* const condition = held_condition(out, name);
    if (sign == std::string::npos || !condition)
      throw UsageError(fmt::format(
          "--hold {}: speed, lateral_acceleration, yaw_rate or radius with a value is needed, as in speed=20",
          text));
    if (*condition) throw UsageError(fmt::format("--hold {}: {} is given twice", text, name));
    *condition = number_of(text.substr(sign + 1), fmt::format("--hold {}: a number is needed", text));
  }
  return out;
}

void add_point_options(Parser& parser, PointArguments& a) {
  parser
      .add_option(
          "--at", a.at,
          "Point: equilibrium, steady (constant velocities), start, or a time in s of a run; by default the "
          "equilibrium where there is one, else steady motion, else the start")
      .type_name("POINT");
  add_start_inputs_option(parser, a.inputs);
  add_trim_options(parser, a);
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
  if (drives_steadily(a)) {
    if (options.point.at != At::automatic && options.point.at != At::steady)
      throw UsageError("--hold, --find and --body: of steady driving, --at steady");
    options.point.at = At::trim;
    options.trim = trim_conditions(a);
  }
  for (const auto& [name, value] : start_inputs(a.inputs)) options.run.inputs[name] = value;
  return options;
}

}  // namespace mimbre::app
