#include "support/smooth_mechanisms.h"

#include "support/models.h"
#include "support/simulate.h"

namespace mimbre::test {

void PrintTo(const SmoothMechanism& mechanism, std::ostream* out) { *out << mechanism.name; }

RunOptions options_of(spec::Simulation::Integrator rule, double step, double accuracy) {
  RunOptions o;
  o.integrator = rule;
  o.step = step;
  if (accuracy > 0)
    o.accuracy = accuracy;
  else
    o.substeps = 1;
  return o;
}

Eigen::VectorXd run_with(const std::shared_ptr<const Model>& model, const RunOptions& options, double end) {
  Simulation simulation(model, options);
  run_to(simulation, end);
  const Simulation::Snapshot s = simulation.save();
  Eigen::VectorXd all(s.q.size() + s.v.size());
  all << s.q, s.v;
  return all;
}

const std::vector<SmoothMechanism>& smooth_mechanisms() {
  static const std::vector<SmoothMechanism> all{
      {"pendulum", R"(
bodies:
  bar: {mass: 2, com: [0.5, 0, 0], inertia: [0.001, 0.2, 0.2]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
)",
       1.2, 80, 6, 20},
      {"double_pendulum", R"(
bodies:
  one: {mass: 2, com: [0.5, 0, 0], inertia: [0.001, 0.2, 0.2]}
  two: {mass: 1, com: [1.3, 0, 0], inertia: [0.001, 0.05, 0.05]}
joints:
  hinge: {type: revolute, between: [ground, one], at: [0, 0, 0], axis: [0, 1, 0]}
  knee: {type: universal, between: [one, two], at: [1, 0, 0], axis: [0, 1, 0], axis2: [0, 0, 1], velocity: [0.3, 1]}
)",
       1.2, 80, 24, 40},
      {"top", R"(
bodies:
  top: {mass: 3, com: [0.1, 0.05, 0.4], inertia: [0.1, 0.12, 0.06]}
joints:
  ball: {type: spherical, between: [ground, top], at: [0, 0, 0], velocity: [0.5, 1, 9]}
)",
       0.6, 80, 12, 20},
      {"tumbling", R"(
gravity: [0, 0, 0]
bodies:
  brick: {mass: 2, com: [0.1, 0, 0], inertia: [0.1, 0.2, 0.26]}
joints:
  free: {type: floating, between: [ground, brick], velocity: [0.3, -0.2, 0.1, 0.05, 3, 0.5]}
)",
       2.4, 80, 12, 40},
      {"springs", R"(
bodies:
  one: {mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
  two: {mass: 1, com: [1.3, 0, 0], inertia: [0.01, 0.05, 0.05]}
joints:
  hinge: {type: spherical, between: [ground, one], at: [0, 0, 0]}
  slide: {type: cylindrical, between: [one, two], at: [1, 0, 0], axis: [1, 0, 0], velocity: [0.2, 1]}
springs:
  pull: {between: [ground, two], at: [[1, 0.4, 1], [1.4, 0, 0]], elastic: {stiffness: 20, zero: 0.5}, damping: 0.3}
)",
       1.2, 80, 6, 40},
      {"four_bar", four_bar_text({{"crank", ", velocity: 6"}}), 0.1, 40, 6, 10},
  };
  return all;
}

}  // namespace mimbre::test
