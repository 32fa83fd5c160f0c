#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "math/once/decompositions.h"
#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"
#include "support/probe.h"

/// Frames of bars that branch, cut into substructures or made of corotational beams.
namespace mimbre::test::tree_of_beams_test {
namespace {

using Eigen::Vector3d;
using Formulation = spec::Simulation::Formulation;

RunOptions with(Formulation formulation) {
  RunOptions o;
  o.formulation = formulation;
  return o;
}

StaticResult rest(const std::string& text, Formulation formulation = Formulation::relative) {
  return static_equilibrium(model_of(text), with(formulation));
}

double value(const StaticResult& r, const std::string& channel) {
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    if (r.channels[k].name == channel) return r.values[static_cast<Eigen::Index>(k)];
  ADD_FAILURE() << "no channel " << channel;
  return std::nan("");
}

Vector3d vector(const StaticResult& r, const std::string& name) {
  return {value(r, name + ".x"), value(r, name + ".y"), value(r, name + ".z")};
}

std::string vector_output(const std::string& name, const std::string& what) {
  std::string text;
  for (const char* component : {"x", "y", "z"})
    text += "  - {name: " + name + "." + component + ", " + what + ", component: " + component + "}\n";
  return text;
}

/// Force and moment of the wall on the frame, at the wall.
const std::string reactions = [] {
  std::string text;
  for (const char* a : {"f", "m"})
    for (const char* b : {"x", "y", "z"})
      text += std::string("  - {name: ") + a + "." + b + ", joint_force: wall, component: " + a + b + "}\n";
  return text;
}();

std::string body(const std::string& flexible, const std::string& gravity = "[0, 0, 0]") {
  return "gravity: " + gravity + R"(
materials: {m: {young: 1e10, poisson: 0.3, density: 1000}}
sections: {s: {area: 1.2e-3, Iy: 1e-8, Iz: 2e-8, J: 3e-8}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: m
      section: s
)" + flexible;
}

const std::string wall = "joints: {wall: {type: bracket, between: [ground, beam], at: [0, 0, 0]}}\n";

const std::string corotational = "      beam: corotational\n";

/// A stem that forks into two arms; from one of them a seat hangs.
std::string fork(const std::string& more, int elements = 2, const std::string& gravity = "[0, 0, 0]") {
  const std::string n = std::to_string(elements);
  return body(R"(      nodes:
        fork: [0.6, 0, 0]
        root: [0, 0, 0]
        left: [1, 0.4, 0]
        right: [0.9, -0.3, 0.2]
        seat: {at: [0.8, 0.3, 0.1], on: [left, 0.5]}
      bars:
        left: {from: fork, to: left, elements: )" +
                  n + R"(}
        stem: {from: root, to: fork, elements: )" +
                  std::to_string(2 * elements) + R"(}
        right: {from: right, to: fork, elements: )" +
                  n + R"(}
      clamped: [root]
)" + more,
              gravity) +
         wall;
}

/// With all the motions of the mesh: static ones of the tips, dynamic ones of all else.
std::string all_motions(int dynamic) {
  return "      static_modes: [{node: left, all: true}, {node: right, all: true}]\n"
         "      dynamic_modes: " +
         std::to_string(dynamic) + "\n";
}
const std::string whole_fork = all_motions(36);
/// Stem, stem, left, right; six motions of the one node within each.
const std::string cut_fork = all_motions(6) + "      substructures: 4\n";

TEST(TreeOfBeams, IsCutWhereItBranches) {
  const auto model = model_of(fork(cut_fork) + "outputs:\n" + vector_output("seat", "position: beam.seat") +
                              "  - {name: far, modal_amplitude: beam, component: 40}\n");
  const spec::Model& spec = model->spec();
  ASSERT_EQ(spec.bodies.size(), 4u);
  const std::vector<std::string> names{"beam", "beam.2", "beam.3", "beam.4"};
  const std::vector<Vector3d> places{{0, 0, 0}, {0.3, 0, 0}, {0.6, 0, 0}, {0.6, 0, 0}};
  double mass = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(spec.bodies[k].name, names[k]);
    EXPECT_LT((spec.bodies[k].pose.position - places[k]).norm(), 1e-12);
    EXPECT_EQ(spec.bodies[k].flexible->modes, 12);
    mass += spec.bodies[k].flexible->mass;
  }
  EXPECT_NEAR(mass, 1.2 * (0.6 + std::sqrt(0.32) + std::sqrt(0.22)), 1e-12);
  EXPECT_EQ(spec.frames[static_cast<std::size_t>(spec.outputs[0].item)].body, 2);
  EXPECT_EQ(spec.outputs[3].item, 3);
  EXPECT_EQ(spec.outputs[3].component, 4);
}

