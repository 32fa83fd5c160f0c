#include "signals/block_models.h"

#include <fmt/format.h>

#include "mimbre/diagnostics.h"
#include "support/models.h"

namespace mimbre::test {

std::string slider(const std::string& more, double step, double end) {
  return fmt::format(R"y(
bodies:
  mass: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints:
  guide: {{type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [1, 0, 0]}}
outputs:
  - {{name: place, joint: guide}}
  - {{name: speed, joint_velocity: guide}}
  - {{name: rise, joint_acceleration: guide}}
simulation: {{step: {}, end: {}}}
{})y",
                     step, end, more);
}

std::string refusal_of(const std::string& text) {
  try {
    model_of(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace mimbre::test
