#include <gmock/gmock.h>

#include "app/program.h"

/// What the program says where people go wrong: in their words, by name, with what would be right; once.
namespace mimbre::app_test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Messages : public ProgramTest {
 protected:
  Outcome of(const std::string& command, const std::string& text) {
    write_file(folder / "model.yaml", text);
    return run({command, "model.yaml"});
  }
};

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

const std::string arm = "mimbre: 1\nbodies:\n  arm: {mass: 1, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}\n";
std::string hinge(const std::string& type, const std::string& rest = "") {
  return arm + "joints:\n  hinge: {type: " + type +
         ", between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]" + rest +
         "}\noutputs:\n  - {name: angle, joint: hinge}\nsimulation: {step: 0.01, end: 0.1}\n";
}

TEST_F(Messages, ADegreeSignIsUnderstoodAndAWrongUnitToldWithTheRightOne) {
  EXPECT_EQ(of("check", hinge("revolute", ", drive: {position: 30 deg}")).code, 0);
  EXPECT_THAT(of("check", hinge("revolute", ", drive: {position: 30 mm}")).err,
              HasSubstr("model.yaml:5:101: error: joint 'hinge': drive: position: '30 mm' is in m; rad is "
                        "needed here (or deg)"));
  EXPECT_THAT(of("check", hinge("revolute", ", drive: {position: 90 deg/s}")).err,
              HasSubstr("'90 deg/s' is in rad/s"));
  EXPECT_THAT(
      of("check", "mimbre: 1\nbodies:\n  arm: {mass: 0.2 N, com: [0, 0, 0], inertia: [1, 1, 1]}\n").err,
      HasSubstr("body 'arm': mass: '0.2 N' is in N; kg is needed here"));
}

/// Plain numbers that are degrees in the user's mind.
TEST_F(Messages, AnglesThatLookLikeDegreesAreAskedAbout) {
  for (const char* law : {"90", "\"90*sin(6*t)\"", "\"45 + 10*t\""}) {
    std::string text = hinge("revolute", std::string(", drive: {position: ") + law + "}");
    text.replace(text.find("end: 0.1"), 8, "end: 10");
    EXPECT_THAT(of("check", text).err,
                AllOf(HasSubstr("joint 'hinge'"), HasSubstr("where degrees are meant write them: 30 deg")));
  }
  EXPECT_THAT(of("check", hinge("revolute", ", position: 30")).err,
              HasSubstr("starts at 30 rad, 4.77 turns"));
  for (const char* law : {"90 deg", "\"100*t\"", "\"2*sin(6*t)\"", "1.57"})
    EXPECT_EQ(of("check", hinge("revolute", std::string(", drive: {position: ") + law + "}")).err, "") << law;
}

TEST_F(Messages, ATabIsCalledOne) {
  EXPECT_THAT(
      of("check", "mimbre: 1\nbodies:\n\tarm: {mass: 1}\n").err,
      HasSubstr("model.yaml:3:1: error: not valid YAML: a tab in the indentation; indent with spaces"));
}

TEST_F(Messages, OtherProgramsWordsForJointsAreKnown) {
  for (const auto& [word, right] :
       {std::pair{"hinge", "revolute"}, {"weld", "fixed"}, {"ball", "spherical"}, {"slider", "prismatic"}})
    EXPECT_THAT(of("check", hinge(word)).err,
                HasSubstr(std::string("'") + word + "' is called '" + right + "' here"));
}

TEST_F(Messages, BodiesWithoutMassThatMakeTheStartSingularAreNamed) {
  const Outcome outcome = of("check", R"(mimbre: 1
bodies:
  arm: {mass: 1, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}
  rod: {mass: 0, com: [1, 0, 0]}
joints:
  hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}
  pin: {type: revolute, between: [arm, rod], at: [1, 0, 0], axis: [0, 1, 0]}
)");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("body 'rod' moves without any mass"),
                                 HasSubstr("give mass and inertia"), Not(HasSubstr("'arm'"))));
}

