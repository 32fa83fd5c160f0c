#include "mimbre/statics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "analysis/equilibria/moving_signals.h"
#include "analysis/equilibria/sample_at_rest.h"
#include "base/cpu_time.h"
#include "simulation/describe/explain.h"
#include "simulation/start/assembly.h"
#include "simulation/start/drawn_open.h"
#include "simulation/start/elastodynamics.h"

namespace mimbre {

StaticResult static_equilibrium(std::shared_ptr<const Model> model, const RunOptions& options) {
  const double start = thread_cpu_seconds();
  const Compiled& m = model->compiled();
  const Method method = resolve_method(m.spec().simulation, options);
  if (method.formulation == spec::Simulation::Formulation::natural) refuse_elastodynamics(m, method);
  relative::RelativeSystem system(m, method.inertia);
  const auto natural = make_natural(m, method);
  State s = assembled_state(m, system, options.inputs);
  StaticResult result;
  const auto warn = [&](const std::string& text) {
    if (!text.empty()) result.warnings.push_back(text);
  };
  warn(drawn_open(system, s));
  const StaticsStatus status = equilibrium(natural.get(), system, s);
  if (!status.converged) throw std::runtime_error(explain_imbalance(m, natural.get(), status));
  result.stable = !(status.growth > 0);
  warn(explain_instability(m, natural.get(), status));
  warn(explain_sampled_laws(m));
  const AtRest at_rest = sample_at_rest(m, system, s);
  for (const std::string& text : at_rest.warnings) warn(text);
  if (const auto moving = moving_signals(m, system, s); !moving.empty())
    warn(fmt::format(
        "{} '{}' would not stay: the equilibrium is that with what filters, controllers and sampled "
        "signals remember at the start, from which a run moves on",
        moving.size() > 1 ? "signals" : "signal", fmt::join(moving, "', '")));
  result.channels = at_rest.channels;
  result.values = at_rest.values;
  result.output_count = at_rest.output_count;
  result.iterations = status.iterations;
  result.residual = status.residual;
  result.sparse = status.sparse;
  result.load_steps = status.load_steps;
  result.cpu_seconds = thread_cpu_seconds() - start;
  return result;
}

}  // namespace mimbre
