#pragma once
#include <map>
#include <optional>
#include <string>

/// How a model is computed: what its file asks for, what a caller asks for, and what a run took. An option
/// has a member in the first two; all else that there is to know of it is a row of the table in
/// src/spec/run_options.cpp (mimbre/run_option.h).
namespace mimbre {
namespace spec {

/// The model's section `simulation`, with `initial`.
struct Simulation {
  double step = 0.01;          ///< s
  double end = 10;             ///< s
  bool end_given = false;      ///< else `end` is the library's default
  double output_interval = 0;  ///< s; 0: every step
  /// Coordinates: joint coordinates by recursion, or points and unit vectors (natural coordinates).
  enum class Formulation { relative, natural } formulation = Formulation::relative;
  /// Inertia of flexible bodies: by shape integrals, or by projection of the mesh's mass matrix in every
  /// evaluation, with the nodes' rotations or with their translations only.
  enum class Inertia { integrals, projection, projection_translations } inertia = Inertia::integrals;
  /// How the constraints enter the equations of motion; see docs/formalisms.md.
  enum class Formalism {
    index3,            ///< augmented Lagrangian in positions with projections: the default
    index1,            ///< Lagrange multipliers, constraints at acceleration level
    baumgarte,         ///< the same, stabilised
    penalty,           ///< stabilised constraints by penalty alone
    index1_augmented,  ///< penalty with iterated multipliers
    independent,       ///< independent coordinates by a second velocity transformation
    global_modes,      ///< loops by tables: a joint coordinate and modes of the whole loop
    transfer_matrices  ///< index3 with Riccati transfer matrices, swept along the chain
  } formalism = Formalism::index3;
  enum class Integrator {
    generalized_alpha,
    newmark,
    hht,
    conserve,  ///< generalised-α, and after each step the energy that it fed in or took out taken back
    rk4,       ///< explicit, of order 4: for mechanisms without stiff parts
    dopri853,  ///< explicit, of order 8, with steps that follow from `accuracy` where it is given
    radau,     ///< implicit, of order 5, likewise: for stiff mechanisms, too
    automatic  ///< dopri853 or radau, chosen at the start (Method::chosen)
  } integrator = Integrator::generalized_alpha;
  double rho = -1;       ///< spectral radius at infinity, 0..1 (hht: 0.5..1); -1: the library's default
  double xi = 0;         ///< Newmark's ξ ≤ 0
  double tolerance = 0;  ///< of the iterations, see docs/model-file.md; 0: default
  double accuracy =
      0;  ///< of dopri853 and radau: error of a part of a step, by the mechanism's size; 0: whole steps
  double penalty = 0;                 ///< weight of the constraints; 0: automatic
  int max_iterations = 0;             ///< of a step, or of each of its parts; 0: default
  int substeps = 0;                   ///< parts in which an inaccurate step is repeated; 0: default, 1: never
  double energy_tolerance = 0;        ///< see RunOptions::energy_tolerance; 0: default
  bool fixed_cost = false;            ///< see RunOptions::fixed_cost
  bool start_at_equilibrium = false;  ///< `initial: equilibrium`
};

}  // namespace spec

/// Options of a run; what is not given is taken from the model file's simulation section.
struct RunOptions {
  std::optional<double> step;  ///< s
  std::optional<double> end;   ///< s
  std::optional<spec::Simulation::Formulation> formulation;
  std::optional<spec::Simulation::Inertia> inertia;
  std::optional<spec::Simulation::Formalism> formalism;
  /// Where it is not given, `xi` asks for Newmark's rule, and `rho` for generalised-α in Newmark's place.
  /// `rho` and `xi` do not go together, nor with an integrator that has none.
  std::optional<spec::Simulation::Integrator> integrator;
  std::optional<double> rho, xi, tolerance;
  std::optional<double> accuracy;  ///< of dopri853, radau and automatic, see docs/model-file.md
  std::optional<int> max_iterations;
  /// Parts in which a step is repeated when an impact in it makes its energy balance wrong, or when it does
  /// not converge. 1: never. In neither: 4 with generalised-α, 1 with Newmark.
  std::optional<int> substeps;
  /// By how much the balance may be wrong before: by this share of the energy that moves and is stored, and
  /// ten times that of what lifts the mechanism by its length scale (without gravity four times the former).
  /// In neither: 1e-4.
  std::optional<double> energy_tolerance;
  /// For real time: a step is made once, with at most so many iterations, and taken as it is then, though
  /// they have not converged (StepReport::unconverged). Nothing repeats a step, or begins one anew where an
  /// input jumps. Of the formalisms index3 and transfer_matrices.
  std::optional<bool> fixed_cost;
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

/// What a run takes: options, model file and the library's defaults, resolved. No member means a default.
struct Method : spec::Simulation {
  bool default_end = false;  ///< neither model nor options specify the end of the run
  bool profile = false;
  bool energies = true;  ///< asked for, or implied
  bool validity = true, warnings = true;
  /// Why the integrator was chosen, where `automatic` was asked for; else empty.
  std::string chosen;
};

/// The only place where defaults are decided, and where is asked what they are. Throws InputError, with the
/// names of the options, where one is out of its range or two of them conflict.
Method resolve_method(const spec::Simulation& given, const RunOptions& options);

}  // namespace mimbre
