#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "mimbre/method_names.h"
#include "mimbre/run_state.h"
#include "mimbre/unknown_name.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// Saved states: all that the next step depends on, and all that was observed.
namespace mimbre::test::state_test {
namespace {

using ::testing::HasSubstr;
using Formalism = spec::Simulation::Formalism;
using Formulation = spec::Simulation::Formulation;
using Integrator = spec::Simulation::Integrator;

struct Mechanism {
  const char* name;
  std::function<std::shared_ptr<const Model>()> make;
  int latest = 40;         ///< step after which the state is saved, at most
  bool has_tables = true;  ///< global modes are for it, in relative coordinates

  friend void PrintTo(const Mechanism& mechanism, std::ostream* out) { *out << mechanism.name; }
};

/// A drive, a spring with stops and a damper, a torsional spring, a spring by an expression of time, loads.
std::shared_ptr<const Model> loaded_four_bar() {
  return model_of(four_bar_text({{"crank", R"yaml(, drive: {position: "0.5*sin(4*t)"})yaml"},
                                 {"rocker", ", spring: {stiffness: 4, damping: 0.2}"}}) +
                  R"yaml(
springs:
  law:
    between: [ground, coupler]
    at: [[0.3, 0, 0.8], [0.3, 0, 0.35]]
    force: "20*(l - 0.4) + 3*v*l + sin(5*t)"
  damped: {between: [ground, rocker], at: [[1, 0, 0.4], [0.6, 0, 0.3]], elastic: {stiffness: 50, zero: 0.3}, damping: 4}
loads:
  push: {on: rocker, at: [0.6, 0, 0.3], force: [2, 0, 1], scale: "cos(3*t)", follower: true}
)yaml");
}

/// Two bodies on a hinge, thrown.
std::shared_ptr<const Model> thrown() {
  return model_of(R"yaml(
bodies:
  trunk: {mass: 3, com: [0.1, 0, 0], inertia: [0.1, 0.2, 0.25]}
  leg: {mass: 1, com: [0.5, 0, -0.3], inertia: [0.05, 0.05, 0.01]}
joints:
  free: {type: floating, between: [ground, trunk], at: [0, 0, 0], velocity: [1, 0, 5, 0.3, 4, 1]}
  hip: {type: revolute, between: [trunk, leg], at: [0.5, 0, 0], axis: [0, 1, 0], spring: {stiffness: 8}}
)yaml");
}

/// A signal at instants sees one of time, and an event cuts a step: the parts end beside multiples of the
/// step by round-off.
std::shared_ptr<const Model> sampled_arm() {
  return model_of(R"yaml(
bodies:
  arm: {mass: 2, com: [0.5, 0, 0], inertia: [0.02, 0.2, 0.2]}
joints:
  hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}
inputs: {push: 0}
signals:
  wanted: {value: "0.3*sin(6*t)"}
  angle: {joint: hinge}
  servo: {value: "200*(wanted - angle)", every: 0.005}
events:
  reached: {when: angle, crosses: 0.05, set: {push: 1}}
actuators:
  motor: {joint: hinge, torque: servo + push}
simulation: {step: 0.002}
)yaml");
}

const std::vector<Mechanism>& mechanisms() {
  static const std::vector<Mechanism> all{
      {"suspension",
       [] {
         return example("iltis/suspension.yaml", {{"elements", "4"}});
       },
       210},
      {"double_four_bar", [] { return example("double-four-bar/mechanism.yaml"); }},
      {"slider_crank", [] { return example("slider-crank/slider-crank.yaml"); }},
      {"pendulum", [] { return example("pendulum/flexible.yaml"); }},
      {"loaded_four_bar", loaded_four_bar},
      {"controlled_four_bar", controlled_four_bar},
      {"geared_four_bar", geared_four_bar, 40, false},
      {"thrown", thrown},
      {"every_constraint", every_constraint, 40, false},
      {"die_and_ball", die_and_ball, 200},
      {"sampled_arm", sampled_arm, 200},
      {"geometric_stiffness",
       [] {
         return example("spin-up-beam/beam-3d.yaml", {{"method", "geometric_stiffness"}});
       }},
      {"ancf",
       [] {
         return example("spin-up-beam/beam-2d.yaml", {{"method", "ancf"}, {"elements", "4"}});
       }},
      {"ancf_cable",
       [] {
         return example("spin-up-beam/beam-3d.yaml", {{"method", "ancf_cable"}, {"elements", "4"}});
       }},
      {"ancf_thick",
       [] {
         return example("spin-up-beam/beam-3d.yaml", {{"method", "ancf_thick"}, {"elements", "3"}});
       }},
      {"random_tree",
       [] {
         RandomOptions o;
         o.springs = o.damping = o.tyres = o.loads = true;
         return random_mechanism(3, o).model;
       }},
      {"random_loops",
       [] {
         RandomOptions o;
         o.loops = 2;
         o.springs = o.damping = o.drives = true;
         return random_mechanism(5, o).model;
       },
       40, false},
  };
  return all;
}

/// All that a run shows, bit by bit.
struct Course {
  std::vector<double> numbers;
  std::vector<std::string> warnings;
  bool operator==(const Course& other) const {
    return warnings == other.warnings && numbers.size() == other.numbers.size() &&
           std::memcmp(numbers.data(), other.numbers.data(), numbers.size() * sizeof(double)) == 0;
  }
};

Course course(Simulation& s, int steps) {
  Course c;
  ResultsRow row;
  const auto take = [&](const auto& x) { c.numbers.insert(c.numbers.end(), x.data(), x.data() + x.size()); };
  for (int k = 0; k < steps; ++k) {
    const StepReport report = s.step();
    s.sample(row);
    c.numbers.insert(c.numbers.end(),
                     {row.time, static_cast<double>(report.code), static_cast<double>(report.iterations),
                      static_cast<double>(report.factorisations), static_cast<double>(report.substeps)});
    take(row.channels);
    take(row.poses);
    take(row.modes);
  }
  c.warnings = s.warnings();
  for (const Validity& v : s.validity())
    for (const Validity::Peak& peak :
         {v.deflection, v.foreshortening, v.compression, v.tension, v.lag, v.held, v.high_modes})
      c.numbers.insert(c.numbers.end(), {peak.value, peak.time, v.axial});
  const auto end = s.save().bytes();
  c.numbers.resize(c.numbers.size() + end.size() / sizeof(double));
  std::memcpy(c.numbers.data() + c.numbers.size() - end.size() / sizeof(double), end.data(), end.size());
  return c;
}

class SavedState : public testing::TestWithParam<Mechanism> {};
INSTANTIATE_TEST_SUITE_P(Mechanisms, SavedState, testing::ValuesIn(mechanisms()),
                         [](const auto& mechanism) { return std::string(mechanism.param.name); });

/// In the same simulation, and as bytes in another one that has been elsewhere.
TEST_P(SavedState, GoesOnWithTheSameBitsByEveryMethod) {
  const auto model = GetParam().make();
  Random random(static_cast<unsigned>(GetParam().name[0] + GetParam().latest));
  int made = 0;
  for (std::size_t formulation = 0; formulation < method_names::formulations.size(); ++formulation)
    for (std::size_t formalism = 0; formalism < method_names::formalisms.size(); ++formalism)
      for (std::size_t integrator = 0; integrator < method_names::integrators.size(); ++integrator) {
        RunOptions options;
        options.formulation = static_cast<Formulation>(formulation);
        options.formalism = static_cast<Formalism>(formalism);
        options.integrator = static_cast<Integrator>(integrator);
        if (is_runge_kutta(*options.integrator) && options.formalism != Formalism::index3) continue;
        if (options.formalism == Formalism::global_modes &&
            (options.formulation == Formulation::natural || !GetParam().has_tables))
          continue;
        if (options.formalism == Formalism::transfer_matrices && options.formulation == Formulation::natural)
          continue;
        SCOPED_TRACE(fmt::format("{} {} {}", method_names::formulations[formulation],
                                 method_names::formalisms[formalism], method_names::integrators[integrator]));
        Simulation a(model, options);
        const int before = 1 + random.index(GetParam().latest), after = 24;
        for (int k = 0; k < before; ++k)
          if (!a.step().ok()) break;
        const Simulation::Snapshot saved = a.save();
        const Course straight = course(a, after);
        a.restore(saved);
        ASSERT_TRUE(course(a, after) == straight) << "in the same simulation, after " << before << " steps";
        Simulation b(model, options);
        for (int k = random.index(5); k > 0; --k) b.step();
        b.restore(Simulation::Snapshot::from_bytes(saved.bytes()));
        ASSERT_TRUE(b.save().bytes() == saved.bytes());
        ASSERT_TRUE(course(b, after) == straight) << "in another simulation, after " << before << " steps";
        ++made;
      }
  EXPECT_EQ(made, GetParam().has_tables ? 64 : 60);
}

TEST(SavedState, OfAnotherModelOrMethodIsRefused) {
  const auto text = [](double mass) {
    return fmt::format(
        "bodies:\n  bob: {{mass: {}, com: [1, 0, 0], inertia: [0.1, 0.1, 0.1]}}\njoints:\n"
        "  hinge: {{type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}}\n",
        mass);
  };
  Simulation a(model_of(text(1))), same(model_of(text(1))), heavier(model_of(text(1.01)));
  spec::Model nameless = model_of(text(1))->spec();
  nameless.text.clear();
  Simulation unnamed(Model::compile(nameless));
  nameless.bodies[0].mass = 1.001;
  Simulation unnamed_heavier(Model::compile(nameless));
  RunOptions half;
  half.step = 0.005;
  Simulation finer(model_of(text(1)), half);
  const Simulation::Snapshot saved = a.save();
  same.restore(saved);
  for (Simulation* other : {&heavier, &unnamed, &finer}) {
    const Simulation::Snapshot before = other->save();
    EXPECT_THROW(other->restore(saved), InputError);
    EXPECT_TRUE(other->save().bytes() == before.bytes());
  }
  EXPECT_THROW(unnamed_heavier.restore(unnamed.save()), InputError);
  try {
    heavier.restore(saved);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("of another model, or of another method"));
  }
}

