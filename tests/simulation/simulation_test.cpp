#include "mimbre/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/models.h"

namespace mimbre::test::simulation_test {
namespace {

void step(Simulation& s, int count) {
  for (int k = 0; k < count; ++k) {
    const StepReport report = s.step();
    ASSERT_TRUE(report.ok()) << s.explain(report);
  }
}

/// Not nearly: exactly.
void expect_same_motion(const Simulation::Snapshot& a, const Simulation::Snapshot& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_TRUE(a.q == b.q);
  EXPECT_TRUE(a.v == b.v);
  EXPECT_TRUE(a.a == b.a);
  EXPECT_TRUE(a.algorithmic == b.algorithmic);
  EXPECT_TRUE(a.multipliers == b.multipliers);
}
void expect_same(const Simulation::Snapshot& a, const Simulation::Snapshot& b) {
  expect_same_motion(a, b);
  EXPECT_TRUE(a.marks == b.marks);
}

class SameBits : public testing::TestWithParam<const char*> {
 protected:
  std::shared_ptr<const Model> model() const { return example(GetParam()); }
};

TEST_P(SameBits, OfTwoRunsOfOneModel) {
  const auto m = model();
  Simulation a(m), b(m);
  expect_same(a.save(), b.save());
  step(a, 150);
  step(b, 150);
  expect_same(a.save(), b.save());
}

TEST_P(SameBits, OfTwoCompilations) {
  Simulation a(model()), b(model());
  step(a, 50);
  step(b, 50);
  expect_same(a.save(), b.save());
}

TEST_P(SameBits, AfterSavingAndRestoring) {
  const auto m = model();
  Simulation a(m);
  step(a, 60);
  const Simulation::Snapshot saved = a.save();
  step(a, 60);
  const Simulation::Snapshot end = a.save();
  a.restore(saved);
  expect_same(a.save(), saved);
  EXPECT_EQ(a.time(), saved.time);
  step(a, 60);
  expect_same(a.save(), end);
  // Also into another simulation that has been elsewhere.
  Simulation b(m);
  step(b, 7);
  b.restore(saved);
  step(b, 60);
  expect_same(b.save(), end);
}

/// Energies and warnings count anew, but the motion is the same.
TEST_P(SameBits, AfterRestarting) {
  const auto m = model();
  Simulation a(m), b(m);
  step(a, 60);
  const Simulation::Snapshot saved = a.save();
  step(a, 60);
  step(b, 7);
  b.restart(saved);
  step(b, 60);
  expect_same_motion(b.save(), a.save());
}

TEST_P(SameBits, WhetherOrNotRedundancyIsLookedFor) {
  const auto m = model();
  Simulation a(m), b(m);
  for (int k = 0; k < 60; ++k) {
    step(a, 1);
    step(b, 1);
    b.redundancy();
  }
  expect_same(a.save(), b.save());
}

TEST_P(SameBits, WhetherOrNotOutputsAreSampled) {
  const auto m = model();
  Simulation a(m), b(m);
  ResultsRow row;
  for (int k = 0; k < 40; ++k) {
    step(a, 1);
    step(b, 1);
    b.sample(row);
    b.degrees_of_freedom();
  }
  expect_same_motion(a.save(), b.save());
}

INSTANTIATE_TEST_SUITE_P(Examples, SameBits,
                         testing::Values("iltis/vehicle.yaml", "double-four-bar/mechanism.yaml",
                                         "slider-crank/slider-crank.yaml"),
                         [](const auto& row) {
                           const std::string name = row.param;
                           std::string word = name.substr(0, name.find('/'));
                           for (char& c : word)
                             if (c == '-') c = '_';
                           return word;
                         });

struct Rule {
  const char* name;
  spec::Simulation::Integrator integrator;
  spec::Simulation::Formulation formulation;

