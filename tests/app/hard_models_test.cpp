#include <gmock/gmock.h>

#include <cmath>

#include "app/program.h"

/// Models that are hard for a program of this kind (tests/data/hard): each gives the right numbers, a
/// warning, or one clear error, and never a wrong answer in silence.
namespace mimbre::app_test::hard_models_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string hard(const std::string& model) {
  return (fs::path(MIMBRE_SOURCE_DIR) / "tests/data/hard" / model).string();
}
std::string example(const std::string& model) {
  return (fs::path(MIMBRE_SOURCE_DIR) / "examples" / model).string();
}

/// A command, its exit code, and what it says beside the result; nothing: it says nothing.
struct Case {
  std::string name;
  std::vector<std::string> command;
  int code = 0;
  std::vector<std::string> says;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class HardModel : public ProgramTest, public ::testing::WithParamInterface<Case> {};

TEST_P(HardModel, IsRightOrSaysWhyNot) {
  const Case& c = GetParam();
  std::vector<std::string> command = c.command;
  command.emplace_back("--json");
  const Outcome outcome = run(command);
  EXPECT_EQ(outcome.code, c.code) << outcome.err;
  for (const std::string& words : c.says) EXPECT_THAT(outcome.err, HasSubstr(words));
  if (c.says.empty()) {
    EXPECT_EQ(outcome.err, "");
  }
}

const std::string spring_damped = "the numerics took out";

INSTANTIATE_TEST_SUITE_P(
    Of, HardModel,
    testing::Values(
        // Steps that are too long: what the integrator damps is said, with what vibrates.
        Case{"FourStepsAPeriod",
             {"run", hard("long-steps-oscillator.yaml")},
             0,
             {spring_damped, "the spring of joint 'p'", "take a smaller step"}},
        Case{"AStepOfManyPeriods",
             {"run", hard("long-steps-oscillator.yaml"), "--step", "0.5"},
             0,
             {spring_damped, "100 %"}},
        Case{"ShortStepsAreRight", {"run", hard("long-steps-oscillator.yaml"), "--step", "0.0005"}, 0, {}},
        Case{"TheCarInLongSteps",
             {"run", example("iltis/vehicle.yaml"), "--step", "0.2", "--until", "4"},
             0,
             {spring_damped, "leaf"}},
        Case{"Prestress1e8",
             {"run", hard("prestressed-spring.yaml"), "--set", "stiffness=1e8"},
             0,
             {spring_damped, "the 5e+05 J at play", "spring 's'"}},
        Case{"Prestress1e10",
             {"run", hard("prestressed-spring.yaml")},
             0,
             {spring_damped, "the 5e+07 J at play"}},
        Case{"Prestress1e12",
             {"run", hard("prestressed-spring.yaml"), "--set", "stiffness=1e12"},
             0,
             {spring_damped, "the 5e+09 J at play"}},
        Case{"NoStep",
             {"run", hard("long-steps-oscillator.yaml"), "--step", "10", "--until", "1"},
             2,
             {"the step of 10 s is longer than the run", "give a shorter --step"}},
        // Small ones.
        Case{"BricardInMicroseconds",
             {"run", example("bricard/mechanism.yaml"), "--step", "1e-6", "--until", "1e-4"},
             0,
             {}},
        Case{"FourBarInTenthsOfMicroseconds",
             {"run", example("tutorial/four-bar.yaml"), "--step", "1e-7", "--until", "1e-5"},
             0,
             {}},
        Case{"DoubleFourBarInMicroseconds",
             {"run", example("double-four-bar/mechanism.yaml"), "--step", "1e-6", "--until", "1e-4"},
             0,
             {}},
        Case{"TheCarInMicroseconds",
             {"run", example("iltis/vehicle.yaml"), "--step", "1e-6", "--until", "1e-4"},
             0,
             {}},
        // Redundancy.
        Case{"HingesNearlyOnOneAxis",
             {"check", hard("two-hinges.yaml"), "--set", "off=1e-8"},
             0,
             {"nearly redundant", "'a', 'b'", "their reactions are arbitrary"}},
        // Inputs that no motion follows, places where nothing stays, positions of which there are several.
        Case{"AJump", {"run", hard("jumping-drive.yaml")}, 0, {"joint 'h' jumps by 1 at t = 0.5 s"}},
        Case{"AChoice", {"run", hard("unused-branch.yaml")}, 0, {"there are no outputs"}},
        Case{"Upright", {"static", hard("inverted-pendulum.yaml")}, 0, {"unstable", "joint 'h'"}},
        Case{"SingularForIndependentCoordinates",
             {"run", hard("four-loops.yaml"), "--formalism", "independent", "--step", "0.004"},
             3,
             {"the constraints are dependent", "a singular position", "use a formalism that tolerates one"}},
        Case{"SingularForBaumgarte",
             {"run", hard("four-loops.yaml"), "--formalism", "baumgarte", "--step", "0.004"},
             3,
             {"the constraints are dependent"}},
        Case{"SingularForTheDefault", {"run", hard("four-loops.yaml"), "--step", "0.004"}, 0, {}},
        Case{"FewAxialModesInATurningBeam",
             {"check", example("spin-up-beam/beam-3d.yaml"), "--set", "method=nonlinear_stiffness_1", "--set",
              "axial_modes=1"},
             0,
             {"axial mode", "poorly", "frequencies of a turning beam"}},
        // Linear theory.
        Case{"BentFarWhereTheEndIsHeld",
             {"run", hard("held-tip.yaml"), "--set", "stiff=linear", "--until", "1"},
             0,
             {"body 'shaft' is beyond linear theory", "deflection over length"}},
        Case{"ShortStepsInALoopThatStiffens",
             {"run", hard("fast-slider-crank.yaml"), "--set", "method=geometric_stiffness", "--step",
              "2.5e-5", "--until", "0.09"},
             0,
             {"body 'rod' is beyond linear theory"}}),
    [](const auto& of) { return of.param.name; });

class HardModels : public ProgramTest {};

double output(const Outcome& outcome, const std::string& name) {
  return outcome.json().at("outputs").at(name).number();
}

/// Hinges that are off by round-off bear what those on one axis do, in both formulations.
TEST_F(HardModels, TwoHingesShareTheLoad) {
  const Outcome one = run({"run", hard("two-hinges.yaml"), "--json"});
  for (const char* off : {"0", "1e-12", "1e-10"})
    for (const char* formulation : {"relative", "natural"}) {
      const Outcome outcome = run({"run", hard("two-hinges.yaml"), "--set", std::string("off=") + off,
                                   "--formulation", formulation, "--step", "0.002", "--json"});
      ASSERT_EQ(outcome.code, 0) << outcome.err;
      const double angle = output(outcome, "a");
      EXPECT_NEAR(angle, output(one, "a"), 0.02);
      for (const char* force : {"az", "bz"})
        EXPECT_NEAR(output(outcome, force), output(one, force), 0.2) << off;
    }
}

/// A start in the change point, where the couplers may fold either way: with velocities that are those of no
/// way it is warned of, with those of one the forces are those of the motion until the next change point.
TEST_F(HardModels, AFlatParallelogram) {
  for (const char* formulation : {"relative", "natural"}) {
    const Outcome outcome = run({"run", hard("flat-parallelogram.yaml"), "--formulation", formulation, "-q"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.err, HasSubstr("at the start the mechanism can go several ways"));
    EXPECT_THAT(outcome.err, HasSubstr("joint 'e'"));
    std::string model = read_file(hard("flat-parallelogram.yaml"));
    const std::string d = "at: [2,0,0], axis: [0,1,0]";
    write_file(folder / "one-way.yaml", model.replace(model.find(d), d.size(), d + ", velocity: w"));
    const Outcome way =
        run({"run", "one-way.yaml", "--formulation", formulation, "--until", "0.8", "--csv", "f.csv", "-q"});
    EXPECT_EQ(way.code, 0);
    EXPECT_EQ(way.err, "");
    for (const auto& row : csv_rows(folder / "f.csv")) EXPECT_LT(std::abs(row.at(4)), 100) << row[0];
  }
}

/// On the way through a change point the forces grow as 1/angle: what no step resolves is said, once, and is
/// no row of thousands of newtons.
TEST_F(HardModels, AParallelogramThroughItsChangePoints) {
  std::string model = read_file(hard("flat-parallelogram.yaml"));
  const std::string d = "at: [2,0,0], axis: [0,1,0]";
  write_file(folder / "one-way.yaml", model.replace(model.find(d), d.size(), d + ", velocity: w"));
  for (const char* formulation : {"relative", "natural"}) {
    const Outcome outcome =
        run({"run", "one-way.yaml", "--formulation", formulation, "--csv", "f.csv", "--json"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.json().at("warnings").texts(),
                testing::ElementsAre(testing::AllOf(HasSubstr("at t = 0.93 s"), HasSubstr("change point"),
                                                    HasSubstr("joint '"))));
    double largest = 0;
    for (const auto& row : csv_rows(folder / "f.csv")) largest = std::max(largest, std::abs(row.at(4)));
    EXPECT_LT(largest, 100);
    EXPECT_GT(largest, 30);
  }
}

/// Exactly similar mechanisms move alike, and what is warned of is the same.
TEST_F(HardModels, SizeDoesNotMatter) {
  for (const char* formulation : {"relative", "natural"}) {
    const auto of = [&](const char* size) {
      return run({"run", hard("similar-four-bar.yaml"), "--set", std::string("L=") + size, "--formulation",
                  formulation, "--json"});
    };
    const Outcome one = of("1");
    for (const char* size : {"1e-3", "0.1", "1e9"}) {
      const Outcome other = of(size);
      ASSERT_EQ(other.code, 0) << other.err;
      EXPECT_NEAR(output(other, "a"), output(one, "a"), 1e-3) << size << ' ' << formulation;
      EXPECT_EQ(other.json().at("warnings").size(), one.json().at("warnings").size());
      EXPECT_EQ(other.json().at("repeated_steps"), one.json().at("repeated_steps"));
    }
    const Outcome fine = run(
        {"run", hard("similar-four-bar.yaml"), "--step", "0.001", "--formulation", formulation, "--json"});
    EXPECT_NEAR(output(fine, "a"), 23.61, 0.01);
    // Four turns in 0.01 s steps: to half a percent, or with a warning.
    EXPECT_TRUE(std::abs(output(one, "a") - 23.61) < 0.005 * 23.61 || !one.json().at("warnings").empty());
  }
}

/// The exact motion of N loops is that of one pendulum, all of whose bars turn alike and whose couplers go
/// round.
TEST_F(HardModels, ManyLoopsMoveAsOnePendulum) {
  // N + 1 upright bars of 1 kg and 1 m, N couplers of 1 kg: J = (N + 1)/3 + N; weights (N + 1)/2 + N at 1 m.
  constexpr int loops = 4;
  const double inertia = (loops + 1) / 3. + loops, weight = 9.81 * ((loops + 1) / 2. + loops);
  // θ is the angle from the start, upright: J θ̈ = W sin θ; classical Runge–Kutta.
  const auto pull = [&](double angle) { return weight * std::sin(angle) / inertia; };
  double angle = 0, rate = -1;
  constexpr double h = 1e-3;
  for (int k = 0; k < 10000; ++k) {
    const double v1 = rate, a1 = pull(angle), v2 = rate + h / 2 * a1, a2 = pull(angle + h / 2 * v1),
                 v3 = rate + h / 2 * a2, a3 = pull(angle + h / 2 * v2), v4 = rate + h * a3,
                 a4 = pull(angle + h * v3);
    angle += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  for (const char* formulation : {"relative", "natural"})
    for (const char* step : {"0.004", "0.002"}) {
      const Outcome outcome =
          run({"run", hard("four-loops.yaml"), "--step", step, "--formulation", formulation, "--json"});
      ASSERT_EQ(outcome.code, 0) << outcome.err;
      const double error = std::abs(output(outcome, "theta") - std::acos(0) - angle);
      EXPECT_TRUE(error < 4e3 * std::pow(std::stod(step), 2) || !outcome.json().at("warnings").empty())
          << step << ' ' << formulation << ": off by " << error;
      EXPECT_LT(outcome.json().at("max_velocity_violation"), 1e-6);
    }
}

/// Constant energy and momentum are agreed upon.
TEST_F(HardModels, AFreeBodyIsAgreedUpon) {
  const Outcome outcome = run({"verify", hard("free-rigid.yaml"), "--until", "10", "--json"});
  EXPECT_EQ(outcome.json().at("agree"), true) << outcome.out;
}

/// A car that stands still on a level road may stand anywhere: both formulations start at one place.
TEST_F(HardModels, AnAxleThatStandsStillIsAgreedUpon) {
  const Outcome outcome =
      run({"verify", hard("axle.yaml"), "--step", "0.002", "--until", "0.1", "--no-refine", "--json"});
  EXPECT_EQ(outcome.json().at("agree"), true) << outcome.out;
  for (const auto& channel : outcome.json().at("channels"))
    if (channel.at("name") == "joint.guide.position.1") {
      EXPECT_LT(channel.at("max_difference"), 1e-11);
    }
}

/// Its steps are repeated by one formulation more than by the other, which is no disagreement.
TEST_F(HardModels, AGovernorIsAgreedUpon) {
  const Outcome outcome = run({"verify", hard("governor.yaml"), "--json"});
  EXPECT_EQ(outcome.json().at("agree"), true) << outcome.out;
  EXPECT_GT(outcome.json().at("total_repeated_steps"), 0);
}

/// Only what a smaller tolerance does not change is right: the forces in bushings of dummy bodies.
TEST_F(HardModels, ForcesAreConvergedAtTheDefaultTolerance) {
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> command{"run", hard("axle.yaml"), "--step", "0.005", "--until", "1.3"};
    command.insert(command.end(), more.begin(), more.end());
    const std::string file = "t" + std::to_string(more.size()) + ".csv";
    command.insert(command.end(), {"--csv", file, "-q"});
    EXPECT_EQ(run(command).code, 0);
    return csv_rows(folder / file);
  };
  const auto loose = with({}), tight = with({"--tolerance", "1e-9"});
  ASSERT_EQ(loose.size(), tight.size());
  for (std::size_t c = 1; c < loose.front().size(); ++c) {
    double difference = 0, largest = 0;
    for (std::size_t k = 0; k < loose.size(); ++k) {
      difference = std::max(difference, std::abs(loose[k][c] - tight[k][c]));
      largest = std::max(largest, std::abs(tight[k][c]));
    }
    EXPECT_LE(difference, 2e-3 * largest + 1e-9) << "column " << c;
  }
}

/// What programs that read the summaries rely upon.
TEST_F(HardModels, SummariesForMachinesHaveTheirKeys) {
  const auto run_summary = run({"run", hard("jumping-drive.yaml"), "--json"}).json();
  EXPECT_TRUE(run_summary.at("repeated_steps").is_number());
  EXPECT_THAT(run_summary.at("warnings").texts(), testing::Contains(HasSubstr("jumps by 1")));
  const auto verify = run({"verify", hard("two-hinges.yaml"), "--until", "0.2", "--json"}).json();
  EXPECT_EQ(verify.at("agree"), true);
  ASSERT_FALSE(verify.at("channels").empty());
  for (const auto& channel : verify.at("channels")) {
    EXPECT_TRUE(channel.at("name").is_string());
    EXPECT_TRUE(channel.at("difference").is_number());
    EXPECT_TRUE(channel.at("ratio").is_number() || channel.at("ratio").is_null());
    EXPECT_EQ(channel.at("agrees"), true);
  }
  const auto check = run({"check", hard("two-hinges.yaml"), "--json"}).json();
  EXPECT_THAT(check.at("redundant").texts(), testing::ElementsAre("a", "b"));
  EXPECT_THAT(check.at("nearly_redundant").texts(), IsEmpty());
  EXPECT_EQ(check.at("degrees_of_freedom"), 1);
  EXPECT_EQ(check.at("redundant_equations"), 5);
}

/// 0 done, 1 bad input, 2 wrong use, 3 failed, 4 a warning where --strict asks.
TEST_F(HardModels, ExitCodes) {
  EXPECT_EQ(run({"run", hard("free-rigid.yaml"), "--until", "1", "-q"}).code, 0);
  EXPECT_EQ(run({"run", hard("none.yaml")}).code, 1);
  EXPECT_EQ(run({"run", hard("free-rigid.yaml"), "--stepp", "1"}).code, 2);
  EXPECT_EQ(run({"run", hard("four-loops.yaml"), "--formalism", "independent", "-q"}).code, 3);
  EXPECT_EQ(run({"run", hard("jumping-drive.yaml"), "--strict", "-q"}).code, 4);
  EXPECT_EQ(run({"verify", hard("free-rigid.yaml"), "--until", "0", "--strict"}).code, 4);
  EXPECT_EQ(run({"check", hard("two-hinges.yaml"), "--set", "off=1e-8", "--strict"}).code, 4);
  EXPECT_EQ(run({"static", hard("inverted-pendulum.yaml"), "--strict"}).code, 4);
}

}  // namespace
}  // namespace mimbre::app_test::hard_models_test
