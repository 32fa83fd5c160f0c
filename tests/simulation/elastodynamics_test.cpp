#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/rigid_response.h"
#include "mimbre/diagnostics.h"
#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// Linear elastodynamics: the mechanism moves as if the body were rigid, and bends it.
namespace mimbre::test::elastodynamics_test {
namespace {

spec::Model slider_crank(const std::string& speed, bool elastodynamic, const std::string& rod = "flexible") {
  spec::Model model = example("slider-crank/slider-crank.yaml", {{"speed", speed}, {"rod", rod}})->spec();
  for (spec::Body& body : model.bodies) body.elastodynamic = elastodynamic && body.flexible;
  return model;
}
int rod_of(const spec::Model& model) {
  for (std::size_t k = 0; k < model.bodies.size(); ++k)
    if (model.bodies[k].name == "rod") return static_cast<int>(k);
  return -1;
}

/// The same forces on the same modes, integrated by another program.
TEST(Elastodynamics, BendsAsTheForcesOfTheRigidMechanismSay) {
  // With the modes that the joints leave.
  const spec::Model model = Model::compile(slider_crank("60", true))->spec();
  const int rod = rod_of(model);
  double before = 0;
  for (const double step : {1e-5, 5e-6}) {
    ModeSelectionOptions options;
    options.end = 0.1;
    options.run.step = step;
    spec::Model sampled = model;
    sampled.simulation.step = step;
    sampled.simulation.output_interval = step;
    const AmplitudeHistory found =
        amplitudes_with(sampled, rod, *model.bodies[static_cast<std::size_t>(rod)].flexible, options);
    spec::Model plain = sampled;
    plain.bodies[static_cast<std::size_t>(rod)].elastodynamic = false;
    const AmplitudeHistory expected = rigid_response(plain, rod, options);
    ASSERT_EQ(found.amplitudes.cols(), expected.amplitudes.cols());
    const double error = (found.amplitudes - expected.amplitudes).norm() / expected.amplitudes.norm();
    EXPECT_LT(error, step == 1e-5 ? 1e-4 : 3e-5);
    if (before > 0) {
      EXPECT_GT(before / error, 3);
    }
    before = error;
  }
}

/// At the rod's own frequency the bend grows to r/(πζ), as that of its first mode under the inertia of the
/// rigid motion: 2/π r Ω² sin Ωt. In truth the axial force of the slider takes it out of resonance.
TEST(Elastodynamics, ResonatesAtTheRodsFrequency) {
  const double r = 0.003, length = 0.3, diameter = 0.006;
  const double omega =
      std::pow(std::numbers::pi / length, 2) * std::sqrt(2.1e11 * diameter * diameter / 16 / 7850);
  const double zeta = 1e-5 / 2 * omega, turn = 2 * std::numbers::pi / omega;
  const auto bend = [&](const std::string& approach) {
    Simulation s(example("slider-crank/slider-crank.yaml", {{"approach", approach},
                                                            {"crank", fmt::format("{}", r)},
                                                            {"speed", fmt::format("{:.17g}", omega)},
                                                            {"interval", fmt::format("{:.17g}", turn / 40)},
                                                            {"step", fmt::format("{:.17g}", turn / 200)}}));
    double largest = 0;
    for (int k = 0; k < 30 * 200; ++k) {
      EXPECT_TRUE(s.step().ok());
      if (k >= 29 * 200) largest = std::max(largest, std::abs(s.value(s.channel("rod.deflection"))));
    }
    return largest;
  };
  const double grown = r / (std::numbers::pi * zeta) * (1 - std::exp(-zeta * omega * 29.5 * turn));
  EXPECT_NEAR(bend("elastodynamics"), grown, 0.02 * grown);
  EXPECT_LT(bend("geometric_stiffness"), 0.3 * grown);
}

/// A cantilever with a force at its tip, beside so many pendulums that large mechanisms are searched
/// otherwise.
TEST(Elastodynamics, RestsAlikeInSmallAndLargeMechanisms) {
  const auto beam = [](int pendulums) {
    return model_of(R"(
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {round: {type: round, diameter: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexibility: elastodynamics
    flexible:
      material: steel
      section: round
      nodes: {hinge: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: hinge, to: tip, elements: 6}}
      planar: [0, 1, 0]
      clamped: [hinge]
      static_modes: [{node: tip, along: [0, 0, 1]}]
      dynamic_modes: 2
  link$i: {for: {i: {from: 1, to: )" +
                    std::to_string(pendulums) +
                    R"(}}, mass: 0.1, com: [0, $i, 0], inertia: [1e-3, 1e-3, 1e-3]}
joints:
  h$i: {for: {i: {from: 1, to: )" +
                    std::to_string(pendulums) +
                    R"(}}, type: revolute, between: [ground, link$i], at: [0, $i, 0.1], axis: [0, 1, 0]}
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 1000}}
loads: {p: {on: bar.tip, force: [0, 0, -50]}}
outputs: [{name: bent, deflection: bar.tip, along: [0, 0, 1]}]
)");
  };
  const double few = static_equilibrium(beam(3)).values[0];
  EXPECT_LT(few, -0.01);  // 50 N bend the bar by 10.1 mm
  EXPECT_NEAR(static_equilibrium(beam(200)).values[0], few, 1e-9);
  RunOptions natural;
  natural.formulation = spec::Simulation::Formulation::natural;
  EXPECT_THROW(static_equilibrium(beam(3), natural), InputError);
}

/// The rigid mechanism and the one with the body that only bends, all the way.
TEST(Elastodynamics, MovesAsIfRigid) {
  RunOptions options;
  options.step = 1e-4;
  Simulation bending(Model::compile(slider_crank("60", true)), options),
      rigid(Model::compile(slider_crank("60", false, "rigid")), options);
  const auto place = bending.body("slider"), other = rigid.body("slider");
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(bending.step().ok());
    ASSERT_TRUE(rigid.step().ok());
    // The example's rigid rod has another inertia about its axis, which does not turn.
    EXPECT_LT((bending.pose(place).position - rigid.pose(other).position).norm(), 1e-8);
  }
  for (const std::string& warning : bending.warnings())
    EXPECT_THAT(warning, testing::HasSubstr("linear theory"));
}

/// The largest distance of the rod's middle from the line between its ends, from above to below.
double bend(const std::string& speed, bool elastodynamic, double turns) {
  spec::Model model = slider_crank(speed, elastodynamic);
  model.gravity.setZero();
  RunOptions options;
  const double end = turns * 2 * std::numbers::pi / std::stod(speed);
  options.step = end / 8000;
  Simulation simulation(Model::compile(model), options);
  const int rod = rod_of(model);
  const ReducedBody& body = *simulation.model().spec().bodies[static_cast<std::size_t>(rod)].flexible;
  const auto deflection = [&](const char* node) -> Eigen::RowVectorXd {
    return body.frames[static_cast<std::size_t>(body.find_frame(node))].X.row(2);
  };
  const Eigen::RowVectorXd sag = deflection("middle") - 0.5 * deflection("small_end");
  ResultsRow row;
  double least = 0, most = 0;
  for (int k = 0; k < 8000; ++k) {
    EXPECT_TRUE(simulation.step().ok());
    simulation.picture(row);
    if (k < 4000) continue;  // vibrations of the start die away
    least = std::min(least, sag.dot(row.modes));
    most = std::max(most, sag.dot(row.modes));
  }
  return most - least;
}

/// Slow, the rod bends as in its floating frame; the faster, the more do its tension and its turning change
/// how it vibrates, of which elastodynamics knows nothing.
TEST(Elastodynamics, IsTheLimitOfASlowMechanism) {
  double before = INFINITY;
  for (const char* speed : {"120", "60", "30", "15"}) {
    const double off = std::abs(bend(speed, true, 8) / bend(speed, false, 8) - 1);
    EXPECT_LT(off, before) << speed;
    before = off;
  }
  EXPECT_LT(before, 0.02);
}

/// Distances of the rod's middle from the line between its ends, once the vibrations of the start have gone;
/// with `stiffer` times the stiffness and the same damping ratio.
std::vector<double> sags(const std::string& approach, double stiffer) {
  const double root = std::sqrt(stiffer);
  RunOptions options;
  options.step = 4e-5 / root;
  options.tolerance = 1e-10;
  Simulation simulation(
      example("slider-crank/slider-crank.yaml", {{"approach", approach},
                                                 {"young", fmt::format("{}", 2.1e11 * stiffer)},
                                                 {"damping", fmt::format("{}", 2e-4 / root)}}),
      options);
  const spec::Model& model = simulation.model().spec();
  const ReducedBody& body = *model.bodies[static_cast<std::size_t>(rod_of(model))].flexible;
  const auto deflection = [&](const char* node) -> Eigen::RowVectorXd {
    return body.frames[static_cast<std::size_t>(body.find_frame(node))].X.row(2);
  };
  const Eigen::RowVectorXd sag = deflection("middle") - 0.5 * deflection("small_end");
  ResultsRow row;
  std::vector<double> out;
  for (int k = 1; k <= 250; ++k) {
    while (simulation.time() < 0.001 * k - 1e-9) EXPECT_TRUE(simulation.step().ok());
    simulation.picture(row);
    if (k > 130) out.push_back(sag.dot(row.modes));
  }
  return out;
}

/// What elastodynamics neglects (the axial force over the buckling load, and what turning does to the
/// stiffness) goes with the compliance: of first order, as a share of the bend.
TEST(Elastodynamics, ConvergesWithTheCompliance) {
  double shares[2];
  for (const int k : {0, 1}) {
    const double stiffer = k == 0 ? 1 : 16;
    const std::vector<double> found = sags("elastodynamics", stiffer),
                              exact = sags("geometric_stiffness", stiffer);
    double off = 0, size = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      off = std::max(off, std::abs(found[i] - exact[i]));
      size = std::max(size, std::abs(exact[i]));
    }
    shares[k] = off / size;
  }
  EXPECT_NEAR(shares[0], 0.021, 0.002);
  EXPECT_NEAR(std::log2(shares[0] / shares[1]) / 4, 1, 0.05);
}

const std::string bar = R"(
materials: {alloy: {young: 7e10, poisson: 0.3, density: 2700}}
sections: {strip: {type: rectangle, height: 0.01, width: 0.01}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: alloy
      section: strip
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {all: {from: root, to: tip, elements: 4}}
      clamped: [root]
      static_modes: [{node: tip, all: true}]
)";

/// The bar on a spring of turning, `more` sections behind.
std::string bar_on_spring(const std::string& more) {
  return bar + R"(
    flexibility: elastodynamics
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 200, zero: 0}}
outputs:
  - {name: place, position: bar.tip, component: z}
  - {name: bend, deflection: bar.tip, along: [0, 0, 1]}
simulation: {step: 1e-3, end: 0.1}
)" + more;
}