TEST_F(Messages, AFreeBodyInStaticsIsNamed) {
  for (const char* formulation : {"relative", "natural"}) {
    write_file(folder / "stone.yaml",
               "mimbre: 1\nbodies:\n  stone: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}\n"
               "outputs:\n  - {name: z, position: stone, component: z}\n");
    const Outcome outcome = run({"static", "stone.yaml", "--formulation", formulation});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("body 'stone' floats freely"), HasSubstr("9.81"),
                                   HasSubstr("join it to the ground")));
  }
}

const std::string bar = R"(mimbre: 1
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {rod: {type: round, diameter: 0.01}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      {material: steel, section: rod, nodes: {root: [0, 0, 0], tip: [1, 0, 0]}, bars: {bar: {from: root, to: tip}},
       clamped: [root], dynamic_modes: 2, MODES}
joints:
  foot: {type: fixed, between: [ground, bar], at: [0, 0, 0]}
loads:
  push: {on: bar.tip, force: [0, 0, 1]}
outputs:
  - {name: tip, deflection: bar.tip, along: [0, 0, 1]}
)";
std::string bar_with(const std::string& modes) {
  std::string text = bar;
  return text.replace(text.find("MODES"), 5, modes);
}

TEST_F(Messages, ALoadWhereNoStaticModeIsIsToldBeforeTheRun) {
  const Outcome outcome = of("check", bar_with("planar: [0, 1, 0]"));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("load 'push' acts on node 'tip' of body 'bar', which has no static mode"),
                    HasSubstr("add {node: tip, along: [..]}")));
  EXPECT_EQ(of("check", bar_with("static_modes: [{node: tip, along: [0, 0, 1]}]")).err, "");
}

/// A choice between forces is no choice between words.
TEST_F(Messages, ASpringsForceMayChoose) {
  const Outcome outcome = of("run", arm + R"(springs:
  rope: {between: [ground, arm], at: [[0, 0, 3], [0, 0, 0]], force: "l > 2.9 ? 1000*(l - 2.9) : 0"}
outputs:
  - {name: force, spring_force: rope}
simulation: {step: 0.01, end: 0.1}
)");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(Messages, AMistakeInATemplateIsSaidOnce) {
  const Outcome outcome = of("check", R"(mimbre: 1
subsystems:
  corner:
    bodies: {hub: {mass: -3, com: [0, 0, 0], inertia: [1, 1, 1]}}
    joints: {pin: {type: revolute, between: [ground, hup], at: [0, 0, 0], axis: [0, 1, 0]}}
instances:
  left: {of: corner}
  right: {of: corner, mirror: y}
  rear: {of: corner}
)");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(count(outcome.err, "error: "), 2u) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("body 'left.hub': mass: -3 is negative"),
                                 HasSubstr("(likewise in right, rear)"), HasSubstr("did you mean 'hub'")));
}

TEST_F(Messages, TheEndThatIsNotGivenIsSaid) {
  const Outcome outcome = of("check", arm + "outputs:\n  - {name: x, position: arm, component: x}\n");
  EXPECT_THAT(outcome.out, HasSubstr("simulated time"));
  EXPECT_THAT(outcome.out, HasSubstr("10  s"));
}

/// What a terminal obeys does not reach it, from names, titles, paths or parameters.
TEST_F(Messages, EscapeSequencesAreShownNotObeyed) {
  for (const Outcome& outcome :
       {of("check", "mimbre: 1\ntitle: \"\\e[31mred\"\n" + arm.substr(10)),
        of("check", "mimbre: 1\n\"\\e[2J\": 1\n"), run({"check", "\x1b[2Jmodel.yaml"}),
        run({"check", "model.yaml", "--set", "\x1b[2J=1"}),
        run({"check", "model.yaml", "--json", "--set", "\xC2\x9B=1"})}) {
    EXPECT_THAT(outcome.err + outcome.out, Not(HasSubstr("\x1b")));
    EXPECT_THAT(outcome.err + outcome.out, Not(HasSubstr("\xC2\x9B")));
  }
}

