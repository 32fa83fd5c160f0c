#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "compile/compiled.h"

/// Force elements with internal states, as linear systems in continuous time.
namespace mimbre::linear {

/// A force element about a point, with what it sees s (its measure x, the rate v, its surroundings, its
/// arguments, one below the other) and those of its states z that count:
///
///     δforce = force_by_seen δs + force_by_states δz,    δż = rate_by_seen δs + rate_by_states δz.
///
/// Laws integrate their states over a step of length h by themselves (forces/element.h). Their rates are the
/// limit (z(h) − z(0))/h, h → 0, of the law over numbers with exact derivatives, extrapolated from five steps
/// (Richardson). A state whose new value depends on no old one (the place at the start of the step) is a
/// function of what is seen; a state on which neither the force nor another state depends is left out.
struct LinearElement {
  int element = -1;         ///< of the model
  std::vector<int> states;  ///< those that count, from ElementData::states on
  Eigen::VectorXd force;    ///< count × 1
  Eigen::VectorXd rate;     ///< ż at the point
  Eigen::MatrixXd force_by_seen, force_by_states, rate_by_seen, rate_by_states;
  bool by_differences = false;  ///< a law of the user, which has no derivatives by signals and states
  bool settled = true;          ///< the extrapolation has converged
};

/// What an element sees at the point: x, v (count each), surroundings, arguments.
struct SeenByElement {
  Eigen::VectorXd values;
  int count = 0, surroundings = 0, arguments = 0;
};

/// Whether an element needs to be treated so: it has states, or its law is the user's.
bool needs_linear_element(const ElementData& e);

/// `slots`: values of all signals; `states`: the element's; `pace`: 1/s, how fast the mechanism moves, with
/// which the search for a good step begins.
LinearElement linear_element(const Compiled& model, int element, double time, const SeenByElement& seen,
                             const std::vector<double>& slots, const double* states, double pace);

}  // namespace mimbre::linear
