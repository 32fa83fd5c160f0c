#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "dynamics/relative/system.h"
#include "integrate/initial.h"
#include "math/once/decompositions.h"
#include "mimbre/simulation.h"
#include "simulation/start/assembly.h"
#include "support/models.h"

/// What is not given of a start is what moves least.
namespace mimbre::test::least_start_test {
namespace {

/// A crank drives a slider over a rod that may turn about itself. Of the speeds that its own permits the
/// crank train has those with the least sum of squares, a length of the mechanism's size for a radian: no
/// motion that is left free makes that sum smaller.
TEST(LeastStart, SpeedsThatAreNotGivenAreTheLeast) {
  const auto model = model_of(R"(
bodies:
  crank: {mass: 0.5, com: [0, 0.05, 0.05], inertia: [0.002, 0.002, 0.0005]}
  rod: {mass: 0.8, com: [0.3, 0.05, 0.1], inertia: [0.004, 0.03, 0.03]}
  slider: {mass: 1, com: [0.65, 0.02, 0], inertia: [0.004, 0.005, 0.005]}
joints:
  main: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [1, 0, 0], velocity: 4}
  pin: {type: spherical, between: [crank, rod], at: [0, 0.1, 0.15]}
  knuckle: {type: spherical, between: [rod, slider], at: [0.6, 0.05, 0]}
  guide: {type: cylindrical, between: [ground, slider], at: [0.6, 0, 0], axis: [1, 0.3, 0]}
)");
  const Compiled& m = model->compiled();
  relative::RelativeSystem system(m);
  const State s = assembled_state(m, system);
  Eigen::VectorXd scale(m.velocities);
  int given = -1;
  for (const BodyData& b : m.bodies)
    for (int k = 0; k < b.joint_velocities; ++k) {
      scale[b.v + k] = is_angle(b.joint, k) ? 1 : m.length_scale;
      if (m.spec().joints[static_cast<std::size_t>(b.joint_spec)].name == "main") given = b.v + k;
    }
  ASSERT_GE(given, 0);
  EXPECT_EQ(s.v[given], 4);
  EXPECT_NE(m.length_scale, 1);
  Eigen::MatrixXd kept(m.equations + 1, m.velocities);
  kept << dense_jacobian(system, 0, s.q), Eigen::RowVectorXd::Unit(m.velocities, given);
  EXPECT_LT((kept.topRows(m.equations) * s.v).norm(), 1e-12);
  const Eigen::MatrixXd free = null_space(kept, 1e-12);
  ASSERT_EQ(free.cols(), 2);
  const Eigen::VectorXd squares = s.v.cwiseQuotient(scale.cwiseAbs2());
  EXPECT_LT((free.transpose() * squares).norm(), 1e-12 * squares.norm());
}

/// A bar is built in at both ends, one of which is off by δ across it: it bends as a bar does whose ends are
/// held, with the energy 6 EI δ²/L³, and not in higher modes.
TEST(LeastStart, ModesCloseALoopWithTheLeastEnergy) {
  const double E = 7e10, I = M_PI * std::pow(0.01, 4) / 64, length = 1.2, off = 0.002;
  const auto model = model_of(R"(
materials: {alloy: {young: 7e10, poisson: 0.3, density: 2700}}
sections: {rod: {type: round, diameter: 0.01}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: alloy
      section: rod
      nodes: {root: [0, 0, 0], tip: [1.2, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 10}}
      clamped: [root]
      static_modes: [{node: tip, all: true}]
      dynamic_modes: 8
frames:
  root: {body: bar, at: [0, 0, 0]}
  tip: {body: bar, at: [1.2, 0, 0]}
  wall: {body: ground, at: [0, 0, 0]}
  peg: {body: ground, at: [1.2, 0, 0.002]}
joints:
  root: {type: fixed, between: [wall, root]}
  tip: {type: fixed, between: [peg, tip], cut: always}
)");
  const Simulation s(model);
  const double least = 6 * E * I * off * off / std::pow(length, 3);
  EXPECT_NEAR(s.energy().elastic, least, 1e-6 * least);
}

}  // namespace
}  // namespace mimbre::test::least_start_test