/// What is drawn and listed has the deflection, whether or not something acts there.
TEST(Elastodynamics, PlacesShowTheDeflection) {
  const std::string push = "loads: {push: {on: bar.tip, force: [0, 0, 1e-12]}}\n";
  Simulation free(model_of(bar_on_spring(""))), loaded(model_of(bar_on_spring(push)));
  ResultsRow a, b;
  double most = 0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(free.step().ok());
    ASSERT_TRUE(loaded.step().ok());
    free.sample(a);
    loaded.sample(b);
    EXPECT_NEAR(a.channels[0], b.channels[0], 1e-9);
    const spec::Pose pose = free.pose(free.body("bar"));
    const double rigid = pose.position.z() + pose.rotation(2, 0), bend = a.channels[1];
    EXPECT_NEAR(a.channels[0], rigid + pose.rotation(2, 2) * bend, 1e-4 * std::abs(bend) + 1e-12);
    most = std::max(most, std::abs(bend));
  }
  EXPECT_GT(most, 1e-4);
}

/// A slider-crank that lies flat, at rest; its rod sags.
std::shared_ptr<const Model> flat_slider_crank(const std::string& approach, const std::string& first,
                                               const std::string& second, const std::string& modes) {
  return model_of(fmt::format(R"(
gravity: [0, 0, -9.81]
materials: {{m: {{young: 7e10, poisson: 0.3, density: 2700}}}}
sections: {{s: {{type: rectangle, width: 0.02, height: 0.012}}}}
bodies:
  crank: {{mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}}
  slider: {{mass: 1, com: [0.7, 0, 0], inertia: [0.01, 0.01, 0.01]}}
  rod:
    frame: {{at: [0.15, 0.15, 0], x: [0.55, -0.15, 0], y: [0.15, 0.55, 0]}}
    flexibility: {}
    flexible:
      material: m
      section: s
      nodes: {{a: [0.15, 0.15, 0], m: [0.425, 0.075, 0], t: [0.7, 0, 0]}}
      bars:
        p: {{from: a, to: m, elements: 4, y: [0.15, 0.55, 0]}}
        q: {{from: m, to: t, elements: 4, y: [0.15, 0.55, 0]}}
      clamped: [a]
      static_modes: [{}]
joints:
  shaft: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 0, 1], drive: {{position: "0"}}}}
  pin: {{type: {}, between: [crank, rod], at: [0.15, 0.15, 0]}}
  end: {{type: {}, between: [rod, slider], at: [0.7, 0, 0]}}
  guide: {{type: prismatic, between: [ground, slider], at: [0.7, 0, 0], axis: [1, 0, 0]}}
