#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/method.h"
#include "mimbre/model.h"

/// Code for one model in another language, that needs nothing of this library.
namespace mimbre {

/// An input, a tunable parameter or an output of generated code.
struct GeneratedVariable {
  std::string name;        ///< the model's
  std::string identifier;  ///< in the code
  std::string unit, meaning;
  double start = 0;
  double min = 0, max = 0;  ///< of inputs; ±infinity: none
  bool tunable = false;
  // Of outputs: the values that they are computed from directly, not by way of a step.
  std::vector<int> inputs{};
  bool by_time = false;          ///< explicitly, by a function of time
  bool by_state = false;         ///< positions, velocities, or states of controllers and force elements
  bool by_acceleration = false;  ///< accelerations, which may depend on all inputs
};

/// A parameter that is fixed when a run begins: of FMUs with the library inside.
struct GeneratedParameter {
  std::string name, meaning;
  double start = 0;
  double min = 0, max = 0;  ///< ±infinity: none
  bool integer = false;
  bool derived = false;  ///< it follows from others, and cannot be set
};

/// A continuous state of code for derivatives.
struct GeneratedState {
  std::string meaning;
  std::string unit, rate_unit;  ///< empty: not known, or other ones after a change of coordinates
};

/// C99 for a model: what `name.h` and `name.c` contain, see docs/generated-code.md.
struct GeneratedCode {
  std::string name, header, source;
  std::vector<GeneratedVariable> inputs, outputs;
  std::vector<GeneratedParameter> parameters;  ///< fixed ones, whole ones last
  std::vector<std::string> left_out;   ///< outputs of the model that the code has not, with their kinds
  std::vector<GeneratedState> states;  ///< of code for derivatives: positions, their rates, others
  int indicators = 0;                  ///< likewise: of events
  int events = 0;                      ///< of the model, in code for steps
  bool varies = false;                 ///< it has directional derivatives
  double step = 0;                     ///< s
  long operations = 0;                 ///< in a step at most: sums, products, quotients, functions
  long bytes = 0;                      ///< of the struct
};

/// Steps with a fixed cost (RunOptions::fixed_cost, which is implied) of the formulation in relative
/// coordinates by the formalism index3. `name`: of the files and the prefix of what is in them, an identifier
/// of C. Throws InputError, with a line for each reason, where code cannot be made.
GeneratedCode generate_code(const std::shared_ptr<const Model>& model, const RunOptions& options,
                            const std::string& name);

/// Derivatives of the state by time instead of steps, for solvers of ordinary differential equations and FMUs
/// for model exchange (`mimbre fmu --kind me`). States are independent coordinates, their rates, and the
/// states of force elements and controllers; where the coordinates become singular, an event selects others.
///
/// Of the options, `inputs` are the start values; formulation and inertia have to be relative and integrals,
/// as in generate_code; the step, the integrator, the formalism and tolerances have no effect. `name`: as in
/// generate_code.
///
/// Throws InputError for the bodies, elements and signals that generate_code refuses, and for models without
/// such equations: contacts, stops, dry friction, wheels with slip, winches, blocks `rate_limit`, constraints
/// between velocities (rolling, knife edges), drives that follow inputs, signals of accelerations, events of
/// the model, and motions that move no mass. All reasons are in one error, a line each: those by the kinds of
/// elements, or if there are none, those that are found in the recorded equations. Also throws InputError
/// where the start cannot be found, as a run does.
GeneratedCode generate_exchange_code(const std::shared_ptr<const Model>& model, const RunOptions& options,
                                     const std::string& name);

/// The file's name as an identifier: "double-four-bar.yaml" is double_four_bar.
std::string identifier_of(const std::string& file);

/// Writes name.h and name.c into a folder, which is made. Throws InputError where that is not possible.
void write_code(const GeneratedCode& code, const std::string& folder);

}  // namespace mimbre
