#include "mimbre/inertia_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// Which terms of the inertia a model can do without.
namespace mimbre::test::inertia_study_test {
namespace {

using testing::HasSubstr;

/// A bar that a drive turns, or pushes sideways without turning it.
std::string driven_bar(const std::string& joint) {
  return R"(
gravity: [0, 0, 0]
materials: {alloy: {young: 7e10, poisson: 0.3, density: 2700}}
sections: {strip: {type: rectangle, height: 0.004, width: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: alloy
      section: strip
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {all: {from: root, to: tip, elements: 6}}
      clamped: [root]
      dynamic_modes: 3
joints:
  motor: {)" +
         joint + R"(}
outputs:
  - {name: tip, deflection: bar.tip, along: [0, 1, 0]}
  - {name: stretch, deflection: bar.tip, along: [1, 0, 0]}
simulation: {step: 1e-3, end: 1.5, output_interval: 1e-2}
)";
}
const std::string turned =
    "type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 0, 1], drive: {position: "
    "\"3*t^2\"}";
const std::string pushed =
    "type: prismatic, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: "
    "\"0.1*t^2\"}";

InertiaStudy study_of(const spec::Model& model, double error) {
  InertiaStudyOptions options;
  options.error = error;
  options.measure = false;
  return study_inertia(model, options);
}

/// The same body, a hundred times as stiff.
std::shared_ptr<const ReducedBody> stiffer(const ReducedBody& body) {
  auto copy = std::make_shared<ReducedBody>(body);
  copy->stiffness *= 100;
  return copy;
}

/// The largest error of an output by its range, of runs made here.
double error_of(const spec::Model& with, const spec::Model& without) {
  Simulation a(Model::compile(with)), b(Model::compile(without));
  const int n = a.output_count();
  Eigen::ArrayXd least = Eigen::ArrayXd::Constant(n, INFINITY), most = -least, off = Eigen::ArrayXd::Zero(n);
  ResultsRow x, y;
  for (int k = 0; k <= 1500; ++k) {
    if (k > 0) {
      EXPECT_TRUE(a.step().ok() && b.step().ok());
    }
    if (k % 10 != 0) continue;
    a.sample(x);
    b.sample(y);
    const Eigen::ArrayXd all = x.channels.head(n);
    least = least.min(all);
    most = most.max(all);
    off = off.max((all - y.channels.head(n).array()).abs());
  }
  const Eigen::ArrayXd range = (most - least).max(1e-3 * (most - least).maxCoeff());
  return (off / range).maxCoeff();
}

TEST(InertiaStudy, KeepsTheErrorThatIsAllowed) {
  const auto model = model_of(driven_bar(turned));
  std::size_t before = 0;
  for (const double error : {1e-5, 1e-3, 0.9}) {
    const InertiaStudy study = study_of(model->spec(), error);
    const double found = error_of(model->spec(), with_choice(model->spec(), study));
    EXPECT_LE(found, error);
    EXPECT_NEAR(study.error, found, 1e-3 * found + 1e-12);
    ASSERT_EQ(study.bodies.size(), 1u);
    const std::size_t count = names_of(study.bodies[0].neglected).size();
    EXPECT_GE(count, before);  // the more, the more is allowed
    before = count;
  }
  EXPECT_GT(before, 5u);
}

/// A plane four-bar of revolute joints in space: its reactions are the smallest of those that balance the
/// forces, which is a choice and no arbitrary value. Their errors count as those of other outputs do.
TEST(InertiaStudy, ComparesReactionsOfRedundantLoops) {
  const auto model = model_of(R"yaml(
materials: {alloy: {young: 7e10, poisson: 0.3, density: 2700}}
sections: {rod: {type: round, diameter: 0.012}}
bodies:
  crank: {mass: 0.5, com: [0, 0, 0.1], inertia: [0.002, 0.002, 0.0001]}
  coupler:
    frame: {at: [0, 0, 0.2], x: [0.6, 0, 0.3], y: [0, 1, 0]}
    flexible:
      material: alloy
      section: rod
      nodes: {a: [0, 0, 0.2], b: [0.6, 0, 0.5]}
      bars: {bar: {from: a, to: b, elements: 8}}
      clamped: [a]
      static_modes: [{node: b, along: [0.6, 0, 0.3]}, {node: b, along: [-0.3, 0, 0.6]}]
      planar: [0, 1, 0]
      dynamic_modes: 3
      stiffness_damping: 1e-5
  rocker: {mass: 1, com: [0.6, 0, 0.25], inertia: [0.02, 0.02, 0.0005]}
joints:
  motor:
    type: revolute
    between: [ground, crank]
    at: [0, 0, 0]
    axis: [0, 1, 0]
    drive: {position: "2*pi*(t - 0.5*(1 - exp(-2*t)))"}
  p1: {type: revolute, between: [crank, coupler], at: [0, 0, 0.2], axis: [0, 1, 0]}
  p2: {type: revolute, between: [ground, rocker], at: [0.6, 0, 0], axis: [0, 1, 0]}
  p3: {type: revolute, between: [coupler, rocker], at: [0.6, 0, 0.5], axis: [0, 1, 0], cut: always}
outputs:
  - {name: rocker, joint: p2}
  - {name: torque, joint_force: motor, component: my}
  - {name: fz, joint_force: p2, component: fz}
simulation: {step: 1e-3, end: 1.5, output_interval: 1e-2}
)yaml");
  const spec::Model& full = model->spec();
  const InertiaStudy study = study_of(full, 1e-3);
  EXPECT_EQ(study.outputs, (std::vector<std::string>{"rocker", "torque", "fz"}));
  const double found = error_of(full, with_choice(full, study));
  EXPECT_LE(found, 1e-3);
  EXPECT_NEAR(study.error, found, 1e-3 * found + 1e-12);
  // Without all terms the angle is right, and a reaction is not.
  InertiaTerms all;
  for (int k = 0; k < inertia_term_count; ++k) all.add(static_cast<InertiaTerm>(k));
  spec::Model without = full;
  without.bodies[1].neglected = all;
  EXPECT_GT(error_of(full, without), 0.02);
  spec::Model angle = full;
  angle.outputs.resize(1);
  without.outputs.resize(1);
  EXPECT_LT(error_of(angle, without), 1e-4);
}

/// Turned about z: what bends the bar is the angular acceleration, and what softens it is the centrifugal
/// force by its deflection; none of its modes stretches it.
TEST(InertiaStudy, KnowsWhatMatters) {
  const InertiaStudy study = study_of(model_of(driven_bar(turned))->spec(), 1e-3);
  const auto& term = [&](InertiaTerm t) { return study.terms[static_cast<std::size_t>(t)]; };
  EXPECT_GT(term(InertiaTerm::rotation_coupling).error, 0.5);
  EXPECT_GT(term(InertiaTerm::centrifugal).error, 0.05);
  EXPECT_NEAR(term(InertiaTerm::centrifugal).error, term(InertiaTerm::centrifugal_deformed).error, 1e-6);
  EXPECT_LT(term(InertiaTerm::second_moment_quadratic).error, 1e-9);  // of a driven body they are reactions
  EXPECT_LT(term(InertiaTerm::coriolis_body).error, 1e-9);
  EXPECT_GT(term(InertiaTerm::rotation_coupling).estimate, term(InertiaTerm::coriolis_modes).estimate);
  const InertiaTerms& gone = study.bodies[0].neglected;
  EXPECT_TRUE(gone.has(InertiaTerm::coriolis_body) && gone.has(InertiaTerm::second_moment_linear));
  EXPECT_FALSE(gone.has(InertiaTerm::rotation_coupling) || gone.has(InertiaTerm::centrifugal));
}

TEST(InertiaStudy, WithoutTurningNeedsNone) {
  const auto model = model_of(driven_bar(pushed));
  const InertiaStudy study = study_of(model->spec(), 1e-9);
  EXPECT_EQ(study.error, 0);
  for (int k = 0; k < inertia_term_count; ++k) {
    EXPECT_EQ(study.terms[static_cast<std::size_t>(k)].error, 0)
        << inertia_terms[static_cast<std::size_t>(k)].name;
    EXPECT_TRUE(study.bodies[0].neglected.has(static_cast<InertiaTerm>(k)));
  }
}

/// A bar that flies: without terms that hardly matter it moves as with them, in both formulations.
TEST(InertiaStudy, FlyingBodiesDoWithoutSmallTerms) {
  const std::string text =
      driven_bar("type: floating, between: [ground, bar], at: [0, 0, 0], velocity: [0, 0, 0, 0, 5, 20]");
  const spec::Model full = model_of(text)->spec();
  spec::Model lean = full;
  for (const InertiaTerm term :
       {InertiaTerm::second_moment_quadratic, InertiaTerm::rotation_coupling_deformed,
        InertiaTerm::centrifugal_deformed, InertiaTerm::coriolis_body_deformed})
    lean.bodies[0].neglected.add(term);
  lean.bodies[0].flexible = stiffer(*lean.bodies[0].flexible);
  spec::Model stiff = full;
  stiff.bodies[0].flexible = lean.bodies[0].flexible;
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    RunOptions options;
    options.formulation = formulation;
    Simulation a(Model::compile(stiff), options), b(Model::compile(lean), options);
    for (int k = 0; k < 300; ++k) {
      ASSERT_TRUE(a.step().ok());
      ASSERT_TRUE(b.step().ok());
    }
    const spec::Pose p = a.pose(a.body("bar")), q = b.pose(b.body("bar"));
    EXPECT_LT((p.position - q.position).norm(), 1e-3);
    EXPECT_LT((p.rotation - q.rotation).norm(), 1e-2);
  }
}

/// The runs are those that were asked for: the formulations agree but for the error of a step.
TEST(InertiaStudy, RunsInTheFormulationThatIsAsked) {
  using Formulation = spec::Simulation::Formulation;
  spec::Model model = model_of(driven_bar(turned))->spec();
  InertiaStudyOptions options;
  options.measure = false;
  const InertiaStudy relative = study_inertia(model, options);
  options.run.formulation = Formulation::natural;
  const InertiaStudy natural = study_inertia(model, options);
  options.run.formulation.reset();
  model.simulation.formulation = Formulation::natural;
  const InertiaStudy by_model = study_inertia(model, options);
  bool differ = false;
  for (std::size_t k = 0; k < relative.terms.size(); ++k) {
    const double a = relative.terms[k].error, b = natural.terms[k].error;
    EXPECT_EQ(b, by_model.terms[k].error);
    EXPECT_NEAR(a, b, 0.1 * a + 3e-4) << k;  // drives of natural coordinates hold by the tolerance
    differ = differ || a != b;
    EXPECT_NEAR(relative.terms[k].estimate, natural.terms[k].estimate, 1e-6);
  }
  EXPECT_TRUE(differ);
}

/// Without any term steps restore no momentum of what flies.
TEST(InertiaStudy, SaysThatFlyingBodiesLoseTheirCorrection) {
  const spec::Model flies =
      model_of(
          driven_bar("type: floating, between: [ground, bar], at: [0, 0, 0], velocity: [0, 0, 0, 0, 5, 20]"))
          ->spec();
  EXPECT_THAT(study_of(flies, 1e-3).notes, testing::ElementsAre(HasSubstr("'bar' flies freely")));
  EXPECT_THAT(study_of(model_of(driven_bar(turned))->spec(), 1e-3).notes, testing::IsEmpty());
}

TEST(InertiaStudy, SaysWhatItCannotStudy) {
  const auto says = [](const spec::Model& model,
                       const std::vector<std::string>& outputs = {}) -> std::string {
    InertiaStudyOptions options;
    options.outputs = outputs;
    options.measure = false;
    try {
      study_inertia(model, options);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(says(example("double-wishbone/model.yaml")->spec()), HasSubstr("no flexible body"));
  const spec::Model bar = model_of(driven_bar(turned))->spec();
  EXPECT_THAT(says(bar, {"tipp"}), HasSubstr("'tip'"));
  spec::Model still = model_of(driven_bar("type: fixed, between: [ground, bar], at: [0, 0, 0]"))->spec();
  EXPECT_THAT(says(still), HasSubstr("no output moves"));
  spec::Model projected = bar;
  projected.simulation.inertia = spec::Simulation::Inertia::projection;
  EXPECT_THAT(says(projected), HasSubstr("inertia: integrals"));
}

}  // namespace
}  // namespace mimbre::test::inertia_study_test