outputs:
  - {{name: at_pin, position: rod.a, component: z}}
  - {{name: middle, position: rod.m, component: z}}
  - {{name: at_end, position: rod.t, component: z}}
)",
                              approach, modes, first, second));
}

/// Where redundant joints bend the body, the rigid mechanism does not know how far, and the run says so.
TEST(Elastodynamics, SaysWhatRedundantJointsLeaveOpen) {
  const std::string all = "{node: t, all: true}, {node: m, all: true}",
                    across = "{node: m, along: [0.15, 0.55, 0]}", hinge = "revolute, axis: [0, 0, 1]",
                    universal = "universal, axis: [0, 0, 1], axis2: [0.15, 0.55, 0]";
  const auto sag = [&](const std::string& approach, const std::string& first, const std::string& second) {
    const Eigen::VectorXd z = static_equilibrium(flat_slider_crank(approach, first, second, all)).values;
    return z[1] - (z[0] + z[2]) / 2;
  };
  const auto warned = [&](const std::string& first, const std::string& second, const std::string& modes) {
    for (const std::string& w :
         Simulation(flat_slider_crank("elastodynamics", first, second, modes)).warnings())
      if (w.find("body 'rod' bends by elastodynamics under reactions") != std::string::npos) return w;
    return std::string();
  };
  // The pin holds the rod's end; so does the guide, by the ball.
  const double held = sag("floating_frame", hinge, "spherical");
  EXPECT_GT(std::abs(sag("elastodynamics", hinge, "spherical") - held), 0.5 * std::abs(held));
  EXPECT_THAT(warned(hinge, "spherical", all), testing::HasSubstr("'pin', 'end', 'guide'"));
  // Each reaction follows from the weights.
  const double carried = sag("floating_frame", universal, "spherical");
  EXPECT_NEAR(sag("elastodynamics", universal, "spherical"), carried, 1e-3 * std::abs(carried));
  EXPECT_EQ(warned(universal, "spherical", all), "");
  // Hinges repeat each other too, but what they leave open does not bend a rod in the plane.
  EXPECT_EQ(warned(hinge, hinge, across), "");
  EXPECT_NE(warned(hinge, hinge, all), "");
}

