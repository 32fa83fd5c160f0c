#pragma once
#include <map>
#include <optional>
#include <string>

#include "mimbre/spec.h"

/// How a model is computed: what a run was asked for, and what it took.
namespace mimbre {

/// Options of a run; fields left at their defaults are taken from the model file's simulation section.
struct RunOptions {
  double step = 0;  ///< s
  std::optional<spec::Simulation::Formulation> formulation;
  std::optional<spec::Simulation::Inertia> inertia;
  std::optional<spec::Simulation::Formalism> formalism;
  /// Where it is not given, `xi` asks for Newmark's rule, and `rho` for generalised-α in Newmark's place.
  /// `rho` and `xi` do not go together, nor with an integrator that has none.
  std::optional<spec::Simulation::Integrator> integrator;
  double rho = -1;
  double xi = 1;         ///< Newmark's ξ ≤ 0; 1: not given
  double tolerance = 0;  ///< of the iterations, see docs/model-file.md; 0: from the file
  double accuracy = 0;   ///< of dopri853, see docs/model-file.md; 0: from the file
  /// Parts in which a step is repeated when an impact in it makes its energy balance wrong (by more than
  /// 1e-3 of what lifts it by its length scale and 1e-4 of the energy that moves and is stored), or when it
  /// does not converge. 1: never; 0: from the file, or 4 with generalised-α, 1 with Newmark.
  int substeps = 0;
  int max_iterations = 0;  ///< of a step, or of each of its parts; 0: from the file
  /// For real time: a step is made once, with at most so many iterations, and taken as it is then, though
  /// they have not converged (StepReport::unconverged). Nothing repeats a step, or begins one anew where an
  /// input jumps. Of the formalism index3. Where it is not given: from the file.
  std::optional<bool> fixed_cost;
  double end = -1;  ///< s; negative: from the file, or the default
  /// What inputs and tunable parameters start with, by name, within their ranges; others with the model's
  /// values. The start, its equilibrium and all that is observed there are those of a model with these
  /// values.
  std::map<std::string, double> inputs;
  bool profile = false;  ///< measure the phases of the steps (Simulation::phases); costs a few per cent
  // What is watched while stepping; what is not costs nothing.
  /// The energy balance. Substeps need it, and so does the integrator `conserve`: they imply it.
  bool energies = true;
  bool validity = true;  ///< what the linear description of flexible bodies neglects
  bool warnings = true;  ///< of both, and of the start
};

/// What a run takes: options, model file and the library's defaults, resolved.
struct Method {
  spec::Simulation::Formulation formulation = spec::Simulation::Formulation::relative;
  spec::Simulation::Inertia inertia = spec::Simulation::Inertia::integrals;
  spec::Simulation::Formalism formalism = spec::Simulation::Formalism::index3;
  spec::Simulation::Integrator integrator = spec::Simulation::Integrator::generalized_alpha;
  double step = 0;             ///< s
  double rho = 0;              ///< spectral radius at infinity of generalised-α and HHT
  double xi = 0;               ///< of Newmark's rule
  double tolerance = 0;        ///< see IntegratorOptions
  double penalty = 0;          ///< likewise
  double accuracy = 0;         ///< of dopri853, for the length of its steps; 0: they are `step` long
  int max_iterations = 0;      ///< of a step
  int substeps = 1;            ///< parts in which an inaccurate step is repeated; 1: never
  bool fixed_cost = false;     ///< steps are taken as they are after max_iterations
  double end = 0;              ///< s
  bool default_end = false;    ///< neither model nor options specify the end of the run
  double output_interval = 0;  ///< s; 0: every step
  bool profile = false;
  bool energies = true;  ///< asked for, or implied
  bool validity = true, warnings = true;
};

/// The only place where defaults are decided, and where is asked what they are. Throws InputError, with the
/// names of the options, where one is out of its range or two of them conflict.
Method resolve_method(const spec::Simulation& given, const RunOptions& options);

}  // namespace mimbre
