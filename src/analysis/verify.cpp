#include "mimbre/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <new>

#include "mimbre/method_names.h"

namespace mimbre {
namespace {

using Formulation = spec::Simulation::Formulation;
constexpr std::array formulations{Formulation::relative, Formulation::natural};

struct Recorded {
  VerificationRun run;
  Series series;
  bool interrupted = false;
};

/// Steps of options.run.step, sampled at every `stride`th.
Recorded record(const std::shared_ptr<const Model>& model, const RunOptions& method, const RunPlan& plan,
                const VerifyOptions& options) {
  Recorded out;
  VerificationRun& run = out.run;
  run.step = method.step;
  run.energy_drift = std::numeric_limits<double>::quiet_NaN();
  try {
    Simulation simulation(model, method);
    run.coordinates = simulation.coordinates();
    run.constraints = simulation.constraints();
    out.series.info = simulation.channels();
    ResultsRow row;
    const auto sample = [&] {
      simulation.sample(row);
      out.series.time.push_back(row.time);
      out.series.channels.push_back(row.channels);
    };
    sample();
    const double end = static_cast<double>(plan.steps) * method.step;
    while (run.totals.steps < plan.steps) {
      const std::int64_t left = plan.steps - run.totals.steps;
      const StepReport report = advance(simulation, std::min(plan.stride, left), run.totals, options.stop);
      if (!report.ok()) {
        run.failure = simulation.explain(report);
        break;
      }
      if (options.stop && options.stop()) {
        out.interrupted = true;
        return out;
      }
      sample();
      if (options.progress) options.progress(simulation.time(), end, run.totals.cpu_seconds);
    }
    run.energy_drift = simulation.energy().numerical;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const InputError& error) {
    // What the default formulation cannot start is a bad model.
    if (method.formulation == Formulation::relative) throw;
    run.failure = error.what();
  } catch (const std::exception& error) {
    run.failure = error.what();
  }
  return out;
}

/// Runs in both formulations; how far their channels lie apart, where both came to their end.
std::vector<Apart> make_pair(const std::shared_ptr<const Model>& model, RunOptions method,
                             const RunPlan& plan, const VerifyOptions& options, VerificationPair& pair,
                             bool& interrupted) {
  std::array<Series, 2> series;
  for (std::size_t f = 0; f < formulations.size(); ++f) {
    method.formulation = formulations[f];
    Recorded recorded = record(model, method, plan, options);
    pair.runs[f] = std::move(recorded.run);
    series[f] = std::move(recorded.series);
    interrupted = interrupted || recorded.interrupted;
    if (interrupted) return {};
  }
  return pair.ok() ? differences(series[0], series[1]) : std::vector<Apart>{};
}

}  // namespace

std::vector<std::string> Verification::failures() const {
  std::vector<std::string> lines;
  const auto add = [&](const VerificationPair& pair) {
    for (std::size_t f = 0; f < pair.runs.size(); ++f)
      if (!pair.runs[f].ok())
        lines.push_back(fmt::format("the {} formulation failed with the step {:.6g} s: {}",
                                    method_names::formulations[f], pair.runs[f].step, pair.runs[f].failure));
  };
  add(whole);
  if (half) add(*half);
  return lines;
}

Verification verify(std::shared_ptr<const Model> model, const VerifyOptions& options) {
  const spec::Simulation& given = model->spec().simulation;
  RunOptions method = options.run;
  Verification v;
  v.method = resolve_method(given, method);
  method.step = v.method.step;
  const RunPlan plan =
      plan_run(options.end >= 0 ? options.end : given.end, given.output_interval, method.step);
  v.end = static_cast<double>(plan.steps) * method.step;
  const std::vector<Apart> whole = make_pair(model, method, plan, options, v.whole, v.interrupted);
  std::vector<Apart> half;
  if (v.compared() && options.refine && !v.interrupted) {
    method.step /= 2;
    half =
        make_pair(model, method, {2 * plan.steps, 2 * plan.stride}, options, v.half.emplace(), v.interrupted);
  }
  v.agreement = agreement(whole, half);
  return v;
}

}  // namespace mimbre
