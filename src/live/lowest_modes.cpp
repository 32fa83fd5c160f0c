#include "live/lowest_modes.h"

#include <algorithm>
#include <memory>

#include "math/once/decompositions.h"
#include "mimbre/real_time_plan.h"
#include "reduction/bases/project_modes.h"
#include "spec/output_kind.h"

namespace mimbre {

spec::Model with_lowest_modes(spec::Model model, int most) {
  bool changed = false;
  for (spec::Body& body : model.bodies) {
    if (!body.flexible || !is_linear(*body.flexible) || body.flexible->modes <= most) continue;
    const EigenPairs modes = symmetric_eigen(body.flexible->stiffness, body.flexible->mass_matrix);
    if (!modes.ok) continue;
    body.flexible = std::make_shared<const ReducedBody>(
        project_modes(*body.flexible, modes.vectors.leftCols(std::max(most, 1))));
    changed = true;
  }
  if (changed) std::erase_if(model.outputs, [](const spec::Output& o) { return output_info(o).modes; });
  return model;
}

}  // namespace mimbre
