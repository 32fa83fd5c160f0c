#pragma once
#include <map>
#include <string>
#include <vector>

#include "mimbre/generate.h"

/// A model as a functional mock-up unit (FMU), which other programs simulate together with theirs.
namespace mimbre {

struct FmuOptions {
  /// Co-simulation: it makes steps by itself. Model exchange: it has derivatives, and the importer's solver
  /// makes the steps.
  enum class Kind { co_simulation, model_exchange } kind = Kind::co_simulation;
  int version = 3;           ///< of the standard: 2 (2.0.4) or 3 (3.0.2)
  std::string name{};        ///< the model identifier, an identifier of C; empty: of the model's file
  bool binary_only = false;  ///< without the sources
  /// Of co-simulation: the library itself inside, as a binary, in place of code for the model. It takes
  /// whatever a run takes, with the method of a run.
  bool with_library = false;
  /// Of FMI 3: outputs that are all the components of one vector are one variable, an array: `tip` in place
  /// of tip.x, tip.y and tip.z.
  bool arrays = false;
  /// With the library inside: the parameters of the model's file that were replaced when the model was read
  /// (load_model()). With these the FMU reads the model again where its importer sets other parameters.
  std::map<std::string, std::string> settings{};
  double reference = 1;  ///< s of a run whose result goes along; 0: none
};

/// A variable of an FMU.
struct FmuVariable {
  std::string name, unit, meaning;
  unsigned reference = 0;
  /// parameter: tunable; fixed: set before the start alone; derived: following from fixed ones; count: of
  /// steps; state, derivative, indicator: of model exchange.
  enum class Role {
    time,
    input,
    parameter,
    output,
    fixed,
    derived,
    count,
    state,
    derivative,
    indicator
  } role = Role::output;
  bool integer = false;                ///< a whole number
  double start = 0, min = 0, max = 0;  ///< of inputs and parameters; ±infinity: no bound
  /// Of outputs: the variables that they are computed from directly, ascending: the time, inputs, in FMI 3
  /// parameters, and for model exchange states.
  std::vector<unsigned> dependencies{};
  bool depends_on_all = false;  ///< instead: on all of these
  unsigned state = 0;           ///< of derivatives: the reference of the state
  /// Of outputs: their numbers among those of the code: one, or of an array its elements in their order.
  std::vector<int> outputs{};
};

/// What an FMU is made of: the code, with the functions of the standard around it.
struct FmuCode {
  GeneratedCode code;
  FmuOptions::Kind kind = FmuOptions::Kind::co_simulation;
  int version = 3;
  bool with_library = false;  ///< calls the library: runs where its runtime is at hand, as in the FMU
  bool arrays = false;        ///< outputs may be arrays
  std::string token;          ///< by which a model description and a binary know each other
  std::string wrapper;        ///< C99, the file fmi2.c or fmi3.c
  std::vector<FmuVariable> variables;
};

/// Co-simulation with steps of a fixed cost, of what `generate_code` makes code of, or model exchange, of
/// what `generate_exchange_code` does. Variables have the names of the model's inputs, tunable parameters and
/// outputs. With the library inside, steps are those of a run, and only laws and blocks that are code from
/// elsewhere are refused. Throws InputError as these do, for a version that is neither 2 nor 3, for model
/// exchange with the library, and for arrays in FMI 2.
FmuCode generate_fmu(const std::shared_ptr<const Model>& model, const RunOptions& options,
                     const FmuOptions& fmu = {});

/// modelDescription.xml.
std::string fmu_description(const FmuCode& fmu, const Model& model, bool with_sources);

struct WrittenFmu {
  std::vector<std::string> files;     ///< in the archive
  std::vector<std::string> left_out;  ///< outputs of the model that it has not, with their kinds
  std::string without_binary;         ///< why it has none; empty: it has one
};
/// Writes the archive: model description, terminals at the parts of the model with icons, sources, a binary
/// for this machine where there is a C compiler ($CC, else `cc`), a page of documentation, a reference result
/// as an experiment, and the validation reports of the reduced bodies. An older file stands until the new one
/// is whole. With the library inside there is a binary alone. Throws InputError where the file cannot be
/// written, where an FMU without sources finds no compiler, where this library was built without the runtime
/// that FMUs take along, and as generate_fmu does.
WrittenFmu write_fmu(const std::shared_ptr<const Model>& model, const RunOptions& options,
                     const FmuOptions& fmu, const std::string& path);

}  // namespace mimbre
