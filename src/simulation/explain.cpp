#include "simulation/explain.h"

#include <fmt/format.h>

#include "simulation/names.h"

namespace mimbre {

std::string explain(const Compiled& model, const natural::NaturalSystem* natural, const StepReport& r,
                    double t) {
  const std::string where = coordinate_name(model, natural, r.coordinate);
  switch (r.code) {
    case StepReport::Code::ok:
      return "ok";
    case StepReport::Code::not_converged:
      return fmt::format(
          "the step to t = {:.6g} s did not converge in {} iterations, the largest correction in {}; "
          "a smaller step or an integrator with more damping (smaller rho) may help",
          t, r.iterations, where);
    case StepReport::Code::not_finite:
      return fmt::format("a number is not finite in the step to t = {:.6g} s, first in {}", t, where);
    case StepReport::Code::drifted:
      return fmt::format(
          "the constraints have come apart in the step to t = {:.6g} s: {} is off by {:.3g} m; this "
          "formalism "
          "does not hold them, take `index3`, a stabilised one or a smaller step",
          t, equation_name(model, natural, r.equation), r.position_violation);
    case StepReport::Code::singular:
      if (r.equation >= 0)
        return fmt::format(
            "the constraints are dependent in the step to t = {:.6g} s, at {}: a singular position, or a "
            "joint "
            "too many; take a formalism that bears it (`index3`, `penalty`, `index1_augmented`)",
            t, equation_name(model, natural, r.equation));
      return fmt::format(
          "the matrix of the step to t = {:.6g} s is singular at {}: is there a body without mass that "
          "nothing holds?",
          t, where);
  }
  return {};
}

}  // namespace mimbre
