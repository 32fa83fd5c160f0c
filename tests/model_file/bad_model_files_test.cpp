#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "mimbre/model_file.h"

/// Every kind of mistake is reported at its line, in words that say what is wrong and what would be right.
namespace mimbre::bad_model_files_test {
namespace {

struct Mistake {
  std::string name;
  int line;
  std::vector<std::string> words;
  std::string text;
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

std::vector<Diagnostic> errors_of(const std::string& text,
                                  const std::map<std::string, std::string>& overrides = {}) {
  try {
    parse_model(text, "bad.yaml", "", overrides);
  } catch (const InputError& error) {
    return error.diagnostics();
  }
  return {};
}

class BadModelFile : public testing::TestWithParam<Mistake> {};

TEST_P(BadModelFile, IsReportedAtItsLine) {
  const Mistake& mistake = GetParam();
  const auto errors = errors_of(mistake.text);
  bool found = false;
  std::string all;
  for (const Diagnostic& error : errors) {
    all += to_string(error) + "\n";
    bool fits = error.mark.line == mistake.line && (error.mark.line == 0 || error.mark.column > 0);
    for (const std::string& word : mistake.words)
      fits = fits && error.message.find(word) != std::string::npos;
    found = found || fits;
  }
  EXPECT_TRUE(found) << "expected line " << mistake.line << ", got:\n" << all;
  EXPECT_LE(errors.size(), 2u) << "one mistake must not bring a flood:\n" << all;
}

/// Bodies that are refused are no lack of bodies; none are one, whatever else is wrong.
TEST(BadModelFiles, BodiesThatAreRefusedAreNotMissing) {
  const auto refused = errors_of("mimbre: 1\nbodies:\n  a/b: {mass: 1, com: [0, 0, 0]}\n  -c: {}\n");
  ASSERT_EQ(refused.size(), 2u);
  EXPECT_NE(refused[0].message.find("'a/b' is no name for a body"), std::string::npos);
  EXPECT_NE(refused[1].message.find("'-c' is no name for a body"), std::string::npos);
  EXPECT_EQ(errors_of("mimbre: 1\nbodies: [a]\n").size(), 1u);
  EXPECT_EQ(errors_of("mimbre: 1\nbodies: {}\nsprung: {}\n").size(), 2u);
  EXPECT_EQ(errors_of("mimbre: 1\nsprung: {}\n").size(), 2u);
}

/// Names in formulas have the letters of ASCII alone, and the messages tell which.
TEST(BadModelFiles, LettersOfNamesInFormulasAreToldApart) {
  for (const char* section : {"parameters: {größe: 1}", "inputs: {größe: 1}", "signals: {größe: '1'}"}) {
    const auto errors = errors_of(std::string("mimbre: 1\n") + section +
                                  "\nbodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\n");
    ASSERT_EQ(errors.size(), 1u) << section;
    EXPECT_NE(errors[0].message.find("has letters from a to z and A to Z, digits and '_' only"),
              std::string::npos)
        << errors[0].message;
  }
}

/// A sound model; the line after it is 7.
const std::string sound =
    "mimbre: 1\n"
    "bodies:\n"
    "  arm: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}\n"
    "  leg: {mass: 2, com: [1, 0, 0], inertia: [1, 1, 1]}\n"
    "frames:\n"
    "  arm.tip: {body: arm, at: [1, 0, 0]}\n";

/// A sound model with a flexible bar; line 7 begins its nodes.
std::string bar(const std::string& nodes, const std::string& bars, const std::string& rest) {
  return "mimbre: 1\nmaterials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\n"
         "sections: {rod: {type: round, diameter: 0.01}}\nbodies:\n  bar:\n    frame: {at: [0, 0, 0]}\n    "
         "flexible:\n"
         "      material: steel\n      section: rod\n      nodes: " +
         nodes + "\n      bars: " + bars + "\n" + rest;
}
const std::string two_nodes = "{a: [0, 0, 0], b: [1, 0, 0]}";
const std::string one_bar = "{bar: {from: a, to: b, elements: 4}}";
const std::string modes = "      clamped: [a]\n      static_modes: [{node: b, along: [0, 0, 1]}]\n";

std::string body(const std::string& description) {
  return "mimbre: 1\nbodies:\n  arm: " + description + "\n";
}
std::string joint(const std::string& description) {
  return sound + "joints:\n  hinge: " + description + "\n";
}
std::string spring(const std::string& description) {
  return sound + "springs:\n  coil: " + description + "\n";
}
std::string output(const std::string& description) { return sound + "outputs:\n  - " + description + "\n"; }

INSTANTIATE_TEST_SUITE_P(
    File, BadModelFile,
    testing::Values(
        Mistake{"Empty", 1, {"empty", "mimbre: 1"}, ""}, Mistake{"OnlyComment", 1, {"empty"}, "# nothing\n"},
        Mistake{"NoMap", 1, {"keys are needed"}, "hello\n"},
        Mistake{"NoVersion", 1, {"'mimbre: 1' is missing"}, "bodies:\n  arm: {mass: 0, com: [0, 0, 0]}\n"},
        Mistake{"WrongVersion",
                1,
                {"format version 7", "version 1"},
                "mimbre: 7\nbodies:\n  arm: {mass: 0, com: [0, 0, 0]}\n"},
        Mistake{"UnbalancedBracket",
                3,
                {"not valid YAML: a '[' is not closed by ']'"},
                "mimbre: 1\nbodies: {arm: [1, 2\n"},
        Mistake{"WrongBracket",
                2,
                {"not valid YAML: a bracket is closed that is not the open one"},
                "mimbre: 1\nbodies: {arm: [1, 2}}\n"},
        Mistake{"Indentation",
                4,
                {"not valid YAML: the indentation of this line fits no key above it"},
                "mimbre: 1\nbodies:\n    arm: {mass: 1}\n   leg: {mass: 1}\n"},
        Mistake{"NoBlankBehindColon",
                3,
                {"a key cannot stand here", "line 2 needs a blank behind 'title:'"},
                "mimbre: 1\ntitle:Crane\nbodies: {}\n"},
        Mistake{"Hdf5", 0, {"is an HDF5 file", "no model file"}, "\x89HDF\r\n\x1a\n"},
        Mistake{"Tab", 3, {"a tab in the indentation"}, "mimbre: 1\nbodies:\n\tarm: {mass: 1}\n"},
        Mistake{"Latin1",
                3,
                {"byte 0xE4 is no UTF-8", "save the file as UTF-8"},
                "mimbre: 1\n# ok\ntitle: L\xE4nge\n"},
        Mistake{"Utf16",
                1,
                {"this is UTF-16", "save the file as UTF-8"},
                std::string("\xFF\xFEm\0i\0m\0b\0r\0e\0:\0 \0001\0", 20)},
        Mistake{
            "BehindAMarkOfUtf8", 2, {"'gravti'", "gravity"}, "\xEF\xBB\xBFmimbre: 1\ngravti: [0, 0, 0]\n"},
        Mistake{"Utf16WithoutMark", 1, {"this is UTF-16"}, std::string("m\0i\0m\0b\0r\0e\0", 12)},
        Mistake{"UnbalancedQuote", 3, {"not valid YAML"}, "mimbre: 1\ntitle: \"abc\n"},
        Mistake{"TooDeep", 2, {"nested deeper than"}, "mimbre: 1\ntitle: " + std::string(2000, '[') + "\n"},
        Mistake{"SelfAlias", 2, {"alias"}, "mimbre: 1\ntitle: &a [*a]\n"},
        Mistake{"SecondDocument", 3, {"second YAML document"}, "mimbre: 1\n---\nmimbre: 1\n"},
        Mistake{"DuplicateKey", 7, {"'bodies' is given twice", "line 2"}, sound + "bodies: {}\n"},
        Mistake{"UnknownSection", 7, {"unknown key 'joint'", "did you mean 'joints'"}, sound + "joint: {}\n"},
        Mistake{"NoBody", 1, {"no body"}, "mimbre: 1\n"},
        Mistake{"GravityLength",
                7,
                {"gravity", "list of 3 numbers is needed, this is 2 values; for example [0, 0, 1]"},
                sound + "gravity: [0, 0]\n"},
        Mistake{"GravityParentheses",
                7,
                {"this is a single value; write it as [0, 0, -9.81]"},
                sound + "gravity: (0, 0, -9.81)\n"},
        Mistake{"GravityDecimalComma",
                7,
                {"'-9,81 m/s^2' is a list of numbers; one is needed (with a decimal point, no comma)"},
                sound + "gravity: [0, 0, '-9,81 m/s^2']\n"},
        Mistake{"GravityTypographicMinus", 7, {"write a minus as '-'"}, sound + "gravity: [0, 0, −9.81]\n"},
        Mistake{"GravityQuotes", 7, {"quotes are \" or '"}, sound + "gravity: [0, 0, “-9.81”]\n"},
        Mistake{"GravityUnknownUnit",
                7,
                {"'t' is no unit; m/s^2 is needed here (or mm/s^2)"},
                sound + "gravity: [0, 0, 9 t]\n"},
        Mistake{"GravityUnit",
                7,
                {"gravity", "is in m/s", "m/s^2 is needed"},
                sound + "gravity: [0, 0, -9.81 m/s]\n"},
        Mistake{"GravityInfinite", 7, {"gravity", "finite"}, sound + "gravity: [0, 0, .inf]\n"},
        Mistake{"Overflow", 7, {"gravity", "finite"}, sound + "gravity: [0, 0, 10^400]\n"},
        Mistake{"DivisionByZero", 7, {"gravity", "finite"}, sound + "gravity: [0, 0, 1/0]\n"},
        Mistake{"Initial", 7, {"initial", "equilibrium", "did you mean"}, sound + "initial: equilibrum\n"}),
    [](const auto& mistake) { return mistake.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Parameters, BadModelFile,
    testing::Values(
        Mistake{"UnknownInExpression",
                7,
                {"'lenght'", "did you mean 'length'"},
                sound + "gravity: [0, 0, lenght]\nparameters: {length: 1}\n"},
        Mistake{"BrokenExpression", 7, {"no expression"}, sound + "gravity: [0, 0, 1 + ]\n"},
        Mistake{
            "PowerOfOtherLanguages", 7, {"a power is written with '^'"}, sound + "gravity: [0, 0, 3**2]\n"},
        Mistake{"UnknownFunction",
                7,
                {"no function 'sinn'", "did you mean 'sin'"},
                sound + "gravity: [0, 0, sinn(1)]\n"},
        Mistake{"NestedExpression",
                7,
                {"nested deeper"},
                sound + "gravity: [0, 0, " + std::string(200, '(') + "1" + std::string(200, ')') + "]\n"},
        Mistake{"Assignment", 7, {"'=' is no operator"}, sound + "gravity: [0, 0, pi = 3]\n"},
        Mistake{"Cyclic",
                8,
                {"parameter 'a'", "only use those above it"},
                sound + "parameters:\n  a: b + 1\n  b: a + 1\n"},
        Mistake{"Reserved", 7, {"'sin'", "taken"}, sound + "parameters: {sin: 1}\n"},
        Mistake{"ReservedVariable",
                7,
                {"'l'", "taken by expressions ('l' is a spring's length in laws)"},
                sound + "parameters: {l: 1}\ngravity: [0, 0, l/2]\n"},
        Mistake{"OutOfRange",
                7,
                {"parameter 'n'", "from 1 to 10"},
                sound + "parameters: {n: {value: 11, min: 1, max: 10}}\n"},
        Mistake{"NotWhole",
                7,
                {"parameter 'n'", "whole number"},
                sound + "parameters: {n: {value: 1.5, integer: true}}\n"},
        Mistake{"NoSuchChoice",
                7,
                {"'rgid'", "rigid, flexible", "did you mean 'rigid'"},
                sound + "parameters: {as: {value: rgid, choices: [rigid, flexible]}}\n"},
        Mistake{"UnknownDollar", 7, {"no parameter 'end'"}, sound + "title: $end\n"},
        Mistake{"Requirement",
                8,
                {"n must be odd"},
                sound + "parameters: {n: 2}\nrequire: [{that: n == 1, message: n must be odd}]\n"}),
    [](const auto& mistake) { return mistake.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Bodies, BadModelFile,
    testing::Values(
        Mistake{"UnknownKey",
                3,
                {"body 'arm'", "unknown key 'mas'", "did you mean 'mass'"},
                body("{mas: 1, mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}")},
        Mistake{"NoMass", 3, {"body 'arm'", "no mass"}, body("{com: [0, 0, 0]}")},
        Mistake{
            "NegativeMass", 3, {"mass", "negative"}, body("{mass: -1, com: [0, 0, 0], inertia: [1, 1, 1]}")},
        Mistake{
            "MassIsText", 3, {"mass", "'heavy'"}, body("{mass: heavy, com: [0, 0, 0], inertia: [1, 1, 1]}")},
        Mistake{"MassIsList", 3, {"mass", "a list"}, body("{mass: [1], com: [0, 0, 0], inertia: [1, 1, 1]}")},
        Mistake{"NoCom", 3, {"'com' is missing"}, body("{mass: 1, inertia: [1, 1, 1]}")},
        Mistake{"NoInertia", 3, {"'inertia' is missing"}, body("{mass: 1, com: [0, 0, 0]}")},
        Mistake{"InertiaNegative",
                3,
                {"not positive definite"},
                body("{mass: 1, com: [0, 0, 0], inertia: [1, 1, -1]}")},
        Mistake{"InertiaIndefinite",
                3,
                {"not positive definite"},
                body("{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1, 2, 0, 0]}")},
        Mistake{"InertiaTriangle",
                3,
                {"triangle inequality"},
                body("{mass: 1, com: [0, 0, 0], inertia: [1, 1, 3]}")},
        Mistake{
            "InertiaWithoutMass", 3, {"mass is 0"}, body("{mass: 0, com: [0, 0, 0], inertia: [1, 1, 1]}")},
        Mistake{"ZeroAxis",
                3,
                {"x", "no length"},
                body("{mass: 0, com: [0, 0, 0], frame: {at: [0, 0, 0], x: [0, 0, 0]}}")},
        Mistake{"SkewAxes",
                3,
                {"not perpendicular"},
                body("{mass: 0, com: [0, 0, 0], frame: {at: [0, 0, 0], x: [1, 0, 0], y: [1, 1, 0]}}")},
        Mistake{"BadName", 3, {"'a b'", "no name"}, "mimbre: 1\nbodies:\n  a b: {mass: 0, com: [0, 0, 0]}\n"},
        Mistake{"Ground",
                3,
                {"'ground' is the fixed world"},
                "mimbre: 1\nbodies:\n  ground: {mass: 0, com: [0, 0, 0]}\n"},
        Mistake{"FrameNamedLikeBody",
                6,
                {"'arm'", "share"},
                sound.substr(0, sound.find("  arm.tip")) + "  arm: {body: leg, at: [1, 0, 0]}\n"},
        Mistake{"FrameOnUnknownBody",
                7,
                {"no body 'amr'", "did you mean 'arm'"},
                sound + "  x1: {body: amr, at: [0, 0, 0]}\n"},
        Mistake{"FlexibleMissing", 3, {"no 'flexible'"}, body("{as: flexible, mass: 0, com: [0, 0, 0]}")},
        Mistake{"Undecided",
                6,
                {"choose one"},
                bar(two_nodes, one_bar, modes + "    mass: 1\n    com: [0, 0, 0]\n    inertia: [1, 1, 1]\n")},
        Mistake{"ShapeSize", 3, {"not positive"}, body("{mass: 0, com: [0, 0, 0], shapes: [{sphere: -1}]}")},
        Mistake{
            "ReducedWithoutFolder", 3, {"no folder"}, body("{frame: {at: [0, 0, 0]}, reduced: blade.h5}")}),
    [](const auto& mistake) { return mistake.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Flexible, BadModelFile,
    testing::Values(
        Mistake{"UnknownNode", 11, {"no node 'c'", "a, b"}, bar(two_nodes, "{bar: {from: a, to: c}}", modes)},
        Mistake{"UnusedNode",
                10,
                {"'c' is on no bar"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0]}", one_bar, modes)},
        Mistake{"BarWithoutLength", 11, {"no length"}, bar("{a: [0, 0, 0], b: [0, 0, 0]}", one_bar, modes)},
        Mistake{"BarFromNodeOnLaterBar",
                11,
                {"'c' lies on a bar that comes further down"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: {on: [bar, 0.5]}, d: [1, 1, 0]}",
                    "{rod: {from: c, to: d}, bar: {from: a, to: b}}", modes)},
        Mistake{"UnknownBar",
                10,
                {"no bar 'rod'"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: {on: [rod, 0.5]}}", one_bar, modes)},
        Mistake{"FractionOutside",
                10,
                {"between 0 and 1"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: {on: [bar, 1.5]}}", one_bar, modes)},
        Mistake{"EndOfALaterBar",
                11,
                {"'e' is an end of bar 'bar', which comes further down"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], e: {on: [bar, 1]}, d: [1, 1, 0]}",
                    "{rod: {from: e, to: d}, bar: {from: a, to: b}}", modes)},
        Mistake{"EndOfAnUnknownBar",
                10,
                {"no bar 'rod'"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], e: {on: [rod, 1]}}", one_bar, modes)},
        Mistake{"EndWithAPlace",
                10,
                {"the end of a bar has its place already"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], e: {on: [bar, 1], at: [1, 1, 0]}}", one_bar, modes)},
        Mistake{"StaticModeWhen",
                13,
                {"'maybe' is neither true nor false"},
                bar(two_nodes, one_bar,
                    "      clamped: [a]\n      static_modes: [{node: b, along: [0, 0, 1], when: maybe}]\n")},
        Mistake{"TooManyElements",
                11,
                {"whole number from 1 to"},
                bar(two_nodes, "{bar: {from: a, to: b, elements: 1e6}}", modes)},
        Mistake{"UnknownSection",
                11,
                {"no section 'rood'", "did you mean 'rod'"},
                bar(two_nodes, "{bar: {from: a, to: b, section: rood}}", modes)},
        Mistake{"NothingClamped",
                12,
                {"names no node"},
                bar(two_nodes, one_bar, "      clamped: []\n      dynamic_modes: 1\n")},
        Mistake{"ModeOnClamped",
                13,
                {"'a' is clamped"},
                bar(two_nodes, one_bar,
                    "      clamped: [a]\n      static_modes: [{node: a, along: [0, 0, 1]}]\n")},
        Mistake{"NoModes", 8, {"no modes"}, bar(two_nodes, one_bar, "      clamped: [a]\n")},
        Mistake{"DependentModes",
                8,
                {"dependent"},
                bar(two_nodes, one_bar,
                    "      clamped: [a]\n      static_modes: [{node: b, along: [0, 0, 1]}, {node: b, along: "
                    "[0, 0, 1]}]\n")},
        Mistake{"LooseBar",
                8,
                {"not held"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0], d: [3, 0, 0]}",
                    "{bar: {from: a, to: b}, loose: {from: c, to: d}}", modes)},
        Mistake{"SkewPlane",
                14,
                {"axis of the body's frame"},
                bar(two_nodes, one_bar, modes + "      planar: [0, 1, 1]\n")},
        Mistake{"UnknownStiffening",
                14,
                {"'foreshorten' is not one of", "linear, foreshortening"},
                bar(two_nodes, one_bar, modes + "      stiffening: foreshorten\n")},
        Mistake{"AxialModesOfTwoBars",
                14,
                {"one straight bar", "has 2 bars"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0]}",
                    "{bar: {from: a, to: b}, more: {from: b, to: c}}", modes + "      axial_modes: 1\n")},
        Mistake{"AxialModesBetweenClamps",
                14,
                {"one straight bar", "several nodes are"},
                bar("{a: [0, 0, 0], b: {on: [bar, 0.5]}, c: [2, 0, 0]}", "{bar: {from: a, to: c}}",
                    "      clamped: [a, c]\n      static_modes: [{node: b, along: [0, 0, 1]}]\n      "
                    "axial_modes: 1\n")},
        Mistake{"TooFewSubstructuresOfATree",
                15,
                {"2 substructures are too few: 3 are needed", "between the nodes where they branch"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0], d: [1, 1, 0]}",
                    "{bar: {from: a, to: b}, more: {from: b, to: c}, branch: {from: b, to: d}}",
                    modes + "      dynamic_modes: 1\n      substructures: 2\n")},
        Mistake{"SubstructuresBetweenClamps",
                14,
                {"clamped at one node", "here 2 are"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0]}",
                    "{bar: {from: a, to: b}, more: {from: b, to: c}}",
                    "      clamped: [a, c]\n      dynamic_modes: 1\n      substructures: 2\n")},
        Mistake{"SubstructuresOfLooseBars",
                14,
                {"not connected with the clamped node"},
                bar("{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0], d: [3, 0, 0]}",
                    "{bar: {from: a, to: b}, loose: {from: c, to: d}}", modes + "      substructures: 2\n")},
        Mistake{"MoreSubstructuresThanElements",
                14,
                {"5 substructures need as many elements; the bars have 4"},
                bar(two_nodes, one_bar, modes + "      substructures: 5\n")},
        Mistake{"ModesOfANonlinearBeam",
                14,
                {"leave out static_modes"},
                bar(two_nodes, one_bar, modes + "      beam: corotational\n")},
        Mistake{
            "AncfBeamWithoutAPlane",
            14,
            {"moves in a plane", "planar: [0, 0, 1]"},
            bar(two_nodes, one_bar, "      clamped: [a]\n      stiffness_damping: 0\n      beam: ancf\n")},
        Mistake{"UnknownBoundaryRotation",
                14,
                {"'exact' is not one of", "exponential"},
                bar(two_nodes, one_bar, modes + "      boundary_rotation: exact\n")},
        Mistake{"AxialDynamicModesOfSubstructures",
                15,
                {"for a beam in one piece"},
                bar(two_nodes, one_bar, modes + "      axial_modes: 2\n      substructures: 2\n")},
        Mistake{"NoNodeThere",
                15,
                {"no named node at [0.5, 0, 0]", "a [0, 0, 0], b [1, 0, 0]"},
                bar(two_nodes, one_bar, modes + "frames:\n  mid: {body: bar, at: [0.5, 0, 0]}\n")}),
    [](const auto& mistake) { return mistake.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Displacements, BadModelFile,
    testing::Values(
        Mistake{"RelativeToNothing",
                8,
                {"'relative_to' is missing"},
                output("{name: x, displacement: leg, component: x}")},
        Mistake{"RelativeToTheGround",
                8,
                {"name a frame of it"},
                output("{name: x, displacement: leg, relative_to: ground, component: x}")},
        Mistake{"RelativeToUnknown",
                8,
                {"no body, frame or node 'amr'", "did you mean 'arm'"},
                output("{name: x, displacement: leg, relative_to: amr, component: x}")},
        Mistake{"PositionRelativeTo",
                8,
                {"belongs to 'displacement'"},
                output("{name: x, position: leg, relative_to: arm, component: x}")},
        Mistake{"AxesOfAPosition",
                8,
                {"'axes' belongs to 'angular_velocity'"},
                output("{name: x, position: leg, axes: own, component: x}")},
        Mistake{"UnknownAxes",
                8,
                {"'body' is not one of", "global, own"},
                output("{name: x, angular_velocity: leg, axes: body, component: x}")},
        Mistake{"AboutOfALinearMomentum",
                8,
                {"'about' belongs to 'angular_momentum'"},
                output("{name: x, linear_momentum: leg, about: [0, 0, 0], component: x}")},
        Mistake{"MomentumOfAnUnknownBody",
                8,
                {"'lge'", "did you mean 'leg'"},
                output("{name: x, linear_momentum: [arm, lge], component: x}")},
        Mistake{"MomentumOfABodyTwice",
                8,
                {"body 'arm' is named twice"},
                output("{name: x, centre_of_mass: [arm, arm], component: x}")},
        Mistake{"MomentumWithoutComponent",
                8,
                {"'component' is missing"},
                output("{name: x, angular_momentum: all}")},
        Mistake{
            "MomentumWithoutMass",
            5,
            {"has no mass"},
            "mimbre: 1\nbodies: {a: {mass: 0, com: [0, 0, 0]}, b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, "
            "1]}}\njoints: {j: {type: fixed, between: [b, a]}}\noutputs:\n  - {name: x, linear_momentum: a, "
            "component: x}\n"}),
    [](const auto& mistake) { return mistake.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Joints, BadModelFile,
    testing::Values(
        Mistake{"UnknownType",
                8,
                {"joint 'hinge'", "'revolut'", "did you mean 'revolute'"},
                joint("{type: revolut, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1]}")},
        Mistake{"TypeOfOtherPrograms",
                8,
                {"joint 'hinge'", "'hinge' is called 'revolute' here"},
                joint("{type: hinge, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1]}")},
        Mistake{"VariableOfAnotherLaw",
                8,
                {"'l' is no variable of this law; it depends on t"},
                joint("{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], drive: "
                      "{position: 2*l}}")},
        Mistake{"UnknownBody",
                8,
                {"'amr'", "did you mean 'arm'"},
                joint("{type: spherical, between: [ground, amr], at: [0, 0, 0]}")},
        Mistake{"Nothing", 8, {"joint 'hinge'", "'type' is missing"}, joint("")},
        Mistake{"SameBody",
                8,
                {"both sides are on body 'arm'"},
                joint("{type: spherical, between: [arm, arm.tip]}")},
        Mistake{"BothGround",
                8,
                {"both sides are the ground"},
                joint("{type: spherical, between: [ground, ground], at: [0, 0, 0]}")},
        Mistake{"OneBody",
                8,
                {"two bodies or frames"},
                joint("{type: spherical, between: [arm], at: [0, 0, 0]}")},
        Mistake{"NoPlace", 8, {"'at' is missing"}, joint("{type: spherical, between: [ground, arm]}")},
        Mistake{"NoAxis",
                8,
                {"'axis' is missing"},
                joint("{type: revolute, between: [ground, arm], at: [0, 0, 0]}")},
        Mistake{"ZeroAxis",
                8,
                {"axis", "no length"},
                joint("{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 0]}")},
        Mistake{"AxisOfSphere",
                8,
                {"spherical joint has no axis"},
                joint("{type: spherical, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1]}")},
        Mistake{"UniversalSkew",
                8,
                {"not perpendicular"},
                joint("{type: universal, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], axis2: [0, "
                      "1, 1]}")},
        Mistake{"SphericalDrive",
                8,
                {"spherical joint has no scalar coordinate"},
                joint("{type: spherical, between: [ground, arm], at: [0, 0, 0], drive: {position: t}}")},
        Mistake{"DriveUnknown",
                8,
                {"drive", "'s'"},
                joint("{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], drive: "
                      "{position: 2*s}}")},
        Mistake{"DriveByNothing",
                8,
                {"'position' or 'speed' is missing"},
                joint("{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], drive: {}}")},
        Mistake{"DriveByBoth",
                8,
                {"has both 'position' and 'speed'"},
                joint("{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], drive: "
                      "{position: t, speed: 1}}")},
        Mistake{
            "DriveAgainstTheInitialPosition",
            8,
            {"position", "0.3 contradicts the drive, which starts with 0.1; leave it out"},
            joint("{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], position: 0.3, "
                  "drive: {position: 0.1 + t}}")},
        Mistake{"DriveAgainstTheInitialSpeed",
                8,
                {"velocity", "1 contradicts the drive, which starts with 2"},
                joint("{type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], velocity: 1, "
                      "position: 0.3, drive: {speed: 2 + t}}")},
        Mistake{"WhichCoordinate",
                8,
                {"2 coordinates", "coordinate: 0"},
                joint("{type: cylindrical, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1], drive: "
                      "{position: t}}")},
        Mistake{"InitialCount",
                8,
                {"3 values", "are 2"},
                joint("{type: spherical, between: [ground, arm], at: [0, 0, 0], velocity: [1, 2]}")},
        Mistake{"FrameWithPlace",
                8,
                {"a frame has its place already"},
                joint("{type: spherical, between: [leg, arm.tip], at: [0, 0, 0]}")},
        Mistake{"Cut",
                8,
                {"cut", "'sometimes'", "automatic, never, always"},
                joint("{type: spherical, between: [ground, arm], at: [0, 0, 0], cut: sometimes}")}),
    [](const auto& mistake) { return mistake.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Forces, BadModelFile,
    testing::Values(
        Mistake{"ZeroLength",
                8,
                {"length zero"},
                spring("{between: [arm, leg], at: [[0, 0, 0], [0, 0, 0]], damping: 1}")},
        Mistake{"NoForce", 8, {"specifies no force"}, spring("{between: [arm, leg]}")},
        Mistake{
            "AmbiguousNumber", 8, {"a stiffness or a force"}, spring("{between: [arm, leg], elastic: 100}")},
        Mistake{
            "NegativeStiffness", 8, {"negative"}, spring("{between: [arm, leg], elastic: {stiffness: -1}}")},
        Mistake{"TableDescends",
                8,
                {"does not ascend"},
                spring("{between: [arm, leg], elastic: {table: [[0, 0], [2, 1], [1, 2]]}}")},
        Mistake{"TableOnePoint",
                8,
                {"at least two points"},
                spring("{between: [arm, leg], elastic: {table: [[0, 0]]}}")},
        Mistake{"PiecesDescend",
                8,
                {"do not ascend"},
                spring("{between: [arm, leg], elastic: {pieces: [{until: 1, polynomial: [0]}, {until: 0, "
                       "polynomial: [0]}, "
                       "{polynomial: [1]}]}}")},
        Mistake{"LastPiece",
                8,
                {"last piece"},
                spring("{between: [arm, leg], elastic: {pieces: [{until: 1, polynomial: [0]}]}}")},
        Mistake{"TwoLaws",
                8,
                {"several laws"},
                spring("{between: [arm, leg], elastic: {polynomial: [0], constant: 1}}")},
        Mistake{"ForceUnknown", 8, {"force", "'w'"}, spring("{between: [arm, leg], force: 2*l + w}")},
        Mistake{"LoadOnGround",
                7,
                {"ground moves nothing"},
                sound + "loads: {push: {on: ground, at: [0, 0, 0], force: [0, 0, 1]}}\n"},
        Mistake{"TyreRoad",
                7,
                {"no road 'track'"},
                sound + "tyres: {t1: {on: arm, road: track, stiffness: 1, radius: 1}}\n"},
        Mistake{"TyreModel",
                7,
                {"no model 'brsh'", "vertical, brush, magic_formula"},
                sound + "tyres: {t1: {on: arm, road: track, model: brsh, stiffness: 1, radius: 1}}\n"},
        Mistake{"TyreKeyOfAnother",
                7,
                {"belongs to 'model: brush'", "stiffness, radius"},
                sound + "tyres: {t1: {on: arm, road: track, friction: 1, stiffness: 1, radius: 1}}\n"},
        Mistake{"TyreBrush",
                7,
                {"'cornering_stiffness' is missing", "N/rad"},
                sound +
                    "tyres: {t1: {on: arm, road: track, model: brush, stiffness: 1, radius: 1, friction: 1, "
                    "longitudinal_stiffness: 1, longitudinal_relaxation: 1, lateral_relaxation: 1, "
                    "half_length: 1}}\n"},
        Mistake{"TyreFile",
                7,
                {"'file' is missing", "tyre.tir"},
                sound + "tyres: {t1: {on: arm, road: track, model: magic_formula}}\n"},
        Mistake{"RoadGrid", 7, {"one of 'heights', 'file'"}, sound + "roads: {track: {over: grid}}\n"},
        Mistake{"RoadGridPoints",
                7,
                {"belongs to a road over distance"},
                sound +
                    "roads: {track: {over: grid, points: [[0, 0], [1, 1]], origin: [0, 0], spacing: [1, 1], "
                    "heights: [[0, 0], [0, 0]]}}\n"},
        Mistake{"RoadClass",
                7,
                {"'K'", "A to H"},
                sound + "roads: {track: {over: grid, iso8608: {class: K, length: 10}}}\n"},
        Mistake{
            "RoadPatch",
            7,
            {"has no place"},
            sound + "roads: {track: {over: distance, points: [[0, 0], [5, 1]], patches: [{friction: 1}]}}\n"},
        Mistake{"RoadRepeat",
                7,
                {"shorter than the points"},
                sound + "roads: {track: {over: distance, points: [[0, 0], [5, 1]], repeat: 3}}\n"}),
    [](const auto& mistake) { return mistake.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Rest, BadModelFile,
    testing::Values(
        Mistake{"OutputNothing", 8, {"specifies nothing to measure"}, output("{name: z}")},
        Mistake{"OutputUnknownJoint", 8, {"no joint 'hing'"}, output("{name: q, joint: hing}")},
        Mistake{"OutputComponent", 8, {"'w'", "x, y, z"}, output("{name: q, position: arm, component: w}")},
        Mistake{"OutputsNoList",
                8,
                {"a list is needed, this is a map of keys; each of its items begins with '- '"},
                sound + "outputs:\n  q: {roll: arm}\n"},
        Mistake{"OutputOfTheWorld",
                8,
                {"'world' (the fixed world is called 'ground')"},
                output("{name: q, roll: world}")},
        Mistake{"OutputTwice",
                9,
                {"two outputs called 'q'; rename one"},
                output("{name: q, roll: arm}") + "  - {name: q, yaw: arm}\n"},
        Mistake{"OutputComma", 8, {"no comma"}, output("{name: 'a,b', roll: arm}")},
        Mistake{"OutputTime", 8, {"column of the time"}, output("{name: t, roll: arm}")},
        Mistake{"ModesOfRigid",
                8,
                {"rigid and has no modes"},
                output("{name: q, modal_amplitude: arm, component: 0}")},
        Mistake{"UnknownTemplate", 7, {"no subsystem 'corner'"}, sound + "instances: {left: {of: corner}}\n"},
        Mistake{"TemplateParameter",
                8,
                {"no parameter 'b'", "it has: a"},
                sound + "subsystems: {s: {parameters: {a: 1}}}\ninstances: {left: {of: s, with: {b: 1}}}\n"},
        Mistake{"Mirror",
                8,
                {"'w' is not x, y, z"},
                sound + "subsystems: {s: {}}\ninstances: {left: {of: s, mirror: w}}\n"},
        Mistake{"FileWithoutFolder", 7, {"no folder"}, sound + "subsystems: {s: {file: other.yaml}}\n"},
        Mistake{"NegativeStep", 7, {"step", "not positive"}, sound + "simulation: {step: -1}\n"},
        Mistake{"Interval",
                7,
                {"whole number of steps"},
                sound + "simulation: {step: 0.01, output_interval: 0.015}\n"},
        Mistake{"Rho",
                7,
                {"rho", "a number from 0 to 1"},
                sound + "simulation: {integrator: {type: generalized_alpha, rho: 2}}\n"},
        Mistake{"Xi", 7, {"xi", "0 or less"}, sound + "simulation: {integrator: {type: newmark, xi: 1}}\n"},
        Mistake{"RhoOfHht",
                7,
                {"rho is 0.4; hht takes 0.5 to 1"},
                sound + "simulation: {integrator: {type: hht, rho: 0.4}}\n"},
        Mistake{"RhoOfNewmark",
                7,
                {"rho belongs to generalized_alpha and hht; newmark has xi"},
                sound + "simulation: {integrator: {type: newmark, rho: 0.4}}\n"},
        Mistake{"XiOfHht",
                7,
                {"xi belongs to newmark; hht has rho"},
                sound + "simulation: {integrator: {type: hht, xi: 0}}\n"},
        Mistake{"Integrator",
                7,
                {"type", "generalized_alpha, newmark, hht", "did you mean 'newmark'?"},
                sound + "simulation: {integrator: {type: newmrk}}\n"},
        Mistake{"Inertia",
                7,
                {"inertia", "did you mean 'projection'?"},
                sound + "simulation: {inertia: projecton}\n"},
        Mistake{"Formalism",
                7,
                {"formalism",
                 "index3, index1, baumgarte, penalty, index1_augmented, independent, global_modes, "
                 "transfer_matrices"},
                sound + "simulation: {formalism: lagrange}\n"},
        Mistake{"InputNamedAsAChoice",
                8,
                {"input 'stiff'",
                 "'stiff' is a choice of parameter 'arms', and `arms == stiff` has to mean that"},
                sound + "parameters: {arms: {value: soft, choices: [soft, stiff]}}\ninputs: {stiff: 0}\n"},
        Mistake{
            "SignalNamedAsAChoice",
            8,
            {"signal 'stiff'", "is a choice of parameter 'arms'"},
            sound + "parameters: {arms: {value: soft, choices: [soft, stiff]}}\nsignals: {stiff: \"t\"}\n"},
        Mistake{"JointAndConstraintOfOneName",
                8,
                {"constraint 'slot': its ends are the frames 'slot.a' and 'slot.b', but those of joint "
                 "'slot' are "
                 "called so, too; rename one of them"},
                sound +
                    "joints: {slot: {type: revolute, between: [arm, leg], at: [0, 0, 0], axis: [0, 0, 1]}}\n"
                    "constraints: {slot: {type: on_line, between: [arm, leg], at: [0, 0, 0], axis: [1, 0, "
                    "0]}}\n"},
        Mistake{"LoadAndTyreOfOneName",
                9,
                {"load 'w' and tyre 'w' both have a frame 'w.frame' at their place; rename one of them"},
                sound + "loads: {w: {on: arm, at: [0, 0, 0], force: [0, 0, 1]}}\n"
                        "roads: {track: {over: distance, points: [[0, 0], [5, 1]]}}\n"
                        "tyres: {w: {on: arm, at: [0, 0, 0], road: track, stiffness: 1, radius: 1}}\n"},
        Mistake{"FrameWhereALoadActs",
                8,
                {"load 'w' has a frame 'w.frame' at its place, but frame 'w.frame' is there already"},
                sound + "  w.frame: {body: arm, at: [1, 0, 0]}\n"
                        "loads: {w: {on: arm, at: [0, 0, 0], force: [0, 0, 1]}}\n"},
        Mistake{
            "FrameWhereAJointEnds",
            7,
            {"joint 'arm': its ends are the frames 'arm.a' and 'arm.b', but frame 'arm.b' is there already"},
            "mimbre: 1\nbodies:\n  arm: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}\n"
            "  leg: {mass: 2, com: [1, 0, 0], inertia: [1, 1, 1]}\n"
            "frames: {arm.b: {body: arm, at: [1, 0, 0]}}\n"
            "joints:\n"
            "  arm: {type: revolute, between: [arm, leg], at: [0, 0, 0], axis: [0, 0, 1]}\n"},
        Mistake{
            "SectionWithoutTorsionModulus",
            3,
            {"goes with 'torsion_modulus'", "J over its largest thickness"},
            body("{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}")
                .insert(
                    10,
                    "sections:\n  s: {area: 1e-3, Iy: 1e-7, Iz: 2e-7, J: 1e-8, outermost: [0.025, 0.01]}\n")},
        Mistake{
            "SectionWithoutOutermostFibres",
            3,
            {"goes with 'outermost: [y, z]'"},
            body("{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}")
                .insert(
                    10,
                    "sections:\n  s: {area: 1e-3, Iy: 1e-7, Iz: 2e-7, J: 1e-8, torsion_modulus: 1e-6}\n")},
        Mistake{"OutermostFibresOfOneAxis",
                3,
                {"two distances are needed"},
                body("{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}")
                    .insert(10,
                            "sections:\n  s: {area: 1e-3, Iy: 1e-7, Iz: 2e-7, J: 1e-8, outermost: [0.02], "
                            "torsion_modulus: 1e-6}\n")},
        Mistake{
            "OutermostFibresWithinTheSection",
            3,
            {"0.009 is nearer to the axis than √(Iy/area) = 0.01 m"},
            body("{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}")
                .insert(
                    10,
                    "sections:\n  s: {area: 1e-3, Iy: 1e-7, Iz: 2e-7, J: 1e-8, outermost: [0.025, 0.009], "
                    "torsion_modulus: 1e-6}\n")},
        Mistake{
            "RestOfATorsionSpring",
            9,
            {"rest", "'tlt'"},
            sound +
                "joints: {hinge: {type: revolute, between: [arm, leg], at: [0, 0, 0], axis: [0, 0, 1]}}\n"
                "inputs: {tilt: 0}\n"
                "torsion_springs: {bar: {coordinates: [{joint: hinge}], stiffness: 10, rest: 0.1*tlt}}\n"},
        Mistake{
            "RestWithoutStiffness",
            9,
            {"rest", "belongs to 'stiffness'"},
            sound +
                "joints: {hinge: {type: revolute, between: [arm, leg], at: [0, 0, 0], axis: [0, 0, 1]}}\n"
                "inputs: {tilt: 0}\n"
                "torsion_springs: {bar: {coordinates: [{joint: hinge}], elastic: 10*x, rest: 0.1*tilt}}\n"},
        Mistake{"Formulation",
                7,
                {"formulation", "relative, natural", "did you mean 'relative'?"},
                sound + "simulation: {formulation: relativ}\n"}),
    [](const auto& mistake) { return mistake.param.name; });

TEST(BadModelFile, AllMistakesAreReportedInOrder) {
  const auto errors =
      errors_of(body("{mass: -1, com: [0, 0], inertia: [1, 1, 1]}") + "gravity: [a, b, 0]\nwrong: 1\n");
  ASSERT_EQ(errors.size(), 5u);
  for (std::size_t k = 1; k < errors.size(); ++k) EXPECT_LE(errors[k - 1].mark.line, errors[k].mark.line);
  EXPECT_EQ(errors.back().mark.line, 5);
}

TEST(BadModelFile, ColumnsCountFromOne) {
  const auto errors = errors_of(sound + "wrong: 1\n");
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors[0].mark.column, 1);
  EXPECT_EQ(errors[0].mark.file, "bad.yaml");
}

TEST(BadModelFile, UnknownOverrideListsTheValidOnes) {
  const auto errors = errors_of(sound + "parameters: {length: 1, width: 2}\n", {{"lenght", "3"}});
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(errors[0].message.find("did you mean 'length'"), std::string::npos);
  EXPECT_NE(errors[0].message.find("length, width"), std::string::npos);
}

TEST(BadModelFile, OverrideOutOfRange) {
  const auto errors = errors_of(sound + "parameters: {n: {value: 5, min: 1, max: 10}}\n", {{"n", "11"}});
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(errors[0].message.find("'n' set to '11'"), std::string::npos);
  EXPECT_NE(errors[0].message.find("from 1 to 10"), std::string::npos);
}

TEST(BadModelFile, AliasBombIsRefused) {
  std::string text = "mimbre: 1\na0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int k = 1; k < 12; ++k) {
    text += "a" + std::to_string(k) + ": &a" + std::to_string(k) + " [";
    for (int i = 0; i < 10; ++i) text += (i ? ", *a" : "*a") + std::to_string(k - 1);
    text += "]\n";
  }
  const auto errors = errors_of(text);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(errors[0].message.find("more than"), std::string::npos);
}

TEST(BadModelFile, AFloodOfErrorsEnds) {
  std::string text = "mimbre: 1\nbodies:\n";
  for (int k = 0; k < 1000; ++k) text += "  b" + std::to_string(k) + ": {mass: -1}\n";
  const auto errors = errors_of(text);
  EXPECT_LE(errors.size(), 101u);
}

TEST(BadModelFile, MistakesInATemplatesFileNameThatFile) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("mimbre_bad_template_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "side.yaml")
      << "bodies:\n  arm:\n    mass: -1\n    com: [0, 0, 0]\n    inertia: [1, 1, 1]\n";
  const std::string text =
      "mimbre: 1\nsubsystems:\n  side: {file: side.yaml}\n  other: {file: othr.yaml}\ninstances: {left: {of: "
      "side}}\n";
  try {
    parse_model(text, "bad.yaml", folder.string());
    FAIL();
  } catch (const InputError& error) {
    ASSERT_EQ(error.diagnostics().size(), 2u) << error.what();
    EXPECT_EQ(error.diagnostics()[0].mark.line, 4);
    EXPECT_NE(error.diagnostics()[0].message.find("there is no file"), std::string::npos);
    EXPECT_TRUE(error.diagnostics()[1].mark.file.ends_with("side.yaml"));
    EXPECT_EQ(error.diagnostics()[1].mark.line, 3);
    EXPECT_NE(error.diagnostics()[1].message.find("body 'left.arm': mass: -1 is negative"),
              std::string::npos);
  }
  std::filesystem::remove_all(folder);
}

TEST(BadModelFile, MissingFile) {
  try {
    load_model("/nowhere/model.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "/nowhere/model.yaml: there is no such file");
  }
}

}  // namespace
}  // namespace mimbre::bad_model_files_test
