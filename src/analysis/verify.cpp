#include "mimbre/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <unordered_map>

#include "compile/compiled.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method_names.h"

namespace mimbre {
namespace {

using Formulation = spec::Simulation::Formulation;
constexpr double most_lost = 0.1, least_loss_fall = 1.5;
constexpr std::array formulations{Formulation::relative, Formulation::natural};

struct Recorded {
  VerificationRun run;
  Series series;
  bool interrupted = false;
};

/// The steps of a run, sampled at `rows`.
Recorded record(const std::shared_ptr<const Model>& model, const RunOptions& method, const RunPlan& plan,
                const std::vector<std::int64_t>& rows, const VerifyOptions& options) {
  Recorded out;
  VerificationRun& run = out.run;
  run.step = *method.step;
  run.energy_drift = std::numeric_limits<double>::quiet_NaN();
  try {
    Simulation simulation(model, method);
    run.coordinates = simulation.coordinates();
    run.constraints = simulation.constraints();
    out.series.step = *method.step;
    out.series.length = model->compiled().length_scale;
    out.series.info = simulation.channels();
    ResultsRow row;
    const auto sample = [&] {
      simulation.sample(row);
      out.series.time.push_back(row.time);
      out.series.channels.push_back(row.channels);
    };
    sample();
    for (const std::int64_t until : rows) {
      StepReport report;
      do  // Where an event would stop the run, both go on.
        report = advance(simulation, plan, until, run.totals, options.stop);
      while (report.ok() && simulation.stopped() && run.totals.steps < until);
      if (!report.ok()) {
        run.failure = simulation.explain(report);
        break;
      }
      if (options.stop && options.stop()) {
        out.interrupted = true;
        return out;
      }
      sample();
      if (options.progress) options.progress(simulation.time(), plan.end, run.totals.cpu_seconds);
    }
    run.energy_drift = simulation.energy().numerical;
    run.warnings = simulation.warnings();
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

/// A pair of runs and what was recorded of them.
struct Pair {
  VerificationPair runs;
  std::array<Series, 2> series;
};

/// The instants of a plan's rows, counted in steps of `parts` times shorter length that end at `steps`.
std::vector<std::int64_t> rows_of(const RunPlan& plan, std::int64_t parts, std::int64_t steps) {
  std::vector<std::int64_t> rows;
  for (std::int64_t k = 0; k < plan.steps;) {
    k = plan.next_row(k);
    rows.push_back(k < plan.steps ? parts * k : steps);
  }
  return rows;
}

/// The runs at the step and at parts of it, and how far they lie apart.
class Study {
 public:
  Study(std::shared_ptr<const Model> model, const RunOptions& method, const RunPlan& plan,
        const VerifyOptions& options)
      : model_(std::move(model)), method_(method), plan_(plan), options_(options) {}

  /// Whole, half and quarter of the step as far as they are needed. False when it was interrupted.
  bool make() {
    if (!make_pair(whole_, 1)) return false;
    if (!whole_.runs.ok()) return true;
    comparison_.whole = differences(whole_.series[0], whole_.series[1]);
    if (options_.refine && plan_.steps > 0) {
      if (!make_pair(half_.emplace(), 2)) return false;
      if (half_->runs.ok()) compare(whole_, *half_, comparison_.half, comparison_.step);
      agreement_ = agreement(comparison_);
      if (half_->runs.ok() && agreement_.undecided()) {
        if (!make_pair(quarter_.emplace(), 4)) return false;
        if (quarter_->runs.ok()) compare(*half_, *quarter_, comparison_.quarter, comparison_.half_step);
      }
    }
    agreement_ = agreement(comparison_);
    return true;
  }

  bool ok() const {
    return whole_.runs.ok() && (!half_ || half_->runs.ok()) && (!quarter_ || quarter_->runs.ok());
  }
  bool agree() const { return ok() && agreement_.agree; }

  std::int64_t repeated_steps() const {
    std::int64_t sum = 0;
    for (const Pair* pair : {&whole_, half_ ? &*half_ : nullptr, quarter_ ? &*quarter_ : nullptr})
      if (pair)
        for (const VerificationRun& run : pair->runs.runs) sum += run.totals.repeated_steps;
    return sum;
  }

  void report_to(Verification& v) {
    v.whole = std::move(whole_.runs);
    v.half = half_ ? std::optional(std::move(half_->runs)) : std::nullopt;
    v.quarter = quarter_ ? std::optional(std::move(quarter_->runs)) : std::nullopt;
    v.agreement = std::move(agreement_);
    for (const Apart& d : comparison_.whole)
      if (d.name.starts_with("energy.")) v.energy_at_play = std::max(v.energy_at_play, d.scale);
  }

 private:
  /// Runs in both formulations with the step in `parts`.
  bool make_pair(Pair& pair, std::int64_t parts) {
    RunOptions method = method_;
    method.step = plan_.step / static_cast<double>(parts);
    const RunPlan plan = plan_run(plan_.end, 0, *method.step);
    const std::vector<std::int64_t> rows = rows_of(plan_, parts, plan.steps);
    for (std::size_t f = 0; f < formulations.size(); ++f) {
      method.formulation = formulations[f];
      Recorded recorded = record(model_, method, plan, rows, options_);
      pair.runs.runs[f] = std::move(recorded.run);
      pair.series[f] = std::move(recorded.series);
      if (recorded.interrupted) return false;
    }
    return true;
  }

  /// The formulations at the shorter step, and each against itself at the longer one.
  static void compare(const Pair& longer, const Pair& shorter, std::vector<Apart>& formulations_apart,
                      std::array<std::vector<Apart>, 2>& steps_apart) {
    formulations_apart = differences(shorter.series[0], shorter.series[1]);
    // In the order and of the channels that both formulations have.
    for (std::size_t f = 0; f < steps_apart.size(); ++f) {
      std::unordered_map<std::string, Apart> by_name;
      for (Apart& d : differences(longer.series[f], shorter.series[f])) by_name[d.name] = d;
      for (const Apart& d : formulations_apart) steps_apart[f].push_back(by_name.at(d.name));
    }
  }

  std::shared_ptr<const Model> model_;
  RunOptions method_;
  RunPlan plan_;
  const VerifyOptions& options_;
  Pair whole_;
  std::optional<Pair> half_, quarter_;
  Comparison comparison_;
  Agreement agreement_;
};

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
  if (quarter) add(*quarter);
  return lines;
}

std::vector<std::string> Verification::warnings() const {
  std::vector<std::string> lines;
  for (std::size_t f = 0; f < whole.runs.size(); ++f)
    for (const std::string& warning : whole.runs[f].warnings)
      lines.push_back(fmt::format("in {} coordinates: {}", method_names::formulations[f], warning));
  return lines;
}

bool Verification::energy_lost() const {
  if (!half || !half->ok()) return false;
  for (std::size_t f = 0; f < half->runs.size(); ++f) {
    const double drift = std::abs(whole.runs[f].energy_drift), left = std::abs(half->runs[f].energy_drift);
    if (left > most_lost * energy_at_play && drift < least_loss_fall * left) return true;
  }
  return false;
}

std::string verdict(const Verification& v) {
  if (!v.compared()) return {};
  if (!v.ran()) return "No step was made: there is nothing to compare.";
  std::string text;
  // What half or a quarter of the step failed in is reported with the failures.
  if (v.agreement.agree && !v.failures().empty())
    text = "The formulations agree at the step, but not all of the shorter steps went through.";
  else if (v.agreement.agree && v.energy_lost())
    text = fmt::format(
        "The formulations agree, but the numerics changed the energy by {:.3g} J, of {:.3g} J at play, and "
        "by almost as much with half the step: a vibration is too fast for these steps.",
        v.half->runs[0].energy_drift, v.energy_at_play);
  else
    text = verdict(v.agreement);
  if (v.without_repeats)
    text += fmt::format(
        "\nSteps that were repeated in parts ({} in all runs) made them differ, so that all runs were made "
        "again without repeats, to compare like with like.",
        v.repeated_steps);
  else if (v.repeated_steps > 0)
    text += fmt::format("\n{} steps of all runs were repeated in parts.", v.repeated_steps);
  return text;
}

Verification verify(std::shared_ptr<const Model> model, const VerifyOptions& options) {
  const spec::Simulation& given = model->spec().simulation;
  RunOptions method = options.run;
  Verification v;
  for (const spec::Body& body : model->spec().bodies)
    if (body.elastodynamic)
      throw InputError(body.mark,
                       fmt::format("body '{}' bends by elastodynamics, which natural coordinates do "
                                   "not have: there is nothing to compare with",
                                   body.name));
  v.method = resolve_method(given, method);
  method.step = v.method.step;
  const RunPlan plan =
      plan_run(options.end >= 0 ? options.end : given.end, given.output_interval, v.method.step);
  v.end = plan.end;
  Study study(model, method, plan, options);
  if (v.interrupted = !study.make(); v.interrupted) return v;
  v.repeated_steps = study.repeated_steps();
  if (!study.agree() && v.repeated_steps > 0) {
    method.substeps = 1;
    Study plain(model, method, plan, options);
    if (v.interrupted = !plain.make(); v.interrupted) return v;
    v.without_repeats = plain.ok();
    if (v.without_repeats) {
      plain.report_to(v);
      return v;
    }
  }
  study.report_to(v);
  return v;
}

}  // namespace mimbre