  friend void PrintTo(const Rule& rule, std::ostream* out) { *out << rule.name; }
};

class VehicleOnStairs : public testing::TestWithParam<Rule> {};

/// Up to the stairs and down them: the wheels leave the road and come back to it, all of which changes what
/// is in the factorised matrix.
TEST_P(VehicleOnStairs, GoesOnWithTheSameBitsAfterRestoring) {
  const auto m = example("iltis/vehicle.yaml");
  RunOptions options;
  options.integrator = GetParam().integrator;
  options.formulation = GetParam().formulation;
  Simulation a(m, options);
  ASSERT_EQ(a.method().integrator, GetParam().integrator);
  ASSERT_EQ(a.method().formulation, GetParam().formulation);
  std::vector<Simulation::Snapshot> course;
  const int before = 200, stairs = 410, end = 480;
  for (int k = 0; k < end; ++k) {
    course.push_back(a.save());
    ASSERT_NO_FATAL_FAILURE(step(a, 1)) << k;
  }
  course.push_back(a.save());
  const auto expect_course = [&](Simulation& s, int from, int to) {
    s.restore(course[static_cast<std::size_t>(from)]);
    for (int k = from; k <= to; ++k) {
      const Simulation::Snapshot now = s.save(), &then = course[static_cast<std::size_t>(k)];
      ASSERT_EQ(now.time, then.time) << k;
      ASSERT_TRUE(now.q == then.q) << "step " << k << " after restoring " << from;
      ASSERT_TRUE(now.v == then.v) << "step " << k << " after restoring " << from;
      ASSERT_TRUE(now.a == then.a) << "step " << k << " after restoring " << from;
      ASSERT_TRUE(now.multipliers == then.multipliers) << "step " << k << " after restoring " << from;
      if (k == to) break;
      ASSERT_NO_FATAL_FAILURE(step(s, 1)) << k;
    }
  };
  Simulation b(m, options);
  expect_course(b, before, before + 20);
  for (int from = stairs; from < stairs + 20; from += 3) expect_course(b, from, from + 12);
  expect_course(b, stairs, end);
  expect_course(a, stairs + 10, end);
}

/// Outputs and the count of motions look at the system, which must not see it.
TEST_P(VehicleOnStairs, MovesAlikeWhetherOrNotItIsLookedAt) {
  const auto m = example("iltis/vehicle.yaml");
  RunOptions options;
  options.integrator = GetParam().integrator;
  options.formulation = GetParam().formulation;
  Simulation a(m, options), b(m, options);
  ResultsRow row;
  for (int k = 0; k < 480; ++k) {
    ASSERT_NO_FATAL_FAILURE(step(a, 1)) << k;
    ASSERT_NO_FATAL_FAILURE(step(b, 1)) << k;
    b.sample(row);
    b.degrees_of_freedom();
    ASSERT_TRUE(a.save().q == b.save().q) << "step " << k;
  }
  expect_same_motion(a.save(), b.save());
}

INSTANTIATE_TEST_SUITE_P(
    Rules, VehicleOnStairs, testing::ValuesIn([] {
      std::vector<Rule> all;
      for (const auto& [name, rule] :
           {std::pair{"Newmark", spec::Simulation::Integrator::newmark},
            std::pair{"Hht", spec::Simulation::Integrator::hht},
            std::pair{"GeneralizedAlpha", spec::Simulation::Integrator::generalized_alpha}})
        for (const auto formulation :
             {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural})
          all.push_back({name, rule, formulation});
      return all;
    }()),
    [](const auto& row) {
      return std::string(row.param.name) +
             (row.param.formulation == spec::Simulation::Formulation::natural ? "Natural" : "Relative");
    });

/// Also when what follows is an impact, whose step is repeated in parts.
TEST(Simulation, SameBitsAfterRestoringBeforeAnImpact) {
  const auto m = example("iltis/suspension.yaml", {{"elements", "4"}});
  Simulation a(m);
  step(a, 195);
  const Simulation::Snapshot saved = a.save();
  int parts = 1;
  const auto on = [&](Simulation& s) {
    for (int k = 0; k < 40; ++k) {
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok());
      parts = std::max(parts, report.substeps);
    }
  };
  on(a);
  EXPECT_GT(parts, 1);
  const Simulation::Snapshot end = a.save();
  a.restore(saved);
  on(a);
  expect_same(a.save(), end);
  Simulation b(m);
  b.restore(saved);
  on(b);
  expect_same(b.save(), end);
}

/// The road drops under the wheel: repeating that step in parts comes nearer to the exact motion.
TEST(Simulation, PartsMakeImpactsMoreAccurate) {
  const auto m = example("iltis/suspension.yaml", {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}});
  const auto heights = [&](double h, int substeps) {
    RunOptions options;
    options.step = h;
    options.rho = 0.3;
    options.substeps = substeps;
    Simulation s(m, options);
    Eigen::VectorXd z(100);
    ResultsRow row;
    const int every = static_cast<int>(std::lround(0.01 / h));
    step(s, 200 * every);
    for (Eigen::Index k = 0; k < z.size(); ++k) {
      step(s, every);
      s.sample(row);
      z[k] = row.channels[1];  // wheel.z
    }
    return z;
  };
  const Eigen::VectorXd exact = heights(0.0005, 1);
  const double in_parts = (heights(0.01, 4) - exact).lpNorm<1>() / 100,
               whole = (heights(0.01, 1) - exact).lpNorm<1>() / 100;
  EXPECT_LT(in_parts, 2e-3);
  EXPECT_LT(in_parts, whole);
}