TEST(SavedState, DamagedBytesAreRefused) {
  Simulation s(loaded_four_bar());
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(s.step().ok());
  const std::vector<std::byte> whole = s.save().bytes();
  Random random(11);
  for (int k = 0; k < 2000; ++k) {
    std::vector<std::byte> bytes = whole;
    if (random.chance(0.3))
      bytes.resize(static_cast<std::size_t>(random.index(static_cast<int>(whole.size()))));
    else if (random.chance(0.1))
      bytes.push_back(std::byte{0});
    else
      bytes[static_cast<std::size_t>(random.index(static_cast<int>(whole.size())))] ^=
          static_cast<std::byte>(1 << random.index(8));
    EXPECT_THROW(Simulation::Snapshot::from_bytes(bytes), InputError);
  }
  EXPECT_THROW(Simulation::Snapshot::from_bytes({}), InputError);
}

/// What was observed before does not count any more.
TEST(SavedState, RestartingObservesAnew) {
  const auto model = example("pendulum/flexible.yaml");
  Simulation s(model);
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(s.step().ok());
  Simulation::Snapshot now = s.save();
  const double before = s.validity().at(0).deflection.value;
  s.restart(now);
  EXPECT_EQ(s.time(), now.time);
  EXPECT_TRUE(s.save().q == now.q);
  EXPECT_EQ(s.energy().numerical, 0);
  EXPECT_LE(s.validity().at(0).deflection.value, before);
  now.v.resize(1);
  EXPECT_THROW(s.restart(now), InputError);
}

