#include <gmock/gmock.h>

#include <algorithm>

#include "app/output_schema.h"
#include "app/program.h"

/// Stress of a meshed body in a mechanism: outputs, mimbre stress, mimbre export.
namespace mimbre::app_test::stress_test {
namespace {

using json = test::Json;
using testing::HasSubstr;

/// A bar of 1 × 0.1 × 0.05 m, clamped at one end, in gravity; `more` are further lines of its outputs.
std::string cantilever(const std::string& more) {
  return "mimbre: 1\ngravity: [0, 0, -9.81]\nbodies:\n  bar: {frame: {at: [0, 0, 0]}, reduced: bar.h5}\n"
         "joints:\n  clamp: {type: fixed, between: [ground, bar.root]}\n"
         "outputs:\n  - {name: tip, deflection: bar.tip, along: [0, 0, 1]}\n" +
         more + "initial: equilibrium\nsimulation: {step: 0.001, end: 0.01}\n";
}

std::string bar_mesh() {
  constexpr int nx = 20, ny = 2, nz = 2;
  const auto node = [](int i, int j, int k) { return 1 + i + (nx + 1) * (j + (ny + 1) * k); };
  std::ostringstream text;
  text << "*NODE\n";
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        text << node(i, j, k) << ", " << 1.0 * i / nx << ", " << 0.1 * j / ny << ", " << 0.05 * k / nz
             << "\n";
  text << "*ELEMENT, TYPE=C3D8, ELSET=all\n";
  int label = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        text << ++label;
        for (const auto& [a, b, c] : {std::array{0, 0, 0},
                                      {1, 0, 0},
                                      {1, 1, 0},
                                      {0, 1, 0},
                                      {0, 0, 1},
                                      {1, 0, 1},
                                      {1, 1, 1},
                                      {0, 1, 1}})
          text << ", " << node(i + a, j + b, k + c);
        text << "\n";
      }
  return text.str() +
         "*MATERIAL, NAME=steel\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850\n*SOLID SECTION, ELSET=all, "
         "MATERIAL=steel\n";
}

class StressOfARun : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "bar.inp", bar_mesh());
    const Outcome made = run({"reduce", "bar.inp", "--interface", "root=box(0,0,0, 0,1,1)", "--interface",
                              "tip=box(1,0,0, 1,1,1)", "--modes", "12", "--free-modes", "0", "-o", "bar.h5"});
    ASSERT_EQ(made.code, 0) << made.err;
  }
};

TEST_F(StressOfARun, IsThatOfABarUnderItsOwnWeight) {
  write_file(folder / "bar.yaml",
             cantilever("  - {name: top, stress: bar, at: [0.5, 0.05, 0.05], component: xx}\n"
                        "  - {name: mises, stress: bar, at: [0.5, 0.05, 0]}\n"
                        "  - {name: node, stress: bar, node: 158, component: xx}\n"
                        "  - {name: gauge, strain: bar, at: [0.5, 0.05, 0.05], along: [1, 0, 0]}\n"
                        "  - {name: peak, stress: bar}\n"));
  const Outcome ran = run({"run", "bar.yaml", "--output", "bar-run.h5", "--csv", "bar.csv"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  std::istringstream lines(read_file(folder / "bar.csv"));
  std::string line, last;
  std::getline(lines, line);
  EXPECT_EQ(line, "t,tip,top,mises,node,gauge,peak");
  while (std::getline(lines, line)) last = line;
  std::vector<double> v;
  std::istringstream numbers(last);
  for (std::string word; std::getline(numbers, word, ',');) v.push_back(std::stod(word));
  ASSERT_EQ(v.size(), 7u);
  // Half the length hangs beyond the middle: M = ½ q (L/2)², σ = M (h/2) / I.
  const double q = 7850 * 9.81 * 0.1 * 0.05, exact = 0.5 * q * 0.25 * 0.025 / (0.1 * std::pow(0.05, 3) / 12);
  EXPECT_NEAR(v[2], exact, 0.02 * exact);
  EXPECT_NEAR(v[3], exact, 0.02 * exact);
  EXPECT_EQ(v[4], v[2]);  // node 158 lies there
  EXPECT_NEAR(v[5], exact / 2.1e11, 0.03 * exact / 2.1e11);
  EXPECT_GT(v[6], 3 * exact);  // the clamp bears four times as much
  EXPECT_LT(v[6], 6 * exact);

  const Outcome told = run({"stress", "bar-run.h5", "--json", "--spots", "3"});
  expect_schema(told.out);
  const json spots = told.json();
  const json& first = spots.at("bodies")[0].at("hot_spots")[0];
  EXPECT_NEAR(first.at("von_mises").number(), v[6], 1e-5 * v[6]);
  EXPECT_NEAR(first.at("position")[0].number(), 0, 0.06);
  EXPECT_THAT(run({"stress", "bar-run.h5"}).out, HasSubstr("bar: largest von Mises stress"));

  const Outcome drawn = run({"export", "bar-run.h5", "--vtk", "frames", "--instants", "3"});
  ASSERT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_EQ(drawn.out, "frames/run.pvd\n");
  EXPECT_THAT(read_file(folder / "frames/bar_00002.vtp"), HasSubstr("Name=\"von_mises\""));
}

TEST_F(StressOfARun, WrongOutputsAreNamed) {
  const auto complaint = [&](const std::string& output) {
    write_file(folder / "bad.yaml", cantilever("  - " + output + "\n"));
    const Outcome outcome = run({"check", "bad.yaml"});
    EXPECT_EQ(outcome.code, 1) << output;
    return outcome.err;
  };
  EXPECT_THAT(complaint("{name: a, stress: bar, node: 7000}"), HasSubstr("no node 7000"));
  EXPECT_THAT(complaint("{name: a, stress: bar, at: [0.5, 0.05, 0.5]}"), HasSubstr("0.45 m away"));
  EXPECT_THAT(complaint("{name: a, stress: bar, along: [1, 0, 0]}"),
              HasSubstr("belongs to 'deflection' and 'strain'"));
  EXPECT_THAT(complaint("{name: a, strain: bar, component: von_mises}"), HasSubstr("von_mises"));
  EXPECT_THAT(complaint("{name: a, stress: bar, node: 1, at: [0, 0, 0]}"), HasSubstr("not both"));
  EXPECT_THAT(complaint("{name: a, position: bar, node: 1, component: x}"), HasSubstr("'node' belongs"));
}

TEST_F(StressOfARun, BodiesWithoutStressModesAreNamed) {
  write_file(folder / "beam.yaml",
             "mimbre: 1\nmaterials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\n"
             "sections: {round: {type: round, diameter: 0.02}}\n"
             "bodies:\n  beam:\n    frame: {at: [0, 0, 0]}\n    flexible: {material: steel, section: round, "
             "nodes: {a: [0, 0, 0], b: [1, 0, "
             "0]}, bars: {bar: {from: a, to: b, elements: 4}}, clamped: [a], dynamic_modes: 2}\n"
             "joints: {hinge: {type: revolute, between: [ground, beam], at: [0, 0, 0], axis: [0, 1, 0]}}\n"
             "outputs: [{name: s, stress: beam}]\nsimulation: {step: 0.01, end: 0.1}\n");
  const Outcome outcome = run({"check", "beam.yaml"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no stress modes")) << outcome.err;
  const Outcome ran = run({"run", MIMBRE_SOURCE_DIR "/examples/pendulum/flexible.yaml", "--output", "p.h5"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const Outcome none = run({"stress", "p.h5"});
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("no body has stress modes"));
}

}  // namespace
}  // namespace mimbre::app_test::stress_test