/// The trapezoidal rule at 10 ms on high stairs goes wrong without any step failing: the energy tells.
TEST(Simulation, EnergyFedInByTheNumericsIsReported) {
  const auto m = example("iltis/vehicle.yaml",
                         {{"arms", "rigid"}, {"links", "rigid"}, {"rods", "rigid"}, {"stairs", "0.2"}});
  const auto warnings = [&](const RunOptions& options) {
    Simulation s(m, options);
    step(s, static_cast<int>(std::lround(8 / s.step_size())));
    return s.warnings();
  };
  RunOptions trapezoidal, fine;
  trapezoidal.integrator = spec::Simulation::Integrator::newmark;
  trapezoidal.xi = 0;
  EXPECT_THAT(warnings(trapezoidal), testing::Not(testing::IsEmpty()));
  fine.step = 0.001;
  fine.rho = 0.3;
  EXPECT_THAT(warnings(fine), testing::IsEmpty());
}

TEST(Simulation, TimeAdvancesByWholeSteps) {
  RunOptions options;
  options.step = 0.004;
  Simulation s(example("tutorial/pendulum.yaml"), options);
  EXPECT_EQ(s.step_size(), 0.004);
  EXPECT_EQ(s.time(), 0);
  step(s, 25);
  EXPECT_NEAR(s.time(), 0.1, 1e-12);
}

TEST(Simulation, ChannelsAndRowsAgree) {
  Simulation s(example("iltis/vehicle.yaml", {{"elements", "4"}}));
  step(s, 3);
  ResultsRow row;
  s.sample(row);
  EXPECT_EQ(row.time, s.time());
  EXPECT_EQ(static_cast<std::size_t>(row.channels.size()), s.channels().size());
  EXPECT_EQ(s.output_count(), static_cast<int>(s.model().spec().outputs.size()));
  EXPECT_EQ(row.poses.cols(), 17);
  EXPECT_EQ(row.modes.size(), 64);
  EXPECT_TRUE(row.channels.allFinite() && row.poses.allFinite() && row.modes.allFinite());
  EXPECT_EQ(s.degrees_of_freedom(), s.model().coordinates() - 24);
}