/// Nothing of the motion depends on who looks on.
TEST(Observers, CanBeLeftOut) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural})
    for (const char* file : {"pendulum/flexible.yaml", "slider-crank/slider-crank.yaml"}) {
      RunOptions all;
      all.formulation = formulation;
      all.substeps = 1;
      RunOptions none = all;
      none.energies = none.validity = none.warnings = false;
      const auto model = example(file);
      Simulation a(model, all), b(model, none);
      for (int k = 0; k < 50; ++k) {
        ASSERT_TRUE(a.step().ok());
        ASSERT_TRUE(b.step().ok());
        ASSERT_TRUE(a.save().q == b.save().q) << file << " " << k;
      }
      EXPECT_FALSE(b.method().energies);
      EXPECT_TRUE(std::isnan(b.energy().kinetic));
      EXPECT_TRUE(b.validity().empty() && b.warnings().empty());
    }
}

TEST(Observers, EnergiesAreImpliedByParts) {
  RunOptions options;
  options.energies = false;
  EXPECT_TRUE(Simulation(thrown(), options).method().energies);
  options.substeps = 1;
  EXPECT_FALSE(Simulation(thrown(), options).method().energies);
  options.integrator = Integrator::conserve;
  EXPECT_TRUE(Simulation(thrown(), options).method().energies);
}

/// One by one as all together.
TEST(Handles, GiveWhatRowsHold) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural})
    for (const auto& model : {loaded_four_bar(), example("iltis/suspension.yaml", {{"elements", "4"}})}) {
      RunOptions options;
      options.formulation = formulation;
      Simulation a(model, options), b(model, options);
      ResultsRow row;
      for (int k = 0; k < 20; ++k) {
        ASSERT_TRUE(a.step().ok());
        ASSERT_TRUE(b.step().ok());
        a.sample(row);
        for (std::size_t c = 0; c < a.channels().size(); ++c) {
          const double value = b.value(b.channel(a.channels()[c].name));
          const double expected = row.channels[static_cast<Eigen::Index>(c)];
          EXPECT_NEAR(value, expected, 1e-9 * (1 + std::abs(expected))) << a.channels()[c].name;
        }
        for (std::size_t i = 0; i < model->spec().bodies.size(); ++i) {
          const spec::Pose pose = b.pose(b.body(model->spec().bodies[i].name));
          const auto expected = row.poses.col(static_cast<Eigen::Index>(i));
          EXPECT_NEAR((pose.position - expected.head<3>()).norm(), 0, 1e-12);
          const Eigen::Quaterniond turn(expected[3], expected[4], expected[5], expected[6]);
          EXPECT_NEAR((pose.rotation - turn.toRotationMatrix()).norm(), 0, 1e-12);
        }
      }
    }
}

TEST(Handles, OfWhatIsNotThereAreRefusedWithNamesLikeIt) {
  Simulation s(thrown());
  const auto message = [](auto&& work) {
    try {
      work();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message([&] { s.channel("energy.kinetik"); }),
            "there is no channel 'energy.kinetik' (did you mean 'energy.kinetic'?)");
  EXPECT_EQ(message([&] { s.body("trunc"); }), "there is no body 'trunc' (did you mean 'trunk'?)");
  EXPECT_THROW(s.input("nothing"), UnknownName);
}

}  // namespace
}  // namespace mimbre::test::state_test
