#include "simulation/describe/explain.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "compile/element_name.h"
#include "integrate/vectors.h"
#include "joints/joint_kind.h"
#include "simulation/describe/names.h"

namespace mimbre {
namespace {

/// Masses that are further apart than this may be lost in each other's round-off.
constexpr double digits_of_masses = 1e10;
/// Masses that are joined and further apart than this make stiff mechanisms.
constexpr double apart = 1e5;

/// Bodies that no mass moves with: neither they nor what they carry have any.
std::vector<std::string> moved_without_mass(const Compiled& m) {
  std::vector<double> carried;
  for (const BodyData& b : m.bodies) carried.push_back(b.mass);
  for (std::size_t k = m.bodies.size(); k-- > 0;)  // parents come before children
    if (m.bodies[k].parent >= 0) carried[static_cast<std::size_t>(m.bodies[k].parent)] += carried[k];
  std::vector<std::string> names;
  for (std::size_t k = 0; k < m.bodies.size(); ++k)
    if (carried[k] == 0 && m.bodies[k].size() > 0) names.push_back(m.spec().bodies[m.bodies[k].spec].name);
  return names;
}

std::string quoted(const std::vector<std::string>& names) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t k = 0; k < std::min(names.size(), most); ++k)
    text += fmt::format("{}'{}'", k > 0 ? ", " : "", names[k]);
  return names.size() > most ? text + ", …" : text;
}

/// Signals that are evaluated at instants and that force elements or loads follow, by other signals too.
std::vector<std::string> sampled_forces(const Compiled& m) {
  const SignalsData& d = m.signals;
  std::vector<char> used(static_cast<std::size_t>(d.slots), 0);
  bool changed = true;
  const auto use = [&](int slot) {
    if (slot < 0 || used[static_cast<std::size_t>(slot)]) return;
    used[static_cast<std::size_t>(slot)] = 1;
    changed = true;
  };
  const auto use_all = [&](const LawData& law) {
    for (const int slot : law.slots) use(slot);
  };
  for (const LawData& law : m.formulas) use_all(law);
  for (const int slot : m.arguments) use(slot);
  const auto follow = [&](const SignalsData::Computed& made) {
    const int count = made.block < 0 ? 1 : d.blocks[made.block].outputs;
    const char* const first = used.data() + made.slot;
    if (std::none_of(first, first + count, [](char wanted) { return wanted != 0; })) return;
    if (made.block < 0) return use_all(made.law);
    for (const LawData& law : d.blocks[made.block].laws) use_all(law);
  };
  while (changed) {
    changed = false;
    for (const SignalsData::Computed& made : d.fixed) follow(made);
    for (const SignalsData::Computed& made : d.moving) follow(made);
  }
  std::vector<std::string> names;
  for (std::size_t k = 0; k < m.spec().signals.size(); ++k) {
    const spec::Signal& signal = m.spec().signals[k];
    const double every =
        signal.block < 0 ? signal.every : m.spec().blocks[static_cast<std::size_t>(signal.block)].every;
    if (const int slot = d.slot_of_signal[k];
        signal.named && every > 0 && slot >= 0 && used[static_cast<std::size_t>(slot)])
      names.push_back(signal.name);
  }
  return names;
}

std::vector<std::string> names_of(const spec::Model& model, const std::vector<int>& bodies) {
  std::vector<std::string> names;
  for (const int k : bodies) names.push_back(model.bodies[static_cast<std::size_t>(k)].name);
  return names;
}

/// That of the equation that came apart, with its unit.
std::string violation_of(const Mechanism& mechanism, const StepReport& r) {
  const bool is_angle =
      r.equation >= 0 && mechanism.system.scales().is_angle[static_cast<std::size_t>(r.equation)];
  return fmt::format("{:.3g} {}", r.equation_violation, is_angle ? "rad" : "m");
}

/// A light body that is joined to a heavier one is held by forces of the weight of the heavy one, and swings
/// between them about √(M/m) times as fast as the mechanism: a matrix of inertias and springs, which does not
/// know of these forces, only leads to the solution of a step that is shorter than that.
std::string follows(const Compiled& m, double lightest, double heaviest) {
  const double gravity = m.gravity.norm();
  if (!(gravity > 0)) return "a very short step follows";
  return fmt::format("steps of about {:.0e} s follow",
                     std::sqrt(lightest / heaviest * m.length_scale / gravity));
}

