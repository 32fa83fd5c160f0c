#include "portable/refusals.h"

#include <fmt/format.h>

#include "compile/element_name.h"
#include "dynamics/geometric.h"
#include "forces/surfaces/table.h"
#include "signals/blocks/table.h"
#include "simulation/step/free_flight.h"

namespace mimbre::portable {

std::vector<Diagnostic> refusals(const Compiled& m, const Method& method) {
  using Rule = spec::Simulation::Integrator;
  std::vector<Diagnostic> all;
  const Mark file{m.spec().file, 0, 0};
  const auto refuse = [&](const Mark& mark, const std::string& text) { all.push_back({mark, text}); };
  if (method.formulation != spec::Simulation::Formulation::relative)
    refuse(file, "code is made of relative coordinates only: formulation: relative");
  if (method.formalism != spec::Simulation::Formalism::index3)
    refuse(file, "code is made of the formalism index3 only: formalism: index3");
  if (method.inertia != spec::Simulation::Inertia::integrals)
    refuse(file, "code is made of inertia by shape integrals only: inertia: integrals");
  if (method.integrator == Rule::conserve || method.integrator == Rule::rk4 ||
      method.integrator == Rule::dopri853)
    refuse(file, "code is made of the integrators generalized-alpha, hht and newmark only");
  if (m.velocities == 0) refuse(file, "nothing in the model can move, so there is no code to make");
  if (m.velocities > 0 && m.symbolic.size() == 0)
    refuse(file,
           "code is not made of a tree of so many bodies that it is eliminated body by body; run it with the "
           "library");
  if (geometric::has_loads_of_inertia(m))
    refuse(file, "code is not made of bodies that loads of inertia stiffen: take stiffening: none");
  for (const FlexibleData& f : m.flexible)
    if (!f.ancf.empty()) {
      refuse(file, "code is not made of beams by absolute nodal coordinates; take modes");
      break;
    }
  for (const FreeGroup& group : free_groups(m)) {
    const BodyData& root = m.bodies[static_cast<std::size_t>(group.root)];
    const spec::Body& body = m.spec().bodies[static_cast<std::size_t>(root.spec)];
    refuse(body.mark,
           fmt::format("body '{}' flies freely, whose laws of conservation code does not keep; run it "
                       "with the library",
                       body.name));
  }
  for (const ConstraintData& c : m.constraints)
    if (c.state_count > 0) {
      const auto& of = m.spec().constraints[static_cast<std::size_t>(c.spec)];
      refuse(of.mark,
             fmt::format("constraint '{}' is on a curve, or counts turns, which code does not", of.name));
    }
  bool meshes = false, swarms = false;
  for (const ElementData& e : m.elements) {
    swarms = swarms || e.pooled;
    if (e.surface >= 0)
      meshes = meshes || !m.surfaces[static_cast<std::size_t>(e.surface)].mesh.triangles.empty();
    if (e.user)
      refuse(file,
             fmt::format("{} has a law of your own, of which the library knows no formula: write it as an "
                         "expression of the model file",
                         element_name(m, e)));
  }
  if (swarms) refuse(file, "code is not made of swarms, whose pairs change from step to step");
  if (meshes)
    refuse(file, "code is not made of contacts with surfaces of triangles: take spheres, boxes or planes");
  const SignalsData& d = m.signals;
  if (d.fixed_loops || d.moving_loops)
    refuse(file, "code is not made of signals that go around in loops; break the loop by a sampled block");
  for (const spec::Block& b : m.spec().blocks) {
    if (b.outside) {
      refuse(b.mark,
             fmt::format("signal '{}' is computed by an FMU, whose code is not ours to write: leave it to "
                         "`mimbre run`, or write it as a block of the model file",
                         b.name));
      continue;
    }
    if (b.every > 0)
      refuse(b.mark,
             fmt::format("signal '{}' is sampled, which code is not yet: leave 'every' away", b.name));
    if (b.type == "delay" || b.type == "hysteresis" || b.type == "noise")
      refuse(b.mark, fmt::format("signal '{}' is of a block {}, of which code is not made", b.name, b.type));
    if (b.type == "table_2d")
      refuse(b.mark,
             fmt::format("signal '{}' is of a table of two variables, of which code is not made", b.name));
  }
  for (const SignalsData::Sampled& s : d.sampled)
    if (s.block < 0) {
      refuse(file, "a signal is evaluated at instants, which code is not yet: leave 'every' away");
      break;
    }
  for (const spec::Event& e : m.spec().events)
    refuse(e.mark,
           fmt::format("event '{}' would end steps early, which code with a fixed step does not", e.name));
  return all;
}

}  // namespace mimbre::portable
