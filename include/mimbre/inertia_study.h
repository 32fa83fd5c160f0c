#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "mimbre/inertia_term.h"
#include "mimbre/method.h"
#include "mimbre/spec.h"

/// Which terms of flexible bodies' inertia a model can do without, for a stated error of its outputs.
namespace mimbre {

struct InertiaStudyOptions {
  double error = 1e-3;  ///< the largest of an output that is allowed, by its range in the run
  double end = 0;       ///< s; 0: the model's
  /// Names of channels; none: the model's outputs, and where it has none the coordinates of its joints.
  std::vector<std::string> outputs;
  RunOptions run;       ///< of the runs; with shape integrals, as the mesh's mass matrix has no terms
  bool measure = true;  ///< the time of a step, too
  /// Called with what is being done and how much of it is, 0 to 1.
  std::function<void(const std::string& stage, double done)> progress;
  /// Called at every instant of output of the runs, if given. What it throws ends the study.
  std::function<void()> attend;
};

struct InertiaStudy {
  /// A term, neglected in all bodies.
  struct Term {
    InertiaTerm term{};
    double estimate = 0;  ///< before any run without it: its share in what inertia does in a step
    double error = 0;     ///< of the run without it; infinite where that fails
    double cost = 1;      ///< CPU of a step, by that with all terms
  };
  struct Body {
    std::string name;
    int index = -1;  ///< of the model
    std::array<double, inertia_term_count> estimates{};
    InertiaTerms neglected;  ///< the choice
  };
  std::vector<Term> terms;
  std::vector<Body> bodies;
  std::vector<std::string> outputs;  ///< that were compared
  std::string worst;                 ///< of these, with the choice
  double error = 0;                  ///< likewise
  double cost = 1;                   ///< of the choice
  double cost_without_any = 1;       ///< with all terms neglected: no choice gains more
  int runs = 0;
  std::vector<std::string> notes;  ///< on what else the errors and times have in them
};

/// Runs the model with all terms, and estimates at instants of the run what each does: the residual with it
/// less that without, through the matrix of a step, by what all of inertia does. That is no bound of what an
/// output is off by; it gives the order in which terms of bodies are neglected, as many as runs with them
/// permit. Where no run can be made with any of them neglected the choice is empty.
/// Throws std::invalid_argument for a model without flexible bodies, with inertia: projection, or where no
/// output moves; UnknownName for outputs; std::runtime_error when the run with all terms fails.
InertiaStudy study_inertia(const spec::Model& model, const InertiaStudyOptions& options);

/// The model without the terms that the study chose.
spec::Model with_choice(const spec::Model& model, const InertiaStudy& study);

/// A model file that includes `model_file`, of the studied model, and neglects these terms, as one whole:
/// until it is written an older file stands. `settings`: values of parameters, NAME=VALUE, with which the
/// model was loaded; the file names them in a comment. Throws std::runtime_error, with the path, when it
/// cannot be written.
void write_choice(const InertiaStudy& study, const std::string& model_file, const std::string& path,
                  const std::vector<std::string>& settings = {});

}  // namespace mimbre