/// Where a body is joined to one so much heavier that a step hardly follows it: which ones, else nothing.
std::string lost_masses(const Compiled& m) {
  struct Extremes {
    const BodyData *lightest = nullptr, *heaviest = nullptr;
  };
  std::vector<std::size_t> root;  // of the tree that stands on the ground there
  std::vector<Extremes> trees(m.bodies.size());
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {  // parents come before children
    const BodyData& b = m.bodies[k];
    root.push_back(b.parent < 0 ? k : root[static_cast<std::size_t>(b.parent)]);
    if (!(b.mass > 0)) continue;
    Extremes& e = trees[root[k]];
    if (!e.lightest || b.mass < e.lightest->mass) e.lightest = &b;
    if (!e.heaviest || b.mass > e.heaviest->mass) e.heaviest = &b;
  }
  for (const Extremes& e : trees)
    if (e.lightest && e.heaviest->mass > apart * e.lightest->mass)
      return fmt::format(
          "; body '{}' of {:.3g} kg is joined to '{}' of {:.3g} kg: what holds the one moves the other so "
          "fast that only {} it, and beyond a ratio of 1e13 too few digits are left",
          m.spec().bodies[e.lightest->spec].name, e.lightest->mass, m.spec().bodies[e.heaviest->spec].name,
          e.heaviest->mass, follows(m, e.lightest->mass, e.heaviest->mass));
  return {};
}

/// The body that a velocity coordinate moves, or with `carried` what carries that, where it floats freely;
/// null elsewhere.
const BodyData* free_body(const Compiled& m, const natural::NaturalSystem* natural, int coordinate,
                          bool carried) {
  for (std::size_t k = 0; k < m.bodies.size(); ++k) {
    const BodyData* root = &m.bodies[k];
    while (carried && root->parent >= 0) root = &m.bodies[static_cast<std::size_t>(root->parent)];
    const BodyData& b = m.bodies[k];
    const bool here = natural
                          ? coordinate >= 0 && natural->body_of(coordinate) == static_cast<int>(k)
                          : coordinate >= b.v && coordinate < b.v + (carried ? b.size() : b.joint_velocities);
    if (here && joint_info(root->joint).free() && root->parent < 0) return root;
  }
  return nullptr;
}

/// Of a generalised force. A natural coordinate belongs to a point or to a unit vector of a body.
std::string_view unit_of_force(const Compiled& m, const natural::NaturalSystem* natural, int coordinate) {
  if (natural) return "N at a point, or N m about an axis";
  for (const BodyData& b : m.bodies) {
    if (coordinate < b.v || coordinate >= b.v + b.size()) continue;
    if (coordinate >= b.v + b.joint_velocities) return "J per unit of the mode";
    return is_angle(b.joint, coordinate - b.v) ? "N m" : "N";
  }
  return "N or N m";
}

/// Of explicit integrators.
std::string explain_unstable(const Mechanism& mechanism, const StepReport& r, double t, double stable) {
  if (r.part > 0)
    return fmt::format(
        "the accuracy asks for parts of {:.1e} s or for too many of them in the step to t = {:.6g} s: "
        "something is stiff there, or jumps; ask for less accuracy, or use generalized_alpha (the default)",
        r.part, t);
  const double step = t - mechanism.state.time;
  const bool is_stiff = stable > 0 && stable < step;
  const std::string where =
      r.coordinate < 0
          ? ""
          : ", most in " + coordinate_name(mechanism.model, mechanism.natural.get(), r.coordinate);
  return fmt::format(
      "the step of {:.3g} s to t = {:.6g} s is too long for an explicit integrator{}: {}; use "
      "generalized_alpha (the default), which is stable with any step{}",
      step, t, where,
      is_stiff ? "something vibrates or decays there much faster" : "something jumps there, or is stiff",
      is_stiff ? fmt::format(", or steps of up to about {:.1e} s", stable) : "");
}

}  // namespace

std::string explain_contradiction(const Compiled& m, const Redundancy& redundancy) {
  for (const DriveData& drive : m.drives) {
    const std::string& joint = m.spec().joints[m.bodies[drive.body].joint_spec].name;
    std::vector<std::string> others = redundancy.joints;
    if (std::erase(others, joint) == 0) continue;
    others.insert(others.end(), redundancy.constraints.begin(), redundancy.constraints.end());
    if (others.empty()) continue;
    return fmt::format(
        "; the drive of joint '{}' and {} determine a motion twice, which fails where they "
        "contradict each other",
        joint, quoted(others));
  }
  return {};
}