/// Frequencies of small vibrations about the assembled position, from matrices of the relative formulation;
/// with loops, of the motions that keep them closed.
Eigen::VectorXd frequencies(const Model& model) {
  Probe p(model.compiled());
  const VectorXd q = VectorXd::Zero(p.m.positions);
  const MatrixXd M = p.matrix(q, p.zero, {0, 0, 0}), K = p.matrix(q, p.zero, {0, 1, 0}) - M;
  MatrixXd N = MatrixXd::Identity(p.n, p.n);
  if (p.equations > 0) N = null_space(p.jacobian(q), 1e-12);
  const MatrixXd m = N.transpose() * M * N, k = N.transpose() * K * N;
  return symmetric_eigenvalues(0.5 * (k + k.transpose()), 0.5 * (m + m.transpose())).cwiseMax(0).cwiseSqrt();
}

void expect_the_frequencies_of(const std::string& whole, const std::string& cut, Eigen::Index count) {
  const auto one = model_of(whole);
  const Eigen::VectorXd expected = one->spec().bodies[0].flexible->eigenfrequencies,
                        found = frequencies(*model_of(cut));
  ASSERT_GE(expected.size(), count);
  ASSERT_GE(found.size(), count);
  for (Eigen::Index k = 0; k < count; ++k) EXPECT_NEAR(found[k] / expected[k], 1, 1e-6) << k;
}

TEST(TreeOfBeams, PiecesVibrateLikeTheWhole) {
  expect_the_frequencies_of(fork(whole_fork), fork(cut_fork), 30);
}

/// How places answer to small loads: the odd part, as large rotations show in the even one.
Eigen::VectorXd answer(const std::string& model, const std::vector<std::string>& nodes,
                       Formulation formulation) {
  const auto at = [&](double sign) {
    std::string text = model + "loads:\n", outputs = "outputs:\n";
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const std::string size = std::to_string(sign * 0.01 * (1 + static_cast<double>(k)));
      text += "  " + nodes[k] + ": {on: beam." + nodes[k] + ", force: [" + size + ", " + size + ", " + size +
              "], moment: [0, " + size + ", 0]}\n";
      outputs += vector_output(nodes[k], "displacement: beam." + nodes[k] + ", relative_to: beam");
      outputs += "  - {name: " + nodes[k] + ".skew, deflection: beam." + nodes[k] + ", along: [1, 2, 3]}\n";
    }
    const StaticResult r = rest(text + outputs, formulation);
    return Eigen::VectorXd(r.values.head(r.output_count));
  };
  return 0.5 * (at(1) - at(-1));
}

TEST(TreeOfBeams, PiecesBendLikeTheWholeUnderSmallLoads) {
  const std::vector<std::string> nodes{"left", "right", "seat", "fork"};
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    const Eigen::VectorXd expected = answer(fork(whole_fork), nodes, formulation),
                          found = answer(fork(cut_fork), nodes, formulation);
    ASSERT_EQ(found.size(), 16);
    EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
    EXPECT_GT(expected.norm(), 1e-5);
  }
}

const std::vector<std::pair<std::string, Vector3d>> pull{
    {"left", {-150, 250, 100}}, {"right", {-100, 50, -125}}, {"seat", {0, 0, -75}}};

/// The loads to the scale, with a moment besides, and where the nodes go.
std::string pulled(double scale) {
  std::string text = "loads:\n  twist: {on: beam.left, moment: [0, 0, " + std::to_string(15 * scale) + "]}\n",
              outputs = "outputs:\n" + reactions;
  for (const auto& [node, force] : pull) {
    const Vector3d f = scale * force;
    text += "  " + node + ": {on: beam." + node + ", force: [" + std::to_string(f[0]) + ", " +
            std::to_string(f[1]) + ", " + std::to_string(f[2]) + "]}\n";
    outputs += vector_output(node, "position: beam." + node);
  }
  return text + outputs;
}

/// The wall holds the loads where they have moved to.
void expect_balance(const StaticResult& r, double scale) {
  Vector3d force = Vector3d::Zero(), moment(0, 0, 15 * scale);
  for (const auto& [node, load] : pull) {
    force += scale * load;
    moment += vector(r, node).cross(scale * load);
  }
  EXPECT_LT((vector(r, "f") + force).norm(), 1e-6 * force.norm());
  EXPECT_LT((vector(r, "m") + moment).norm(), 1e-6 * moment.norm());
}

TEST(TreeOfBeams, TheWallHoldsACorotationalForkFarFromItsShape) {
  const StaticResult r = rest(fork(corotational, 4) + pulled(1));
  EXPECT_GT((vector(r, "left") - Vector3d(1, 0.4, 0)).norm(), 0.5);
  expect_balance(r, 1);
}

