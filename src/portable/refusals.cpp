#include "portable/refusals.h"

#include <fmt/format.h>

#include <cmath>

#include "compile/element_name.h"
#include "forces/surfaces/table.h"
#include "portable/continuous_rates.h"
#include "signals/blocks/table.h"

namespace mimbre::portable {
namespace {

class Refusals {
 public:
  explicit Refusals(const Compiled& m) : m_(m), file_{m.spec().file, 0, 0} {}

  /// Once, where several elements are one of the model.
  void add(const Mark& mark, const std::string& text) {
    if (all_.empty() || all_.back().message != text) all_.push_back({mark, text});
  }
  void add(const std::string& text) { add(file_, text); }
  std::vector<Diagnostic> all() { return std::move(all_); }

  void add_of_model(const Method& method) {
    if (method.formulation != spec::Simulation::Formulation::relative)
      add("code is made of relative coordinates only: formulation: relative");
    if (method.inertia != spec::Simulation::Inertia::integrals)
      add("code is made of inertia by shape integrals only: inertia: integrals");
    if (m_.velocities == 0) add("nothing in the model can move, so there is no code to make");
    if (m_.velocities > 0 && m_.symbolic.size() == 0)
      add("code is not made of a tree of so many bodies that it is eliminated body by body; run it with the "
          "library");
    add_of_bodies();
    add_of_elements();
    add_of_signals();
  }

  /// From one instant to the next code counts one interval, which is so where steps are short enough.
  void add_of_instants(double step) {
    const auto look = [&](const std::string& name, const Mark& mark, double every) {
      const double steps = every / step;
      if (every > 0 && steps < 2.01 && std::abs(steps - std::round(steps)) > 1e-6 * steps)
        add(mark,
            fmt::format(
                "signal '{}' is evaluated every {} s: that needs steps of that length or less than half "
                "of it, not of {} s",
                name, every, step));
    };
    for (const spec::Block& b : m_.spec().blocks) look(b.name, b.mark, b.every);
    for (const spec::Signal& s : m_.spec().signals)
      if (s.block < 0) look(s.name, s.mark, s.every);
  }

 private:
  void add_of_bodies() {
    for (const BodyData& b : m_.bodies) {
      if (b.modes == 0) continue;
      const spec::Body& body = m_.spec().bodies[static_cast<std::size_t>(b.spec)];
      if (b.elastodynamic)
        add(body.mark,
            fmt::format("body '{}' bends by linear elastodynamics, of which code is not made; take "
                        "flexibility: floating_frame, or an FMU with the library (mimbre fmu --library)",
                        body.name));
    }
    for (const FlexibleData& f : m_.flexible)
      if (f.absolute()) {
        add("code is not made of beams by absolute nodal coordinates; take modes");
        break;
      }
    for (const ConstraintData& c : m_.constraints)
      if (c.road >= 0) {
        const auto& of = m_.spec().constraints[static_cast<std::size_t>(c.spec)];
        add(of.mark, fmt::format("code is not made of wheels that roll on a road without slip, as by "
                                 "constraint '{}'; take an FMU with the library "
                                 "(mimbre fmu --library)",
                                 of.name));
      }
    for (const ConstraintData& c : m_.constraints)
      if (c.state_count > 0) {
        const auto& of = m_.spec().constraints[static_cast<std::size_t>(c.spec)];
        add(of.mark,
            fmt::format("constraint '{}' is on a curve, or counts turns, which code does not", of.name));
      }
  }

  void add_of_elements() {
    bool swarms = false;
    for (const ElementData& e : m_.elements) {
      swarms = swarms || e.pooled;
      if (e.user)
        add(
            fmt::format("{} has a law of your own, of which the library knows no formula: write it as an "
                        "expression of the model file",
                        element_name(m_, e)));
    }
    if (swarms) add("code is not made of swarms, whose pairs change from step to step");
  }