std::string explain_undetermined_start(const Compiled& m, const natural::NaturalSystem* natural,
                                       int coordinate) {
  const std::vector<std::string> names = moved_without_mass(m);
  if (!names.empty())
    return fmt::format(
        "the accelerations at the start are not determined: {} {} move{} without any mass, of {} own or of "
        "what "
        "{} carr{}; give mass and inertia, or fix {} to another body",
        names.size() > 1 ? "bodies" : "body", quoted(names), names.size() > 1 ? "" : "s",
        names.size() > 1 ? "their" : "its", names.size() > 1 ? "they" : "it", names.size() > 1 ? "y" : "ies",
        names.size() > 1 ? "them" : "it");
  if (coordinate < 0)
    return "the accelerations at the start are not determined: some motion moves neither mass nor inertia; "
           "give every body that turns about an axis through its centre of mass an inertia";
  const std::string where = coordinate_name(m, natural, coordinate);
  double lightest = std::numeric_limits<double>::infinity(), heaviest = 0;
  std::vector<std::string> massless;
  for (const BodyData& b : m.bodies) {
    if (b.mass > 0) lightest = std::min(lightest, b.mass);
    heaviest = std::max(heaviest, b.mass);
    if (!(b.mass > 0)) massless.push_back(m.spec().bodies[static_cast<std::size_t>(b.spec)].name);
  }
  if (!massless.empty())
    return fmt::format(
        "the accelerations at the start are not determined: a motion of {} moves neither mass nor inertia, "
        "and no spring or damper holds it; {} {} no mass: give mass and inertia, a spring with a damper, or "
        "one of two joints that leave the same motion free fewer freedoms",
        where, quoted(massless), massless.size() > 1 ? "have" : "has");
  if (heaviest > lightest * digits_of_masses)
    return fmt::format(
        "the accelerations at the start are not determined: a motion of {} moves so little beside the rest "
        "that its inertia is lost in round-off; masses go from {:.3g} to {:.3g} kg, of which a number has 15 "
        "digits: leave out or fix what is that light, or try the other formulation",
        where, lightest, heaviest);
  return fmt::format(
      "the accelerations at the start are not determined: a motion of {} moves neither mass nor inertia, or "
      "so little of them beside the rest that it is lost in round-off; give every body that turns about an "
      "axis through its centre of mass an inertia",
      where);
}

std::string explain_lost_constraint(const Mechanism& mechanism) {
  const natural::NaturalSystem* const natural = mechanism.natural.get();
  const int k = find_not_finite(mechanism.system.phi(), mechanism.system.equations());
  if (k < 0) return "";
  const ConstraintData* const c = constraint_of(mechanism.model, natural, k);
  return fmt::format("{} is not a number{}", equation_name(mechanism.model, natural, k),
                     c && c->road >= 0
                         ? ": the wheel is in a hollow that is narrower than itself, where it would "
                           "touch the road at two points; smooth the road, or take a tyre"
                         : "");
}