TEST(Elastodynamics, MayNotBeSeenWithinAStep) {
  for (const std::string sensor :
       {"deflection: bar.tip, along: [0, 0, 1]", "modal_amplitude: bar, component: 1"}) {
    const std::string lift =
        "signals: {bend_now: {" + sensor + "}}\nactuators: {lift: {joint: hinge, torque: bend_now}}\n";
    try {
      model_of(bar_on_spring(lift));
      ADD_FAILURE() << sensor;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(),
                  testing::HasSubstr("bends by elastodynamics, of which the mechanism has no part"));
    }
  }
}

/// Where a drive knows no reaction, and the body does not turn, nothing is left out.
TEST(Elastodynamics, OfAPushedBodyIsExact) {
  spec::Model model = model_of(bar + R"(
gravity: [0, 0, -9.81]
joints:
  push: {type: prismatic, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: 0.01*sin(20*t)
}
}
loads:
  pull: {on: bar.tip, force: [0, 1, 2], scale: sin(30*t)}
simulation: {step: 1e-3, end: 0.2}
)")
                          ->spec();
  RunOptions options;
  options.energy_tolerance = 1;  // the same steps
  options.tolerance = 1e-12;
  Simulation frame(Model::compile(model), options);
  model.bodies[0].elastodynamic = true;
  Simulation elastodynamic(Model::compile(model), options);
  double largest = 0, off = 0;
  ResultsRow x, y;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(frame.step().ok());
    ASSERT_TRUE(elastodynamic.step().ok());
    frame.picture(x);
    elastodynamic.picture(y);
    largest = std::max(largest, x.modes.norm());
    off = std::max(off, (x.modes - y.modes).norm());
  }
  EXPECT_GT(largest, 1e-3);
  EXPECT_LT(off, 1e-9 * largest);
}

TEST(Elastodynamics, RefusesWhatItCannotFollow) {
  const auto model = Model::compile(slider_crank("30", true));
  RunOptions natural, explicit_rule, index1;
  natural.formulation = spec::Simulation::Formulation::natural;
  explicit_rule.integrator = spec::Simulation::Integrator::rk4;
  index1.formalism = spec::Simulation::Formalism::index1;
  for (const auto& [options, needs] :
       {std::pair(natural, "formulation: relative"), std::pair(explicit_rule, "generalized_alpha"),
        std::pair(index1, "formalism: index3")}) {
    try {
      Simulation refused(model, options);
      ADD_FAILURE() << needs;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(needs));
      EXPECT_THAT(error.what(), testing::HasSubstr("rod"));
    }
  }
}

}  // namespace
}  // namespace mimbre::test::elastodynamics_test
