#include <gtest/gtest.h>

#include <array>
#include <string>

#include "support/models.h"
#include "support/simulate.h"

namespace mimbre::test::andrews_test {
namespace {

/// Andrews' squeezing mechanism: seven bars and three loops in a plane, driven from rest to 1140 rad/s in
/// 0.03 s (Hairer and Wanner 1996, VII.7; data and solution from the test set for initial
/// value problems, Mazzia and Magherini 2008). Places are those of the given angles at the start.
const char* const mechanism = R"(
gravity: [0, 0, 0]
bodies:
  k1: {mass: 0.04325, com: [0.0009182485980307614, -5.674074562905483e-05, 0], inertia: [1.097e-06, 1.097e-06, 2.194e-06]}
  k2: {mass: 0.00365, com: [-0.0044914333599330725, 0.0002775362557942899, 0], inertia: [2.205e-07, 2.205e-07, 4.41e-07]}
  k3: {mass: 0.02373, com: [-0.018742186670315457, 0.020485106789073934, 0], inertia: [2.6275e-06, 2.6275e-06, 5.255e-06]}
  k4: {mass: 0.00706, com: [-0.030222939830158887, 0.012071182356663938, 0], inertia: [2.8335e-07, 2.8335e-07, 5.667e-07]}
  k5: {mass: 0.0705, com: [-0.05323682815570414, 0.016631847966616306, 0], inertia: [5.845e-06, 5.845e-06, 1.169e-05]}
  k6: {mass: 0.00706, com: [-0.028543268536783597, -0.010722254707252287, 0], inertia: [2.8335e-07, 2.8335e-07, 5.667e-07]}
  k7: {mass: 0.05498, com: [-0.059262402801791715, -0.010600698332712844, 0], inertia: [9.56e-06, 9.56e-06, 1.912e-05]}
joints:
  beta: {type: revolute, between: [ground, k1], at: [0, 0, 0], axis: [0, 0, 1]}
  theta: {type: revolute, between: [k1, k2], at: [0.006986674115451445, -0.0004317230645688955, 0], axis: [0, 0, 1]}
  gamma: {type: revolute, between: [ground, k3], at: [-0.03635, 0.03273, 0], axis: [0, 0, 1]}
  delta: {type: revolute, between: [ground, k5], at: [-0.06934, -0.00227, 0], axis: [0, 0, 1]}
  epsilon: {type: revolute, between: [ground, k7], at: [-0.06934, -0.00227, 0], axis: [0, 0, 1]}
  phi: {type: revolute, between: [k5, k4], at: [-0.03399720388583998, 0.01646197167499768, 0], axis: [0, 0, 1]}
  omega: {type: revolute, between: [k7, k6], at: [-0.03163313450740889, -0.015618868668304536, 0], axis: [0, 0, 1]}
  p3: {type: revolute, between: [k2, k3], at: [-0.020960022346354336, 0.0012951691937066864, 0], axis: [0, 0, 1]}
  p4: {type: revolute, between: [k2, k4], at: [-0.020960022346354336, 0.0012951691937066864, 0], axis: [0, 0, 1]}
  p6: {type: revolute, between: [k2, k6], at: [-0.020960022346354336, 0.0012951691937066864, 0], axis: [0, 0, 1]}
springs:
  spring: {between: [ground, k3], at: [[0.014, 0.072, 0], [-0.010472393888814623, 0.025357788530275253, 0]], elastic: {stiffness: 4530, zero: 0.07785}}
actuators:
  motor: {joint: beta, torque: 0.033}
)";

struct Angle {
  const char* joint;
  double start, end;  ///< at 0 and at 0.03 s, rad
};
constexpr std::array<Angle, 7> angles{{{"beta", -0.0617138900142764496, 15.81077119629904},
                                       {"theta", 0, -15.75637105984298},
                                       {"gamma", 0.455279819163070380, 0.04082224013073101},
                                       {"phi", 0.222668390165885885, -0.5347301163226948},
                                       {"delta", 0.487364979543842550, 0.5244099658805304},
                                       {"omega", -0.222668390165885885, 0.5347301163226948},
                                       {"epsilon", 1.23054744454982119, 1.048080741042263}}};

/// Ten digits of the published solution, of the largest angles 15.8 rad, in both formulations.
TEST(Andrews, MatchesThePublishedSolutionToTenDigits) {
  std::string text = mechanism;
  text += "outputs:\n";
  for (const Angle& angle : angles)
    text += std::string("  - {name: ") + angle.joint + ", joint: " + angle.joint + "}\n";
  const auto model = model_of(text);
  using Integrator = spec::Simulation::Integrator;
  for (const Formulation formulation : {Formulation::relative, Formulation::natural})
    for (const Integrator integrator : {Integrator::dopri853, Integrator::radau}) {
      RunOptions options;
      options.formulation = formulation;
      options.integrator = integrator;
      options.accuracy = 1e-12;
      options.step = 1e-3;
      Simulation simulation(model, options);
      run_to(simulation, 0.03);
      for (const Angle& angle : angles)
        EXPECT_NEAR(channel(simulation, angle.joint), angle.end - angle.start, 1.6e-9) << angle.joint;
    }
}

}  // namespace
}  // namespace mimbre::test::andrews_test
