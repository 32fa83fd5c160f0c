#include "mimbre/method_arguments.h"

#include <fmt/format.h>

#include "mimbre/run_option.h"
#include "mimbre/usage_error.h"

namespace mimbre {

RunOptions run_options(const RunOptions& asked, const spec::Simulation& given) {
  if (const auto conflict = find_conflict(given, asked, OptionNames::command_line))
    throw UsageError(conflict->message);
  return asked;
}

RunPlan planned(const spec::Simulation& given, const RunOptions& options) {
  const Method method = resolve_method(given, options);
  if ((options.step || options.end) && longer_than_run(method.step, method.end))
    throw UsageError(
        fmt::format("the step of {} s is longer than the run, which ends at {} s; give a shorter "
                    "--step or a later --until",
                    method.step, method.end));
  return plan_run(method.end, method.output_interval, method.step);
}

}  // namespace mimbre