/// A bar on a hinge: outputs against the pendulum's own formulas, also with the joint listed from bar to
/// ground.
TEST(Simulation, OutputsOfAPendulum) {
  for (const bool reversed : {false, true}) {
    const auto model = model_of(R"(
bodies:
  bar: {mass: 2, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
joints:
  hinge: {type: revolute, between: )" +
                                std::string(reversed ? "[bar, ground]" : "[ground, bar]") +
                                R"(, at: [0, 0, 0], axis: [0, 1, 0], velocity: 0.7}
outputs:
  - {name: angle, joint: hinge}
  - {name: rate, joint_velocity: hinge}
  - {name: x, position: bar, at: [1, 0, 0], component: x}
  - {name: z, position: bar, at: [1, 0, 0], component: z}
  - {name: vx, velocity: bar, at: [1, 0, 0], component: x}
  - {name: vz, velocity: bar, at: [1, 0, 0], component: z}
  - {name: ax, acceleration: bar, at: [1, 0, 0], component: x}
  - {name: az, acceleration: bar, at: [1, 0, 0], component: z}
  - {name: fx, joint_force: hinge, component: fx}
  - {name: fz, joint_force: hinge, component: fz}
  - {name: pitch, pitch: bar}
)");
    Simulation s(model);
    step(s, 20);
    ResultsRow row;
    s.sample(row);
    const auto value = [&](const char* name) {
      for (std::size_t k = 0; k < s.channels().size(); ++k)
        if (s.channels()[k].name == name) return row.channels[static_cast<Eigen::Index>(k)];
      ADD_FAILURE() << name;
      return std::nan("");
    };
    // θ about +y takes x towards −z; the reversed joint's coordinate is the ground's relative to the bar.
    const double sign = reversed ? -1 : 1, angle = sign * value("angle"), rate = sign * value("rate");
    const double second = 2 * 9.81 * 0.5 * std::cos(angle) / (0.2 + 2 * 0.25);
    EXPECT_NEAR(value("x"), std::cos(angle), 1e-12);
    EXPECT_NEAR(value("z"), -std::sin(angle), 1e-12);
    EXPECT_NEAR(value("vx"), -std::sin(angle) * rate, 1e-12);
    EXPECT_NEAR(value("vz"), -std::cos(angle) * rate, 1e-12);
    const double ax = -std::cos(angle) * rate * rate - std::sin(angle) * second,
                 az = std::sin(angle) * rate * rate - std::cos(angle) * second;
    EXPECT_NEAR(value("ax"), ax, 1e-4);
    EXPECT_NEAR(value("az"), az, 1e-4);
    EXPECT_NEAR(value("pitch"), angle, 1e-12);
    // On the joint's second body: the bar, or the ground.
    EXPECT_NEAR(sign * value("fx"), 2 * ax / 2, 1e-4);
    EXPECT_NEAR(sign * value("fz"), 2 * (az / 2 + 9.81), 1e-4);
  }
}

/// The reaction of a cut joint against the same joint in the tree.
TEST(Simulation, ReactionsDoNotDependOnWhereTheLoopIsCut) {
  const std::string outputs = R"(
outputs:
  - {name: fx, joint_force: rocker_pin, component: fx}
  - {name: fz, joint_force: rocker_pin, component: fz}
  - {name: gx, joint_force: crank, component: fx}
  - {name: gz, joint_force: crank, component: fz}
)";
  ResultsRow rows[2];
  int k = 0;
  for (const char* cut : {"rocker_pin", "crank"}) {
    std::map<std::string, std::string> more{{cut, ", cut: always"}};
    more["crank_pin"] += ", velocity: 0";
    more["rocker"] += ", velocity: 0";
    Simulation s(model_of(four_bar_text(more) + outputs));
    s.sample(rows[k++]);
  }
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(rows[0].channels[i], rows[1].channels[i], 1e-5);
  EXPECT_GT(std::abs(rows[0].channels[1]), 1);
}

TEST(Simulation, FailuresAreExplained) {
  spec::Model m =
      parse_model("mimbre: 1\ntitle: t\n" + four_bar_text({{"crank", ", velocity: 6"}}), "test.yaml", ".");
  m.simulation.max_iterations = 1;
  m.simulation.step = 0.05;
  Simulation s(Model::compile(m));
  const Simulation::Snapshot before = s.save();
  const StepReport report = s.step();
  ASSERT_FALSE(report.ok());
  EXPECT_THAT(s.explain(report),
              testing::AllOf(testing::HasSubstr("t = 0.05 s"), testing::HasSubstr("joint '")));
  expect_same(s.save(), before);
}

/// Its mass is not at fault.
TEST(Simulation, AForceThatIsNoNumberAtTheStartIsTold) {
  const auto model = model_of(R"(
bodies: {arm: {mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}}
joints: {hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}}
inputs: {tilt: 1}
torsion_springs: {bar: {coordinates: [{joint: hinge}], stiffness: 10, rest: sqrt(-tilt)}}
)");
  using Formulation = spec::Simulation::Formulation;
  for (const auto& [formulation, where] : {std::pair(Formulation::relative, "first in joint 'hinge'"),
                                           std::pair(Formulation::natural, "first in body 'arm'")}) {
    RunOptions options;
    options.formulation = formulation;
    const auto start = [&] { Simulation simulation(model, options); };
    EXPECT_THAT(start,
                testing::ThrowsMessage<InputError>(testing::AllOf(
                    testing::HasSubstr("a force is not a number at the start"), testing::HasSubstr(where))));
  }
}

TEST(Simulation, ABodyWithoutMassThatNothingHoldsIsAnError) {
  spec::Model m;
  spec::Body nothing;
  nothing.name = "nothing";
  m.bodies.push_back(nothing);
  const auto model = Model::compile(m);
  EXPECT_THROW(Simulation simulation(model), InputError);
}

}  // namespace
}  // namespace mimbre::test::simulation_test