TEST(TreeOfBeams, CorotationalForkRestsAlikeInBothCoordinates) {
  const std::string text = fork(corotational, 2) + pulled(0.3);
  const StaticResult r = rest(text), n = rest(text, Formulation::natural);
  EXPECT_GT((vector(r, "left") - Vector3d(1, 0.4, 0)).norm(), 0.2);
  expect_balance(r, 0.3);
  expect_balance(n, 0.3);
  for (const std::string name : {"left", "right", "seat"})
    EXPECT_LT((vector(n, name) - vector(r, name)).norm(), 1e-6) << name;
}

TEST(TreeOfBeams, CorotationalForkConvergesWithItsElements) {
  std::vector<Vector3d> tips;
  for (const int elements : {2, 4, 8})
    tips.push_back(vector(rest(fork(corotational, elements) + pulled(1)), "left"));
  EXPECT_LT((tips[2] - tips[1]).norm(), 2e-3);
  EXPECT_GT((tips[1] - tips[0]).norm() / (tips[2] - tips[1]).norm(), 3);
}

/// Shaken at `node`, by relative and by natural coordinates; the outputs are places.
void expect_alike_in_both_coordinates(const std::string& frame, const std::string& node,
                                      const std::string& outputs) {
  const auto model = model_of(frame + "loads:\n  shake: {on: beam." + node +
                              ", force: [0, 0, 300], scale: \"sin(20*t)\"}\noutputs:\n" + outputs +
                              "simulation: {step: 5e-4, end: 0.1}\n");
  Simulation relative(model, with(Formulation::relative)), natural(model, with(Formulation::natural));
  ResultsRow a, b;
  relative.sample(a);
  const Eigen::VectorXd start = Eigen::Map<const Eigen::VectorXd>(a.channels.data(), relative.output_count());
  double largest = 0, difference = 0;
  while (relative.time() < 0.1 - 1e-9) {
    ASSERT_TRUE(relative.step().ok());
    ASSERT_TRUE(natural.step().ok());
    relative.sample(a);
    natural.sample(b);
    const Eigen::Map<const Eigen::VectorXd> r(a.channels.data(), start.size()),
        n(b.channels.data(), start.size());
    difference = std::max(difference, (r - n).cwiseAbs().maxCoeff());
    largest = std::max(largest, (r - start).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(largest, 0.2);
  EXPECT_LT(difference, 5e-4 * largest);
}

TEST(TreeOfBeams, CorotationalForkMovesAlikeInBothCoordinates) {
  expect_alike_in_both_coordinates(fork(corotational, 2, "[0, 0, -9.81]"), "left",
                                   vector_output("left", "position: beam.left") +
                                       vector_output("right", "position: beam.right") +
                                       vector_output("seat", "position: beam.seat"));
}

/// A beam that is held in its middle is two cantilevers.
TEST(TreeOfBeams, ClampedInTheMiddle) {
  const std::string both = body(R"(      nodes: {a: [-1, 0, 0], middle: {on: [bar, 0.5]}, b: [1, 0, 0]}
      bars: {bar: {from: a, to: b, elements: 12}}
      clamped: [middle]
)" + corotational) + wall +
                           R"(loads:
  a: {on: beam.a, force: [0, 300, 100]}
  b: {on: beam.b, force: [-100, 0, 200]}
outputs:
)" + vector_output("a", "position: beam.a") +
                           vector_output("b", "position: beam.b") + reactions;
  const auto cantilever = [&](const std::string& name, const std::string& place, const std::string& force) {
    return rest(
        body("      nodes: {" + name + ": " + place +
             ", root: [0, 0, 0]}\n      bars: {bar: {from: " + (name == "a" ? "a, to: root" : "root, to: b") +
             ", elements: 6}}\n      clamped: [root]\n" + corotational) +
        wall + "loads: {end: {on: beam." + name + ", force: " + force + "}}\noutputs:\n" +
        vector_output(name, "position: beam." + name) + reactions);
  };
  const StaticResult all = rest(both), a = cantilever("a", "[-1, 0, 0]", "[0, 300, 100]"),
                     b = cantilever("b", "[1, 0, 0]", "[-100, 0, 200]");
  EXPECT_GT(vector(a, "a").y(), 0.2);
  EXPECT_LT((vector(all, "a") - vector(a, "a")).norm(), 1e-8);
  EXPECT_LT((vector(all, "b") - vector(b, "b")).norm(), 1e-8);
  EXPECT_LT((vector(all, "f") - vector(a, "f") - vector(b, "f")).norm(), 1e-4);
  EXPECT_LT((vector(all, "m") - vector(a, "m") - vector(b, "m")).norm(), 1e-4);
}

/// A bay of a frame with a strut beyond it: the bars close a loop.
std::string bay(const std::string& more) {
  return body(
             R"(      nodes: {root: [0, 0, 0], a: [0.5, 0, 0], b: [0.5, 0.4, 0.1], c: [0, 0.4, 0], d: [0.9, 0.5, 0]}
      bars:
        ra: {from: root, to: a, elements: 2}
        ab: {from: a, to: b, elements: 2}
        bc: {from: b, to: c, elements: 2}
        ca: {from: c, to: a, elements: 2}
        bd: {from: b, to: d, elements: 2}
      clamped: [root]
)" + more) +
         wall;
}
const std::string whole_bay = "      static_modes: [{node: d, all: true}]\n      dynamic_modes: 48\n";
/// root–a, a–b, b–c, c–a, b–d: the line b–c–a is cut into two.
const std::string cut_bay =
    "      static_modes: [{node: d, all: true}]\n      dynamic_modes: 6\n      substructures: 5\n";

TEST(LoopOfBeams, ABracketClosesIt) {
  const auto model = model_of(bay(cut_bay));
  std::vector<std::string> joints;
  for (const Model::JointLine& line : model->joint_lines()) {
    joints.push_back(line.name);
    EXPECT_EQ(line.cut, line.name == "beam.4.closing") << line.name;
  }
  EXPECT_THAT(joints, testing::UnorderedElementsAre("wall", "beam.2.bracket", "beam.3.bracket",
                                                    "beam.4.bracket", "beam.5.bracket", "beam.4.closing"));
}

TEST(LoopOfBeams, PiecesVibrateLikeTheWhole) { expect_the_frequencies_of(bay(whole_bay), bay(cut_bay), 30); }

TEST(LoopOfBeams, PiecesBendLikeTheWholeUnderSmallLoads) {
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    const Eigen::VectorXd expected = answer(bay(whole_bay), {"a", "b", "c", "d"}, formulation),
                          found = answer(bay(cut_bay), {"a", "b", "c", "d"}, formulation);
    EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(LoopOfBeams, CorotationalBayMovesAlikeInBothCoordinates) {
  expect_alike_in_both_coordinates(
      bay(corotational), "d",
      vector_output("c", "position: beam.c") + vector_output("d", "position: beam.d"));
}

/// A frame held in the middle of its sill, its lintel pressed down: the loop comes back to the clamped node.
std::string door(const std::string& more) {
  return body(
             R"(      nodes: {root: {at: [0, 0, 0], on: [sill, 0.5]}, a: [-0.5, 0, 0], b: [0.5, 0, 0], c: [0.5, 0.8, 0], d: [-0.5, 0.8, 0],
              top: {on: [lintel, 0.5]}}
      bars:
        sill: {from: a, to: b, elements: 6}
        right: {from: b, to: c, elements: 6}
        lintel: {from: c, to: d, elements: 6}
        left: {from: d, to: a, elements: 6}
      clamped: [root]
      beam: corotational
)" + more) +
         wall + "loads: {press: {on: beam.top, force: [0, -600, 0]}}\noutputs:\n" +
         vector_output("a", "position: beam.a") + vector_output("b", "position: beam.b") +
         vector_output("c", "position: beam.c") + vector_output("d", "position: beam.d") +
         vector_output("top", "position: beam.top") + reactions;
}

TEST(LoopOfBeams, CorotationalFrameBendsSymmetrically) {
  const StaticResult space = rest(door("")), plane = rest(door("      planar: [0, 0, 1]\n")),
                     natural = rest(door("      planar: [0, 0, 1]\n"), Formulation::natural);
  const Vector3d top = vector(space, "top");
  EXPECT_LT(top.y(), 0.73);
  EXPECT_NEAR(top.x(), 0, 1e-4);  // the elements' own error: each sees itself from one of its ends
  for (const auto& [left, right] : {std::pair("a", "b"), std::pair("d", "c")}) {
    const Vector3d l = vector(space, left), r = vector(space, right);
    EXPECT_LT((l + Vector3d(r.x(), -r.y(), -r.z())).norm(), 1e-4) << left;
  }
  EXPECT_LT((vector(space, "f") - Vector3d(0, 600, 0)).norm(), 1e-3);
  EXPECT_LT((vector(space, "m") + top.cross(Vector3d(0, -600, 0))).norm(), 1e-3);
  for (const StaticResult* other : {&plane, &natural})
    for (const std::string node : {"a", "b", "c", "d", "top"})
      EXPECT_LT((vector(*other, node) - vector(space, node)).norm(), 1e-6) << node;
}

}  // namespace
}  // namespace mimbre::test::tree_of_beams_test
