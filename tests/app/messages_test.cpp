#include <gmock/gmock.h>

#include <tuple>

#include "app/program.h"

/// What the program says where people go wrong: in their words, by name, with what would be right; once.
namespace mimbre::app_test::messages_test {
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

/// Of all that is attached there the first thing is named; what bears no force is none of it.
TEST_F(Messages, AJointWhereNoStaticModeIsIsToldBeforeTheRun) {
  const auto with = [](const std::string& modes, const std::string& more) {
    std::string text = bar_with(modes);
    text.replace(text.find("loads:"), text.find("outputs:") - text.find("loads:"), "");
    text.insert(text.find("bodies:") + 8, "  end: {mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}\n");
    return text.insert(text.find("joints:") + 8, more);
  };
  const std::string pin = "  pin: {type: revolute, between: [bar, end], at: [1, 0, 0], axis: [0, 1, 0]}\n",
                    free = "  free: {type: floating, between: [bar.tip, end]}\n",
                    said = " acts on node 'tip' of body 'bar', which has no static mode",
                    mode = "static_modes: [{node: tip, along: [0, 0, 1]}]";
  const Outcome joined = of("check", with("planar: [0, 1, 0]", pin));
  EXPECT_EQ(joined.code, 0) << joined.err;
  EXPECT_THAT(joined.err, HasSubstr("joint 'pin'" + said));
  EXPECT_EQ(of("check", with(mode, pin)).err, "");
  EXPECT_EQ(of("check", with("planar: [0, 1, 0]", free)).err, "");
  const std::string
      rod = "constraints: {rod: {type: distance, between: [bar.tip, ground], at: [~, [1, 0, 1]]}}\n",
      mount = "bushings: {mount: {between: [bar.tip, end], stiffness: [1, 1, 1, 1, 1, 1]}}\n";
  EXPECT_THAT(of("check", with("planar: [0, 1, 0]", free) + rod).err, HasSubstr("constraint 'rod'" + said));
  const std::string both = of("check", with("planar: [0, 1, 0]", free) + mount + rod).err;
  EXPECT_THAT(both, HasSubstr("constraint 'rod'" + said));
  EXPECT_THAT(both, Not(HasSubstr("bushing")));
  EXPECT_THAT(of("check", with("planar: [0, 1, 0]", free) + mount).err, HasSubstr("bushing 'mount'" + said));
}

/// Steel in other units than SI.
TEST_F(Messages, MaterialsOfNoSolidAreAskedAbout) {
  const auto with = [](const std::string& material) {
    std::string text = bar_with("planar: [0, 1, 0], static_modes: [{node: tip, along: [0, 0, 1]}]");
    const std::string steel = "{young: 2.1e11, poisson: 0.3, density: 7850}";
    return text.replace(text.find(steel), steel.size(), material);
  };
  for (const auto& [material, young, density] :
       {std::tuple{"{young: 210000, poisson: 0.3, density: 7850}",
                   "Young's modulus 210000 Pa (is it in MPa?)", ""},
        {"{young: 210, poisson: 0.3, density: 7850}", "Young's modulus 210 Pa (is it in GPa?)", ""},
        {"{young: 2.1e11, poisson: 0.3, density: 7.85}", "", "density 7.85 kg/m³ (is it in g/cm³?)"},
        {"{young: 210000, poisson: 0.3, density: 7.85e-9}", "Young's modulus 210000 Pa (is it in MPa?)",
         "density 7.85e-09 kg/m³ (is it in t/mm³?)"},
        {"{young: 210000, poisson: 0.3, density: 7.85}", "Young's modulus 210000 Pa (is it in MPa?)",
         "density 7.85 kg/m³ (is it in g/cm³?)"}}) {
    const std::string err = of("check", with(material)).err;
    EXPECT_THAT(err,
                AllOf(HasSubstr("model.yaml:2:"), HasSubstr("warning: material 'steel': "), HasSubstr(young),
                      HasSubstr(density), HasSubstr("numbers without a unit are in Pa and kg/m³")));
    EXPECT_EQ(count(err, "is it in"), (*young ? 1u : 0u) + (*density ? 1u : 0u)) << err;
  }
  // Rubber, foam, balsa wood, tungsten, diamond, carbon fibres.
  for (const char* material :
       {"{young: 1 MPa, poisson: 0.49, density: 1100}", "{young: 3e5, poisson: 0.1, density: 20}",
        "{young: 3e9, poisson: 0.3, density: 120}", "{young: 4.1e11, poisson: 0.28, density: 19300}",
        "{young: 1.2e12, poisson: 0.1, density: 3500}", "{young: 9e11, poisson: 0.3, density: 2150}"})
    EXPECT_EQ(count(of("check", with(material)).err, "material 'steel'"), 0u) << material;
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

/// In the user's words, not in those of the options.
/// None of them wins, and none is left out, without a word.
TEST_F(Messages, OptionsThatConflictOrDoNothingAreRefused) {
  write_file(folder / "pendulum.yaml", pendulum);
  const Outcome twice = run({"run", "pendulum.yaml", "--set", "length=2", "--set", "length=3"});
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.err, HasSubstr("--set length: is given twice"));
  const Outcome units = run({"run", "pendulum.yaml", "--csv-units"});
  EXPECT_EQ(units.code, 2);
  EXPECT_THAT(units.err, HasSubstr("--csv-units belongs to --csv FILE.csv"));
}

TEST_F(Messages, WhatIsMissingOnTheCommandLineIsSaid) {
  EXPECT_THAT(run({"run"}).err, HasSubstr("error: MODEL is missing: Model file (YAML)"));
  EXPECT_THAT(run({"select", "a.yaml", "--body", "arm"}).err,
              HasSubstr("error: --output is missing: The body"));
  EXPECT_THAT(run({"export", "a.h5"}).err, HasSubstr("error: --vtk is missing: Folder for the files"));
  for (const std::vector<std::string>& files :
       {std::vector<std::string>{}, {"a.h5"}, {"a.h5", "b.h5", "c.h5"}}) {
    std::vector<std::string> arguments{"compare"};
    arguments.insert(arguments.end(), files.begin(), files.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("error: two results files are needed, the reference and the one to "));
  }
  EXPECT_THAT(run({"compare", "a.h5"}).err, HasSubstr("'a.h5' is the only one given"));
}

}  // namespace
}  // namespace mimbre::app_test::messages_test