TEST_F(Messages, TheTableHasHarmlessNamesAndUnitsWhereTheyAreWanted) {
  std::string text = hinge("revolute");
  text.replace(text.find("name: angle"), 11, "name: \"=cmd|' /C calc'!A0\"");
  write_file(folder / "model.yaml", text);
  ASSERT_EQ(run({"run", "model.yaml", "--csv", "a.csv", "-q"}).code, 0);
  EXPECT_THAT(read_file(folder / "a.csv"), testing::StartsWith("t,'=cmd|' /C calc'!A0\n0,"));
  ASSERT_EQ(run({"run", "model.yaml", "--csv", "b.csv", "--csv-units", "-q"}).code, 0);
  EXPECT_THAT(read_file(folder / "b.csv"), testing::StartsWith("t,'=cmd|' /C calc'!A0\ns,rad\n0,"));
}

/// As `mimbre run … | grep energy` has it.
TEST_F(Messages, TheSummaryIsOnTheStandardOutput) {
  const Outcome outcome = of("run", hinge("revolute"));
  EXPECT_THAT(outcome.out, HasSubstr("energy, kinetic"));
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(run({"run", "model.yaml", "-q"}).out, "");
}

TEST_F(Messages, ResultsAreNoModelFile) {
  write_file(folder / "model.yaml", hinge("revolute"));
  ASSERT_EQ(run({"run", "model.yaml", "-o", "a.h5", "-q"}).code, 0);
  const Outcome outcome = run({"run", "a.h5"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("a.h5: error: is an HDF5 file"));
}

TEST_F(Messages, ASpringThatActsOnOneRigidBodyOnlyIsWarnedOf) {
  EXPECT_THAT(
      of("check", hinge("revolute") + "springs:\n  coil: {between: [arm, arm], at: [[0, 0, 0], [1, 0, 0]], "
                                      "elastic: {stiffness: 10}}\n")
          .err,
      HasSubstr("spring 'coil' has both ends on the rigid body 'arm'"));
}

/// With `--json` or without, an output that cannot be written is told before the work and with one code.
TEST_F(Messages, AnUnwritableOutputHasOneExitCode) {
  write_file(folder / "model.yaml", hinge("revolute"));
  ASSERT_EQ(run({"run", "model.yaml", "-o", "a.h5", "-q"}).code, 0);
  const fs::path examples = fs::path(MIMBRE_SOURCE_DIR) / "examples/solid-arm";
  const std::string body = (examples / "arm.h5").string(),
                    suspension = (examples / "suspension.yaml").string();
  const std::string mesh = (fs::path(MIMBRE_SOURCE_DIR) / "tests/data/gmsh/block-22.msh").string();
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"run", "model.yaml", "-o", "no/a.h5"},
           {"run", "model.yaml", "--csv", "no/a.csv"},
           {"report", "a.h5", "-o", "no/a.html"},
           {"export", "a.h5", "--vtk", "a.h5/frames"},
           {"convert", body, "--to", "fem", "-o", "no/b.fem"},
           {"convert", body, "--to", "h5", "-o", "no/b.h5"},
           {"convert", body, "--to", "h5", "-o", "/dev/null"},
           {"select", suspension, "--body", "front_left.arm", "-o", "no/b.h5"},
           {"select", suspension, "--body", "front_left.arm", "-o", "/dev/null"},
           {"reduce", mesh, "--material", "2.1e11,0.3,7850", "--interface", "left=group:left", "--modes", "1",
            "--no-cache", "-o", "no/b.h5"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 3) << arguments[0] << ": " << outcome.err;
    EXPECT_THAT(outcome.err, AnyOf(HasSubstr("cannot write"), HasSubstr("cannot make the folder")))
        << arguments[0];
  }
}

}  // namespace
}  // namespace mimbre::app_test
