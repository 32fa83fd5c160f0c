#include "mimbre/inertia_study.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "base/cpu_time.h"
#include "dynamics/relative/system.h"
#include "integrate/stepper.h"
#include "mimbre/model.h"
#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "simulation/step/free_flight.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinite = std::numeric_limits<double>::infinity();
// Instants at most at which terms are estimated.
constexpr int most_instants = 100;
// Errors are by a channel's range, or by this share of the largest range of its unit.
constexpr double least_range = 1e-3;
// Times of a step are the least of so many runs, made in turn.
constexpr int timed_runs = 5;

/// What one run leaves: the compared channels at the instants of output, and states.
struct History {
  std::vector<VectorXd> rows;
  std::vector<Simulation::Snapshot> states;
};

/// A term of one body.
struct Place {
  std::size_t body;
  int term;
  double estimate;
};

class Study {
 public:
  Study(const spec::Model& model, const InertiaStudyOptions& options) : model_(model), options_(options) {
    const Method method = resolve_method(model.simulation, options.run);
    if (method.inertia != spec::Simulation::Inertia::integrals)
      throw std::invalid_argument(
          "the model's inertia comes from the mesh's mass matrix, which has no terms to leave out; take "
          "inertia: integrals");
    natural_ = method.formulation == spec::Simulation::Formulation::natural;
    for (std::size_t k = 0; k < model.bodies.size(); ++k)
      if (model.bodies[k].flexible && model.bodies[k].flexible->modes > 0 && !model.bodies[k].elastodynamic)
        out_.bodies.push_back({model.bodies[k].name, static_cast<int>(k), {}, {}});
    if (out_.bodies.empty())
      throw std::invalid_argument(
          "the model has no flexible body in a floating frame, whose inertia has these terms");
    for (spec::Body& body : model_.bodies) body.neglected = {};
  }

  InertiaStudy make() {
    tell("run with all terms", 0);
    const auto full = Model::compile(model_);
    choose_outputs(full);
    all_ = run(full, options_.run, !natural_);
    if (natural_) {  // the estimates go by relative coordinates
      RunOptions relative = options_.run;
      relative.formulation = spec::Simulation::Formulation::relative;
      all_.states = run(full, relative, true).states;
    }
    find_ranges(full);
    estimate(*full);
    name_flying(full->compiled());
    for (int k = 0; k < inertia_term_count; ++k) judge_alone(k);
    choose();
    if (options_.measure) measure();
    return std::move(out_);
  }

 private:
  void tell(const std::string& stage, double done) const {
    if (options_.progress) options_.progress(stage, done);
  }

  void choose_outputs(const std::shared_ptr<const Model>& full) {
    const Simulation simulation(full, options_.run);
    const auto& channels = simulation.channels();
    const auto add = [&](int k) {
      channels_.push_back(k);
      out_.outputs.push_back(channels[static_cast<std::size_t>(k)].name);
    };
    for (const std::string& name : options_.outputs) add(simulation.channel(name).index);
    if (options_.outputs.empty())
      for (int k = 0; k < simulation.output_count(); ++k) add(k);
    if (!channels_.empty()) return;
    for (std::size_t k = 0; k < channels.size(); ++k)
      if (channels[k].name.starts_with("joint.") && (channels[k].unit == "m" || channels[k].unit == "rad"))
        add(static_cast<int>(k));
  }

  /// Where a term is neglected steps do not correct the momentum of what flies freely (FreeFlight).
  void name_flying(const Compiled& full) {
    for (const FreeGroup& group : free_groups(full))
      for (const InertiaStudy::Body& body : out_.bodies)
        if (std::any_of(group.bodies.begin(), group.bodies.end(),
                        [&](int k) { return full.bodies[static_cast<std::size_t>(k)].spec == body.index; }))
          out_.notes.push_back(fmt::format(
              "body '{}' flies freely: steps restore its momentum, but not where any of its terms is "
              "neglected. The drift that is left is part of the errors here; it falls with the square of the "
              "step",
              body.name));
  }

  History run(const std::shared_ptr<const Model>& model, const RunOptions& options, bool with_states) {
    ++out_.runs;
    Simulation simulation(model, options);
    const double end = options_.end > 0 ? options_.end : model_.simulation.end, h = simulation.step_size();
    const auto steps = std::max<Index>(1, static_cast<Index>(std::round(end / h)));
    const auto stride =
        std::max<Index>(1, static_cast<Index>(std::round(model_.simulation.output_interval / h)));
    const Index between = std::max<Index>(1, steps / most_instants);
    History history;
    ResultsRow row;
    for (Index k = 0; k <= steps; ++k) {
      if (k > 0) {
        const StepReport report = simulation.step();
        if (!report.ok()) throw std::runtime_error(simulation.explain(report));
      }
      if (with_states && k % between == 0) history.states.push_back(simulation.save());
      if (k % stride == 0) {
        if (options_.attend) options_.attend();
        simulation.sample(row);
        history.rows.push_back(row.channels(channels_));
      }
      if (simulation.stopped()) break;
    }
    return history;
  }

