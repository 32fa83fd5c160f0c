#include "app/commands/point_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "app/common.h"
#include "app/method_options.h"

namespace mimbre::app {
namespace {

double number_of(const std::string& text, const std::string& what) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError(what);
  return value;
}

}  // namespace

void add_point_options(Parser& parser, PointArguments& a) {
  parser
      .add_option(
          "--at", a.at,
          "Point: equilibrium, steady (constant velocities), start, or a time in s of a run; by default the "
          "equilibrium where there is one, else steady motion, else the start")
      .type_name("POINT");
  parser.add_option("--input", a.inputs, "Start value of an input or tunable parameter; several times")
      .repeated()
      .type_name("NAME=VALUE");
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
  for (const std::string& text : a.inputs) {
    const auto place = text.find('=');
    if (place == std::string::npos || place == 0)
      throw UsageError(fmt::format("--input {}: NAME=VALUE is needed", text));
    options.run.inputs[text.substr(0, place)] =
        number_of(text.substr(place + 1), fmt::format("--input {}: the value is no finite number", text));
  }
  return options;
}

}  // namespace mimbre::app
