#include "simulation/explain.h"

#include <fmt/format.h>

#include <algorithm>

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

std::string explain_imbalance(const Compiled& model, const natural::NaturalSystem* natural,
                              const StaticsStatus& status) {
  return fmt::format(
      "no static equilibrium was found: unbalanced force {:.3g}, the largest in {} (does anything hold it?), "
      "constraints off by {:.3g} after {} iterations",
      status.residual, coordinate_name(model, natural, status.coordinate), status.violation,
      status.iterations);
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
  std::string joints;
  for (std::size_t k = 0; k < std::min<std::size_t>(r.nearly_joints.size(), 8); ++k)
    joints += fmt::format("{}'{}'", k > 0 ? ", " : "", r.nearly_joints[k]);
  return fmt::format(
      "constraints are nearly redundant: axes or points of joints {}{} are off by so little that the "
      "mechanism "
      "may lock, and their reactions are arbitrary; give them exactly, or free a coordinate of one of them",
      joints, r.nearly_joints.size() > 8 ? ", …" : "");
}

}  // namespace mimbre