  void find_ranges(const std::shared_ptr<const Model>& full) {
    const auto n = static_cast<Index>(channels_.size());
    VectorXd least = VectorXd::Constant(n, infinite), most = -least;
    for (const VectorXd& row : all_.rows) {
      least = least.cwiseMin(row);
      most = most.cwiseMax(row);
    }
    const VectorXd range = most - least;
    ranges_ = range;
    const auto channels = Simulation(full, options_.run).channels();
    const auto unit = [&](Index k) {
      return channels[static_cast<std::size_t>(channels_[static_cast<std::size_t>(k)])].unit;
    };
    for (Index k = 0; k < n; ++k)
      for (Index j = 0; j < n; ++j)
        if (unit(j) == unit(k)) ranges_[k] = std::max(ranges_[k], least_range * range[j]);
    if (n == 0 || !(ranges_.maxCoeff() > 0))
      throw std::invalid_argument("no output moves in the run, so that there is no error to measure");
  }

  spec::Model without(const std::vector<InertiaTerms>& neglected) const {
    spec::Model changed = model_;
    for (std::size_t k = 0; k < out_.bodies.size(); ++k)
      changed.bodies[static_cast<std::size_t>(out_.bodies[k].index)].neglected = neglected[k];
    return changed;
  }
  std::vector<InertiaTerms> of_all(InertiaTerms terms) const {
    return std::vector<InertiaTerms>(out_.bodies.size(), terms);
  }
  std::vector<InertiaTerms> chosen() const {
    std::vector<InertiaTerms> all;
    for (const InertiaStudy::Body& body : out_.bodies) all.push_back(body.neglected);
    return all;
  }

  /// The largest error of an output, infinite where the run fails; `worst`: which, if asked for.
  double error_without(const std::vector<InertiaTerms>& neglected, std::string* worst = nullptr) {
    try {
      const History history = run(Model::compile(without(neglected)), options_.run, false);
      if (history.rows.size() != all_.rows.size()) return infinite;  // an event has ended it elsewhere
      double largest = 0;
      for (std::size_t i = 0; i < history.rows.size(); ++i)
        for (Index k = 0; k < ranges_.size(); ++k) {
          const double off = std::abs(history.rows[i][k] - all_.rows[i][k]);
          if (off == 0 || (std::isnan(history.rows[i][k]) && std::isnan(all_.rows[i][k]))) continue;
          const double error = off / ranges_[k];
          if (error <= largest) continue;
          largest = error;
          if (worst) *worst = out_.outputs[static_cast<std::size_t>(k)];
          if (!std::isfinite(error)) return infinite;
        }
      return largest;
    } catch (const std::runtime_error&) {
      return infinite;
    }
  }

  /// Shares of the terms in what inertia does in a step, largest of the instants.
  void estimate(const Model& full) {
    relative::RelativeSystem system(full.compiled());
    const double h = resolve_method(model_.simulation, options_.run).step, h2 = h * h / 4;
    std::vector<MatrixXd> forces, inertia;  // by instant: of every term of every body; with accelerations
    const std::size_t places = out_.bodies.size() * inertia_term_count;
    for (std::size_t i = 0; i < all_.states.size(); ++i)
      forces.emplace_back(full.compiled().velocities, static_cast<Index>(places));
    std::vector<VectorXd> complete;
    const auto residual = [](relative::RelativeSystem& of, const Simulation::Snapshot& s, const VectorXd& a) {
      VectorXd r(s.v.size());
      of.begin_step(s.q.data());
      of.enter(s.u.data(), s.z.data(), 0);
      of.residual(s.time, s.q.data(), s.v.data(), a.data(), s.multipliers.data(), 0, r.data());
      return r;
    };
    for (const Simulation::Snapshot& s : all_.states) complete.push_back(residual(system, s, s.a));
    for (std::size_t body = 0; body < out_.bodies.size(); ++body)
      for (int term = 0; term < inertia_term_count; ++term) {
        std::vector<InertiaTerms> one = of_all({});
        one[body].add(static_cast<InertiaTerm>(term));
        const auto model = Model::compile(without(one));
        relative::RelativeSystem other(model->compiled());
        for (std::size_t i = 0; i < all_.states.size(); ++i)
          forces[i].col(static_cast<Index>(body) * inertia_term_count + term) =
              residual(other, all_.states[i], all_.states[i].a) - complete[i];
      }
    double whole = 0;
    VectorXd largest = VectorXd::Zero(static_cast<Index>(places));
    for (std::size_t i = 0; i < all_.states.size(); ++i) {
      const Simulation::Snapshot& s = all_.states[i];
      VectorXd x = residual(system, s, s.a) - residual(system, s, VectorXd::Zero(s.a.size()));
      residual(system, s, s.a);
      if (!system.factor(s.q.data(), {h / 2, h2, IntegratorOptions().penalty}).ok()) continue;
      system.solve(x.data());
      whole = std::max(whole, system.scales().of_coordinates(x.data()));
      for (Index k = 0; k < largest.size(); ++k) {
        x = forces[i].col(k);
        system.solve(x.data());
        largest[k] = std::max(largest[k], system.scales().of_coordinates(x.data()));
      }
    }
    for (std::size_t body = 0; body < out_.bodies.size(); ++body)
      for (int term = 0; term < inertia_term_count; ++term)
        out_.bodies[body].estimates[static_cast<std::size_t>(term)] =
            whole > 0 ? largest[static_cast<Index>(body) * inertia_term_count + term] / whole : 0;
  }