std::string explain(const Mechanism& mechanism, const StepReport& r, double t, const std::string& jump,
                    const std::string& meaningless, double stable) {
  const Compiled& model = mechanism.model;
  const natural::NaturalSystem* const natural = mechanism.natural.get();
  const std::string where = coordinate_name(model, natural, r.coordinate);
  switch (r.code) {
    case StepReport::Code::ok:
      return "ok";
    case StepReport::Code::block_failed:
      return "a block from elsewhere failed";
    case StepReport::Code::not_converged:
      if (!jump.empty())
        return fmt::format(
            "the step to t = {:.6g} s did not converge in {} iterations: {}, and the iterations alternate "
            "between both; give it a slope (tanh(v/0.01) for sign(v)), use `frictions` for resistance to "
            "motion, or evaluate a signal at instants (`every`)",
            t, r.iterations, jump);
      if (!meaningless.empty())
        return fmt::format("the step to t = {:.6g} s did not converge in {} iterations: {}", t, r.iterations,
                           meaningless);
      return fmt::format(
          "the step to t = {:.6g} s did not converge in {} iterations, the largest correction in {}; "
          "a smaller step or an integrator with more damping (smaller rho) may help{}",
          t, r.iterations, where, lost_masses(model));
    case StepReport::Code::not_finite:
      if (const std::string constraint = explain_lost_constraint(mechanism); !constraint.empty())
        return fmt::format("in the step to t = {:.6g} s {}", t, constraint);
      return fmt::format("a number is not finite in the step to t = {:.6g} s, first in {}{}", t, where,
                         lost_masses(model));
    case StepReport::Code::drifted:
      if (r.unconverged)
        return fmt::format(
            "the {} iterations that the fixed cost allows for the step to t = {:.6g} s did not converge: {} "
            "is off by {}; allow more of them (max_iterations), take a smaller step, or no fixed cost",
            r.iterations, t, equation_name(model, natural, r.equation), violation_of(mechanism, r));
      return fmt::format(
          "the constraints have come apart in the step to t = {:.6g} s: {} is off by {}; this formalism does "
          "not keep them closed; use `index3`, a stabilised one or a smaller step",
          t, equation_name(model, natural, r.equation), violation_of(mechanism, r));
    case StepReport::Code::unstable:
      return explain_unstable(mechanism, r, t, stable);
    case StepReport::Code::beyond_table:
      return fmt::format(
          "the step to t = {:.6g} s leaves the table of {}, which ends at a dead point, where the loop could "
          "go "
          "on in another way, or a turn away from the start; use the formalism `index3`",
          t, where);
    case StepReport::Code::singular:
      if (r.equation >= 0)
        return fmt::format(
            "the constraints are dependent in the step to t = {:.6g} s, at {}: a singular position, or a "
            "redundant joint; use a formalism that tolerates one (`index3`, `penalty`, `index1_augmented`)",
            t, equation_name(model, natural, r.equation));
      return fmt::format(
          "the matrix of the step to t = {:.6g} s is singular at {}: is there a body without mass that "
          "nothing holds?{}",
          t, where, lost_masses(model));
  }
  return {};
}

namespace {

std::string describe_imbalance(const Compiled& model, const natural::NaturalSystem* natural,
                               const StaticsStatus& status) {
  const bool has_wheels = std::any_of(model.elements.begin(), model.elements.end(),
                                      [](const ElementData& e) { return e.measure == Measure::wheel; });
  // What is not balanced lies anywhere between a vehicle and its wheels.
  const BodyData* const body = free_body(model, natural, status.coordinate, has_wheels);
  const std::string_view unit = unit_of_force(model, natural, status.coordinate);
  if (body && has_wheels)
    return fmt::format(
        "no static equilibrium was found: nothing holds body '{}' against {:.3g} {}; on wheels that no brake "
        "holds it rolls away, and on a slope that friction does not hold it "
        "slides; give the hubs friction that holds, and no velocities",
        model.spec().bodies[body->spec].name, status.residual, unit);
  if (body)
    return fmt::format(
        "no static equilibrium was found: body '{}' floats freely, and nothing holds it against {:.3g} {}; "
        "join it to the ground or to a body that is, or carry it by springs",
        model.spec().bodies[body->spec].name, status.residual, unit);
  std::string open;
  if (status.position_violation > 0)
    open += fmt::format(", lengths off by {:.3g} m", status.position_violation);
  if (status.angle_violation > 0) open += fmt::format(", angles off by {:.3g} rad", status.angle_violation);
  return fmt::format(
      "no static equilibrium was found: unbalanced force {:.3g} {}, the largest in {} (does anything hold "
      "it?){}, after {} iterations",
      status.residual, unit, coordinate_name(model, natural, status.coordinate), open, status.iterations);
}

}  // namespace

std::string explain_imbalance(const Compiled& model, const natural::NaturalSystem* natural,
                              const StaticsStatus& status) {
  std::string text = describe_imbalance(model, natural, status);
  if (const std::vector<std::string> names = sampled_forces(model); !names.empty())
    text += fmt::format(
        "; forces follow {}, which {} sampled (`every`) and {} as 0 in an equilibrium; a signal without "
        "`every` acts there",
        quoted(names), names.size() > 1 ? "are" : "is", names.size() > 1 ? "count" : "counts");
  if (const std::string laws = explain_sampled_laws(model); !laws.empty()) text += "; " + laws;
  return text;
}

