#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <vector>

#include "mimbre/method_names.h"
#include "mimbre/run_option.h"

namespace mimbre {
namespace {

using S = spec::Simulation;
using Rule = S::Integrator;

constexpr std::array has_rho{Rule::generalized_alpha, Rule::hht};
constexpr std::array has_xi{Rule::newmark};
constexpr std::array has_accuracy{Rule::automatic, Rule::dopri853, Rule::radau};
constexpr std::array rho_replaces{Rule::newmark};
constexpr std::array accuracy_replaces{Rule::generalized_alpha, Rule::newmark, Rule::hht, Rule::conserve,
                                       Rule::rk4};
constexpr std::array xi_replaces{Rule::generalized_alpha, Rule::hht, Rule::conserve};

constexpr RunOption table[] = {
    {.key = "formulation",
     .member = OptionMember<S::Formulation>{&S::formulation, &RunOptions::formulation},
     .about = "Coordinates: of the joints (relative), or points and unit vectors (natural).",
     .words = method_names::formulations,
     .option = "formulation",
     .value = "NAME",
     .help = "Coordinates, instead of the model's:\n"
             "relative: of the joints, by recursion\n"
             "natural: points and unit vectors of the bodies",
     .of_steps = false,
     .in_headline = true},
    {.key = "inertia",
     .member = OptionMember<S::Inertia>{&S::inertia, &RunOptions::inertia},
     .about = "Inertia of flexible bodies: shape integrals, or projection of the mesh's mass matrix in every "
              "evaluation.",
     .words = method_names::inertias,
     .option = "inertia",
     .value = "NAME",
     .help = "Inertia of flexible bodies:\n"
             "integrals: shape integrals, computed once\n"
             "projection: of the mesh's mass matrix in every evaluation\n"
             "projection_translations: the same with the nodes' translations only",
     .of_steps = false,
     .in_headline = true},
    {.key = "formalism",
     .member = OptionMember<S::Formalism>{&S::formalism, &RunOptions::formalism},
     .about = "How the constraints enter the equations of motion.",
     .words = method_names::formalisms,
     .option = "formalism",
     .value = "NAME",
     .help = "How the constraints enter the equations of motion:\n"
             "index3: augmented Lagrangian, with projections\n"
             "index1: Lagrange multipliers\n"
             "baumgarte: the same, stabilised\n"
             "penalty: penalty alone\n"
             "index1_augmented: penalty with iterated multipliers\n"
             "independent: independent coordinates\n"
             "global_modes: loops by tables over one coordinate and by modes of the loop\n"
             "transfer_matrices: index3, solved by a sweep along each chain of bodies",
     .in_headline = true},
    {.key = "integrator",
     .member = OptionMember<S::Integrator>{&S::integrator, &RunOptions::integrator},
     .about = "How steps are made.",
     .words = method_names::integrators,
     .option = "integrator",
     .value = "NAME",
     .help = "How steps are made:\n"
             "generalized_alpha: second order, damps what the step cannot resolve\n"
             "newmark: the trapezoidal rule, or with xi below 0 damped\n"
             "hht: Hilber, Hughes, Taylor\n"
             "conserve: generalized-alpha with its error of energy taken back\n"
             "rk4: explicit, fourth order, for mechanisms without stiff parts\n"
             "dopri853: explicit, eighth order, likewise\n"
             "radau: implicit, fifth order, for stiff mechanisms, too\n"
             "auto: dopri853 or radau, by stiffness, contacts and accuracy",
     .section = "integrator",
     .file_key = "type",
     .in_headline = true},
    {.key = "step",
     .member = OptionMember<double>{&S::step, &RunOptions::step},
     .about = "s; default: 0.01.",
     .unit = "s",
     .above = 0,
     .option = "step",
     .value = "H",
     .help = "Step in s, instead of the model's"},
    {.key = "rho",
     .member = OptionMember<double>{&S::rho, &RunOptions::rho},
     .about = "Spectral radius of generalized_alpha (0 to 1) and hht (0.5 to 1); 1 damps nothing.",
     .least = 0,
     .most = 1,
     .otherwise = 0.4,
     .option = "rho",
     .value = "R",
     .help = "Spectral radius of generalized_alpha, 0 to 1, or of hht, 0.5 to 1;\n"
             "where the model has newmark: generalized_alpha with it",
     .section = "integrator",
     .of = has_rho,
     .replaces = rho_replaces,
     .in_headline = true},
    {.key = "xi",
     .member = OptionMember<double>{&S::xi, &RunOptions::xi},
     .about = "Of newmark: 0, or less, which damps.",
     .most = 0,
     .option = "integrator-xi",
     .value = "XI",
     .help = "newmark with this xi, 0 or less",
     .section = "integrator",
     .of = has_xi,
     .replaces = xi_replaces,
     .in_headline = true},
    {.key = "accuracy",
     .member = OptionMember<double>{&S::accuracy, &RunOptions::accuracy},
     .about = "Of dopri853 and radau: error of each part that a step is made in, relative to the size of the "
              "mechanism; without it a step has one part.",
     .least = 1e-15,
     .most = 1,
     .option = "accuracy",
     .value = "A",
     .help = "dopri853 and radau divide steps by this error of each part, relative\n"
             "to the mechanism's size; without it a step has one part. Without an\n"
             "integrator: auto",
     .section = "integrator",
     .of = has_accuracy,
     .replaces = accuracy_replaces,
     .in_headline = true},
    {.key = "tolerance",
     .member = OptionMember<double>{&S::tolerance, &RunOptions::tolerance},
     .about = "Of the iterations, relative; default: 1e-5.",
     .least = 1e-15,
     .most = 1,
     .option = "tolerance",
     .value = "X",
     .help = "Tolerance of the iterations, relative to the accelerations at play,\n"
             "instead of the model's (1e-5 if it has none)",
     .in_headline = true},
    {.key = "penalty",
     .member = OptionMember<double>{&S::penalty},
     .about = "Weight of the constraints; default: that of the formalism.",
     .above = 0},
    {.key = "max_iterations",
     .member = OptionMember<int>{&S::max_iterations, &RunOptions::max_iterations},
     .about = "Of a step.",
     .least = 1,
     .most = 1000,
     .option = "max-iterations",
     .value = "N",
     .help = "Most iterations of a step, or of each part of one, instead of the\n"
             "model's (30 if it has none)"},
    {.key = "substeps",
     .member = OptionMember<int>{&S::substeps, &RunOptions::substeps},
     .about = "Parts in which an inaccurate step is made again; 1: never.",
     .least = 1,
     .most = 100,
     .option = "substeps",
     .value = "N",
     .help = "Parts in which a step is repeated that an impact made inaccurate,\n"
             "instead of the model's; 1: never"},
    {.key = "energy_tolerance",
     .member = OptionMember<double>{&S::energy_tolerance, &RunOptions::energy_tolerance},
     .about = "Error of a step's energy balance, relative to the energy in motion, above which it is made "
              "again in "
              "substeps; default: 1e-4.",
     .least = 1e-9,
     .most = 1,
     .otherwise = 1e-4,
     .option = "energy-tolerance",
     .value = "X",
     .help = "Error of a step's energy balance, relative to the energy in motion,\n"
             "above which the step is repeated in parts, instead of the model's\n"
             "(1e-4 if it has none)"},
    {.key = "fixed_cost",
     .member = OptionMember<bool>{&S::fixed_cost, &RunOptions::fixed_cost},
     .about = "For real time: a step is made once, and accepted after max_iterations (6).",
     .option = "fixed-cost",
     .help = "For real time: each step is made once, and accepted after\n"
             "--max-iterations (6 if neither the option nor the model sets them)",
     .help_not = "Iterate each step until it converges, even if the model has fixed_cost"},
    {.key = "end",
     .member = OptionMember<double>{&S::end, &RunOptions::end},
     .about = "s; default: 10.",
     .unit = "s",
     .least = 0,
     .changes_states = false},
    {.key = "output_interval",
     .member = OptionMember<double>{&S::output_interval},
     .about = "Of the rows of results, s; default: every step.",
     .unit = "s",
     .above = 0,
     .changes_states = false},
};

const RunOption& named(std::string_view key) {
  return *std::find_if(std::begin(table), std::end(table), [&](const RunOption& o) { return o.key == key; });
}

std::string listed(const std::vector<std::string>& names) {
  if (names.size() < 3) return fmt::format("{}", fmt::join(names, " and "));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

/// Which integrators have it.
std::string owners(const RunOption& option) {
  std::vector<std::string> names;
  for (const Rule rule : option.of) names.emplace_back(name_of(rule));
  return listed(names);
}

/// What an integrator has: "newmark has xi".
std::string own_options(Rule rule, OptionNames names) {
  std::vector<std::string> own;
  for (const RunOption& option : table)
    if (!option.of.empty() && option.belongs_to(rule)) own.push_back(name_of(option, names));
  return fmt::format("{} has {}", name_of(rule), own.empty() ? "none" : listed(own));
}

/// Of integrators, and of which of them a number is.
std::optional<OptionConflict> conflict_of_integrators(const S& given, const RunOptions& asked,
                                                      OptionNames names) {
  const Rule rule = integrator_in_force(given, asked);
  for (const RunOption& option : table) {
    if (option.of.empty() || !value_in(option, asked) || option.belongs_to(rule)) continue;
    for (const RunOption& other : table)
      if (!other.of.empty() && value_in(other, asked) && other.belongs_to(rule))
        return OptionConflict{
            option.key, fmt::format("{} ({}) and {} ({}) exclude each other: {} belongs to {}, {} to {}",
                                    name_of(other, names), *value_in(other, asked), name_of(option, names),
                                    *value_in(option, asked), name_of(other, names), owners(other),
                                    name_of(option, names), owners(option))};
    const std::string text = fmt::format("{0} is {1}, but the integrator is {2}{3}; {0} belongs to {4}",
                                         name_of(option, names), *value_in(option, asked), name_of(rule),
                                         asked.integrator ? "" : " in the model", owners(option));
    return OptionConflict{option.key, asked.integrator
                                          ? fmt::format("{}; {}", text, own_options(rule, names))
                                          : fmt::format("{}; name the one that you mean with {}, too", text,
                                                        name_of(named("integrator"), names))};
  }
  const RunOption& rho = named("rho");
  if (asked.rho && rule == Rule::hht && *asked.rho < least_hht_rho)
    return OptionConflict{
        rho.key, fmt::format("{} is {}; hht takes {} to 1", name_of(rho, names), *asked.rho, least_hht_rho)};
  return {};
}

/// Steps of a fixed cost are made once, by the iterations of index3, in two iterations at least: the first
/// one may only find where to start from.
std::optional<OptionConflict> conflict_of_fixed_cost(const S& given, const RunOptions& asked,
                                                     OptionNames names) {
  if (!asked.fixed_cost.value_or(given.fixed_cost)) return {};
  const RunOption& option = named("fixed_cost");
  const std::string who =
      asked.fixed_cost ? name_of(option, names) : fmt::format("the model has {}, which", option.key);
  const std::string way_out =
      asked.fixed_cost ? std::string()
                       : fmt::format(", or take {}, too",
                                     names == OptionNames::keys ? "fixed_cost = false" : "--no-fixed-cost");
  const auto conflict = [&](std::string_view key, const std::string& does, const std::string& value) {
    const std::string other = name_of(named(key), names);
    return OptionConflict{
        key, fmt::format("{} is {}, but {} {}; leave {} out{}", other, value, who, does, other, way_out)};
  };
  if (asked.substeps.value_or(1) > 1)
    return conflict("substeps", "makes each step once", fmt::format("{}", *asked.substeps));
  if (asked.energy_tolerance)
    return conflict("energy_tolerance", "makes each step once", fmt::format("{}", *asked.energy_tolerance));
  const S::Formalism formalism = asked.formalism.value_or(given.formalism);
  if (formalism != S::Formalism::index3 && formalism != S::Formalism::transfer_matrices)
    return conflict("formalism", "is of the formalism index3 or transfer_matrices", name_of(formalism));
  if (asked.max_iterations.value_or(given.max_iterations) == 1)
    return conflict("max_iterations", "needs two iterations at least", "1");
  return {};
}

/// Runge–Kutta methods take constraints into account in their own way, and with an accuracy choose the parts
/// of a step.
std::optional<OptionConflict> conflict_of_runge_kutta(const S& given, const RunOptions& asked,
                                                      OptionNames names) {
  const Rule rule = integrator_in_force(given, asked);
  if (!is_runge_kutta(rule)) return {};
  const auto conflict = [&](std::string_view key, const std::string& text) {
    return OptionConflict{key, fmt::format(fmt::runtime(text), name_of(named(key), names), name_of(rule))};
  };
  if (asked.formalism.value_or(given.formalism) != S::Formalism::index3)
    return conflict("formalism", is_explicit(rule)
                                     ? "{} is given, but {} is explicit and has no formalism; leave it out"
                                     : "{} is given, but {} has no formalism; leave it out");
  if (!estimates_error(rule) || !(asked.accuracy.value_or(given.accuracy) > 0)) return {};
  if (asked.substeps.value_or(1) > 1)
    return conflict(
        "substeps",
        "{} is given, but with an accuracy {} chooses the parts of a step; leave one of them out");
  if (asked.fixed_cost.value_or(given.fixed_cost))
    return conflict("fixed_cost", "{} is given, but {} has an accuracy to keep; leave one of them out");
  return {};
}

}  // namespace

bool RunOption::allows(double x) const { return std::isfinite(x) && x > above && x >= least && x <= most; }

bool RunOption::belongs_to(Simulation::Integrator integrator) const {
  return of.empty() || std::find(of.begin(), of.end(), integrator) != of.end();
}

std::span<const RunOption> run_option_table() { return table; }

const RunOption* find_run_option(std::string_view key) {
  for (const RunOption& option : table)
    if (option.key == key && !option.option.empty()) return &option;
  return nullptr;
}

std::string allowed_numbers(const RunOption& option) {
  const std::string kind =
      std::holds_alternative<OptionMember<int>>(option.member) ? "a whole number" : "a number";
  const std::string of = option.unit.empty()
                             ? kind
                             : fmt::format("{} of {}", kind, option.unit == "s" ? "seconds" : option.unit);
  if (std::isfinite(option.above)) return fmt::format("{} above {}", of, option.above);
  if (!std::isfinite(option.least)) return fmt::format("{} of {} or less", kind, option.most);
  if (!std::isfinite(option.most)) return fmt::format("{} from {}", of, option.least);
  return fmt::format("{} from {} to {}", of, option.least, option.most);
}

double value_in(const RunOption& option, const S& simulation) {
  return std::visit([&](const auto& m) { return static_cast<double>(simulation.*m.in_model); },
                    option.member);
}

std::optional<double> value_in(const RunOption& option, const RunOptions& asked) {
  return std::visit(
      [&](const auto& m) -> std::optional<double> {
        if (!m.asked || !(asked.*m.asked)) return {};
        return static_cast<double>(*(asked.*m.asked));
      },
      option.member);
}

bool is_given(const RunOption& option, const S& simulation) {
  return !(value_in(option, simulation) == value_in(option, S()));
}

std::string wrong_value(const RunOption& option, double value) {
  if (!option.words.empty())
    return value >= 0 && value < static_cast<double>(option.words.size())
               ? std::string()
               : fmt::format("is {}, which is none of its {} choices", value, option.words.size());
  if (std::holds_alternative<OptionMember<bool>>(option.member) || option.allows(value)) return {};
  return fmt::format("is {}; it must be {}", value, allowed_numbers(option));
}

std::string shown_value(const RunOption& option, double value) {
  if (!option.words.empty()) return option.words[static_cast<std::size_t>(value)];
  if (std::holds_alternative<OptionMember<bool>>(option.member)) return value != 0 ? "true" : "false";
  return fmt::format("{}", value);
}

std::string name_of(const RunOption& option, OptionNames names) {
  return names == OptionNames::keys ? std::string(option.key) : fmt::format("--{}", option.option);
}

std::optional<OptionConflict> find_conflict(const S& given, const RunOptions& asked, OptionNames names) {
  if (auto found = conflict_of_integrators(given, asked, names)) return found;
  if (auto found = conflict_of_runge_kutta(given, asked, names)) return found;
  return conflict_of_fixed_cost(given, asked, names);
}

Rule integrator_in_force(const S& given, const RunOptions& asked) {
  if (asked.integrator) return *asked.integrator;
  for (const RunOption& option : table)
    if (value_in(option, asked) &&
        std::find(option.replaces.begin(), option.replaces.end(), given.integrator) != option.replaces.end())
      return option.of.front();
  return given.integrator;
}

}  // namespace mimbre