  void judge_alone(int term) {
    const InertiaTermInfo& info = inertia_terms[static_cast<std::size_t>(term)];
    tell(fmt::format("run without {}", info.name), static_cast<double>(term) / inertia_term_count);
    InertiaStudy::Term t;
    t.term = static_cast<InertiaTerm>(term);
    for (const InertiaStudy::Body& body : out_.bodies)
      t.estimate = std::max(t.estimate, body.estimates[static_cast<std::size_t>(term)]);
    InertiaTerms terms;
    terms.add(t.term);
    t.error = error_without(of_all(terms));
    out_.terms.push_back(t);
  }

  /// In the order of the estimates, as many as the error permits.
  void choose() {
    std::vector<Place> order;
    for (std::size_t body = 0; body < out_.bodies.size(); ++body)
      for (int term = 0; term < inertia_term_count; ++term)
        order.push_back({body, term, out_.bodies[body].estimates[static_cast<std::size_t>(term)]});
    std::stable_sort(order.begin(), order.end(),
                     [](const Place& a, const Place& b) { return a.estimate < b.estimate; });
    const auto first = [&](std::size_t count) {
      std::vector<InertiaTerms> terms = of_all({});
      for (std::size_t k = 0; k < count; ++k)
        terms[order[k].body].add(static_cast<InertiaTerm>(order[k].term));
      return terms;
    };
    std::size_t good = 0, bad = order.size() + 1;
    while (bad - good > 1) {
      const std::size_t count = good == 0 && bad > order.size() ? order.size() : (good + bad) / 2;
      tell(fmt::format("run without {} of {} terms", count, order.size()),
           static_cast<double>(good) / static_cast<double>(order.size()));
      (error_without(first(count)) <= options_.error ? good : bad) = count;
    }
    keep(first(good));
    // An estimate may be too large: what is left, term by term.
    for (const InertiaStudy::Term& t : out_.terms) {
      if (!(t.error <= options_.error)) continue;
      std::vector<InertiaTerms> more = chosen();
      for (InertiaTerms& terms : more) terms.add(t.term);
      if (more == chosen()) continue;
      tell(fmt::format("run without {}, too", inertia_terms[static_cast<std::size_t>(t.term)].name), 1);
      if (error_without(more) <= options_.error) keep(more);
    }
    out_.error = error_without(chosen(), &out_.worst);
  }
  void keep(const std::vector<InertiaTerms>& terms) {
    for (std::size_t k = 0; k < terms.size(); ++k) out_.bodies[k].neglected = terms[k].complete();
  }

  double seconds(const std::shared_ptr<const Model>& model) const {
    Simulation simulation(model, options_.run);
    const double end = options_.end > 0 ? options_.end : model_.simulation.end;
    const auto steps = static_cast<Index>(std::round(end / simulation.step_size()));
    const double start = thread_cpu_seconds();
    for (Index k = 0; k < steps && !simulation.stopped(); ++k)
      if (!simulation.step().ok()) break;
    if (options_.attend) options_.attend();
    return thread_cpu_seconds() - start;
  }

  /// CPU by that with all terms.
  void measure() {
    InertiaTerms all;
    std::vector<std::vector<InertiaTerms>> sets{of_all({}), chosen()};
    for (int term = 0; term < inertia_term_count; ++term) {
      InertiaTerms one;
      one.add(static_cast<InertiaTerm>(term));
      all.add(static_cast<InertiaTerm>(term));
      sets.push_back(of_all(one));
    }
    sets.push_back(of_all(all));
    std::vector<std::shared_ptr<const Model>> models;
    for (const auto& set : sets) models.push_back(Model::compile(without(set)));
    std::vector<double> least(sets.size(), infinite);
    for (int k = 0; k < timed_runs; ++k) {
      tell("times of runs", static_cast<double>(k) / timed_runs);
      for (std::size_t i = 0; i < sets.size(); ++i) {
        const bool runs = i < 2 || i + 1 == sets.size() || std::isfinite(out_.terms[i - 2].error);
        if (runs) least[i] = std::min(least[i], seconds(models[i]));
      }
    }
    out_.cost = least[1] / least[0];
    for (int term = 0; term < inertia_term_count; ++term)
      out_.terms[static_cast<std::size_t>(term)].cost = least[static_cast<std::size_t>(term) + 2] / least[0];
    out_.cost_without_any = least.back() / least[0];
  }

  spec::Model model_;
  InertiaStudyOptions options_;
  InertiaStudy out_;
  std::vector<int> channels_;
  VectorXd ranges_;
  History all_;
  bool natural_ = false;
};

}  // namespace

InertiaStudy study_inertia(const spec::Model& model, const InertiaStudyOptions& options) {
  return Study(model, options).make();
}

}  // namespace mimbre