std::string explain_sampled_laws(const Compiled& model) {
  std::vector<std::string> names;
  for (const ElementData& e : model.elements)
    if (e.sampled)
      if (const std::string name = element_name(model, e);
          std::find(names.begin(), names.end(), name) == names.end())
        names.push_back(name);
  if (names.empty()) return {};
  return fmt::format(
      "{} exert{} no force in an equilibrium: functions of Python are called in runs only; an expression or "
      "a "
      "compiled function acts there",
      fmt::join(names, ", "), names.size() > 1 ? "" : "s");
}

std::string explain_instability(const Compiled& model, const natural::NaturalSystem* natural,
                                const StaticsStatus& status) {
  if (!(status.growth > 0)) return {};
  return fmt::format(
      "the static equilibrium is unstable: the smallest disturbance grows by e in {:.3g} s, most in {}",
      1 / status.growth, coordinate_name(model, natural, status.growing));
}

std::string explain_near_redundancy(const Redundancy& r) {
  if (r.nearly == 0) return {};
  std::vector<std::string> names = r.nearly_joints;
  names.insert(names.end(), r.nearly_constraints.begin(), r.nearly_constraints.end());
  return fmt::format(
      "constraints are nearly redundant: axes or points of {} {} are off by so little that the "
      "mechanism "
      "may lock, and their reactions are arbitrary; give them exactly, or free a coordinate of one of them",
      r.nearly_constraints.empty() ? "joints" : "joints and constraints", quoted(names));
}

std::string explain_open_bending(const Compiled& m, const std::vector<int>& bodies, const Redundancy& r) {
  if (bodies.empty()) return {};
  const std::vector<std::string> bent = names_of(m.spec(), bodies);
  std::vector<std::string> holders = r.joints;
  for (const auto* more : {&r.constraints, &r.nearly_joints, &r.nearly_constraints})
    for (const std::string& name : *more)
      if (std::find(holders.begin(), holders.end(), name) == holders.end()) holders.push_back(name);
  return fmt::format(
      "{} {} bend{} by elastodynamics under reactions that rigid bodies leave open, since constraints of {} "
      "repeat each other: deflections, stresses and section forces are right only where no load asks for "
      "these reactions; take `flexibility: floating_frame`, or joints that repeat nothing",
      bent.size() > 1 ? "bodies" : "body", quoted(bent), bent.size() > 1 ? "" : "s", quoted(holders));
}

std::string explain_held_elsewhere(const spec::Model& model, const std::vector<int>& bodies) {
  if (bodies.empty()) return {};
  const std::vector<std::string> names = names_of(model, bodies);
  const bool many = names.size() > 1;
  return fmt::format(
      "{} {} with `stiffening: geometric_stiffness` {} held at another place than where {} clamped: once "
      "bent, loads of inertia may take the mass of modes away; clamp {} where joints hold {}, or take "
      "`stiffening: foreshortening`",
      many ? "bodies" : "body", quoted(names), many ? "are" : "is", many ? "they are" : "it is",
      many ? "them" : "it", many ? "them" : "it");
}

std::string explain_lost_mass(const Compiled& m, const natural::NaturalSystem* natural, int coordinate) {
  if (natural) return {};
  for (const BodyData& b : m.bodies) {
    if (b.modes == 0 || coordinate < b.v + b.joint_velocities || coordinate >= b.v + b.size()) continue;
    if (m.flexible[static_cast<std::size_t>(b.flexible)].geometric.inertial == 0) return {};
    return fmt::format(
        "loads of inertia that stiffen body '{}' (`stiffening: geometric_stiffness`) take away the mass of "
        "{}: the body is bent, and held at another place than where it is clamped; clamp it where joints "
        "hold it, or take `stiffening: foreshortening`",
        m.spec().bodies[static_cast<std::size_t>(b.spec)].name, coordinate_name(m, natural, coordinate));
  }
  return {};
}

std::string explain_unresolved(const Compiled& model, const UnresolvedReaction& r) {
  return fmt::format(
      "at t = {:.6g} s the mechanism goes through a singular position (a change point), where reactions grow "
      "beyond all bounds and no step resolves them: joint '{}' would carry {:.3g} N and {:.3g} Nm; there, "
      "and whenever it happens again, the results contain the remaining reactions only",
      r.time, model.spec().joints[static_cast<std::size_t>(r.joint)].name, r.force, r.moment);
}

}  // namespace mimbre