  void add_of_signals() {
    const SignalsData& d = m_.signals;
    if (d.fixed_loops)
      add("code is not made of signals that go around in loops by the time alone; write them as one formula");
    for (const spec::Block& b : m_.spec().blocks) {
      if (b.outside)
        add(b.mark,
            fmt::format("signal '{}' is computed by an FMU, whose code is not ours to write: leave it to "
                        "`mimbre run`, or write it as a block of the model file",
                        b.name));
    }
  }

  const Compiled& m_;
  const Mark file_;
  std::vector<Diagnostic> all_;
};

}  // namespace

std::vector<Diagnostic> refusals(const Compiled& m, const Method& method) {
  using Rule = spec::Simulation::Integrator;
  Refusals all(m);
  all.add_of_model(method);
  all.add_of_instants(method.step);
  if (method.formalism != spec::Simulation::Formalism::index3)
    all.add("code is made of the formalism index3 only: formalism: index3");
  if (method.integrator != Rule::generalized_alpha && method.integrator != Rule::hht &&
      method.integrator != Rule::newmark)
    all.add("code is made of the integrators generalized_alpha, hht and newmark only");
  return all.all();
}

std::vector<Diagnostic> exchange_refusals(const Compiled& m, const Method& method) {
  Refusals all(m);
  all.add_of_model(method);
  const char* const instead = "write an FMU for co-simulation";
  for (const spec::Event& e : m.spec().events)
    all.add(
        e.mark,
        fmt::format("event '{}' changes inputs or ends the run, which model exchange does not support; {}",
                    e.name, instead));
  for (const ElementData& e : m.elements) {
    if (e.user || e.pooled || e.leg) continue;
    if (e.measure == Measure::contact)
      all.add(fmt::format(
          "{} is a contact, which begins and ends within steps and has a place at which it sticks; {}",
          element_name(m, e), instead));
    else if (e.measure == Measure::wheel)
      all.add(fmt::format(
          "{} has a footprint that moves by a rule over steps; {}, or take a tyre of model vertical",
          element_name(m, e), instead));
    else if (!has_rates(e))
      all.add(
          fmt::format("{} has a state that changes by a rule over steps (sticking, an impact, the rate of a "
                      "signal), which is no differential equation; {}",
                      element_name(m, e), instead));
  }
  for (const BodyData& b : m.bodies)
    if (b.modes > 0 && m.flexible[static_cast<std::size_t>(b.flexible)].geometric.inertial > 0) {
      const spec::Body& body = m.spec().bodies[static_cast<std::size_t>(b.spec)];
      all.add(body.mark, fmt::format("body '{}' is stiffened by loads of inertia, so that its forces go by "
                                     "accelerations; {}, or take stiffening: linear",
                                     body.name, instead));
    }
  if (!m.signals.sampled.empty())
    all.add(fmt::format(
        "signals are evaluated at instants, which the solver of another program does not stop at; leave "
        "'every' away, or {}",
        instead));
  if (m.signals.moving_loops)
    all.add(fmt::format("signals go around in loops, which are settled step by step; {}", instead));
  for (const ConstraintData& c : m.constraints) {
    if (c.rates == 0) continue;
    const auto& of = m.spec().constraints[static_cast<std::size_t>(c.spec)];
    all.add(of.mark,
            fmt::format("constraint '{}' restricts velocities but not positions, like a rolling wheel, which "
                        "independent coordinates do not support yet; {}",
                        of.name, instead));
  }
  for (const spec::Block& b : m.spec().blocks)
    if (b.type == "rate_limit" || (b.type == "hysteresis" && !(b.every > 0)))
      all.add(b.mark, fmt::format("signal '{}' is a block {}, which switches between steps; {}", b.name,
                                  b.type, instead));
    else if (b.type == "delay")
      all.add(b.mark,
              fmt::format("signal '{}' is a delay, which is no differential equation; {}", b.name, instead));
  return all.all();
}

}  // namespace mimbre::portable
