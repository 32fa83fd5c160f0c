#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/program.h"

/// docs/finite-elements.md: its commands run as they stand, and what it says of the solid A-arm is so.
namespace mimbre::app_test::finite_elements_test {
namespace {

using json = test::Json;

const fs::path source = MIMBRE_SOURCE_DIR;

/// What stands in the page's shell blocks; those called `sh gmsh` need Gmsh and CalculiX.
std::string shell_blocks(const std::string& page, bool others) {
  const std::string open = "```sh", close = "```";
  std::string commands;
  for (std::size_t at = page.find(open); at != std::string::npos; at = page.find(open, at)) {
    const std::size_t begin = page.find('\n', at) + 1, end = page.find(close, begin);
    if (others || page.substr(at, begin - at) == open + "\n") commands += page.substr(begin, end - begin);
    at = end + close.size();
  }
  return commands;
}

class FiniteElements : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    fs::create_directory(folder / "examples");
    for (const char* example : {"iltis", "solid-arm"})
      fs::copy(source / "examples" / example, folder / "examples" / example);
  }

  int shell(const std::string& commands) const {
    write_file(folder / "commands.sh", "set -e\nhere=$PWD\nmimbre() { \"" + program_path() +
                                           "\" \"$@\" >> \"$here/out.txt\" 2>> \"$here/err.txt\"; }\n" +
                                           commands);
    return std::system(("cd '" + folder.string() + "' && sh commands.sh").c_str());
  }

  json simulate(const std::string& model, const std::string& csv) const {
    const Outcome outcome = run({"run", model, "--csv", csv, "--json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.json();
  }
};

TEST_F(FiniteElements, CommandsOfThePageRun) {
  const std::string commands = shell_blocks(read_file(source / "docs/finite-elements.md"), false);
  ASSERT_NE(commands.find("mimbre reduce"), std::string::npos);
  std::map<std::string, std::string> tracked;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "examples"))
    if (entry.is_regular_file()) tracked[entry.path().string()] = read_file(entry.path());
  EXPECT_EQ(shell(commands), 0) << read_file(folder / "err.txt");
  for (const auto& [path, content] : tracked)
    EXPECT_EQ(read_file(path) == content, true) << path << " is another";
  for (const char* made : {"examples/solid-arm/arm.h5", "modes.html", "solid.html", "vehicle.html",
                           "frames/run.pvd", "arm.fem", "arm.sid", "back.h5"})
    EXPECT_GT(fs::file_size(folder / "build/parts" / made), 1000u) << made;
}

/// From the drawing on, by Gmsh's mesh and by CalculiX's matrices.
TEST_F(FiniteElements, CommandsOfThePageRunFromTheDrawingOn) {
  if (std::system("command -v gmsh ccx > /dev/null 2>&1") != 0 ||
      std::system("command -v ccx > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "Gmsh and CalculiX are not installed";
  const std::string commands = shell_blocks(read_file(source / "docs/finite-elements.md"), true);
  for (const char* made : {"arm.h5", "arm.msh"}) fs::remove(folder / "examples/solid-arm" / made);
  EXPECT_EQ(shell("exec >> others.txt\n" + commands), 0)
      << read_file(folder / "err.txt") << read_file(folder / "others.txt");
  // The arm of CalculiX's matrices moves as that of our own.
  const Outcome compared = run({"compare", "build/parts/solid.h5", "build/parts/calculix.h5", "--json"});
  ASSERT_EQ(compared.code, 0) << compared.err;
  EXPECT_LT(compared.json().at("channels").at("chassis.z").at("max_difference").number(), 1e-6);
}

/// The committed body is the one that the committed mesh gives.
TEST_F(FiniteElements, MeshGivesTheBody) {
  const json before = simulate("examples/solid-arm/suspension.yaml", "before.csv");
  const Outcome outcome = run({"reduce",       "examples/solid-arm/arm.msh",
                               "--units",      "mm",
                               "--material",   "2.1e11,0.3,7850",
                               "--interface",  "front=group:front",
                               "--interface",  "rear=group:rear",
                               "--interface",  "ball=group:ball",
                               "--interface",  "shock=group:seat",
                               "--point",      "front=108,0,0",
                               "--point",      "rear=-108,0,0",
                               "--point",      "ball=0,321.4603,0",
                               "--point",      "shock=75,248.6166,-4.6668",
                               "--modes",      "2",
                               "--free-modes", "6",
                               "--damping",    "0.01",
                               "-o",           "examples/solid-arm/arm.h5",
                               "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json summary = outcome.json();
  EXPECT_TRUE(summary.at("passed"));
  EXPECT_EQ(summary.at("modes"), 20);
  EXPECT_NEAR(summary.at("mass").number(), 6, 0.05);
  // CalculiX 2.20 on the same mesh: 204.2807 Hz, 550.5410 Hz.
  EXPECT_NEAR(summary.at("free_frequencies_hz").at(0).number(), 204.2807, 204 * 1e-4);
  EXPECT_NEAR(summary.at("free_frequencies_hz").at(1).number(), 550.5410, 550 * 1e-4);
  simulate("examples/solid-arm/suspension.yaml", "after.csv");
  const auto a = csv_rows(folder / "before.csv"), b = csv_rows(folder / "after.csv");
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k][1], b[k][1], 1e-6) << "at " << a[k][0] << " s";
}

/// The solid arm against that of beams: the same motion, a step at most a few times as dear.
TEST_F(FiniteElements, SolidArmMovesAsTheBeams) {
  const json solid = simulate("examples/solid-arm/suspension.yaml", "solid.csv");
  const json beams = simulate("examples/iltis/suspension.yaml", "beams.csv");
  EXPECT_TRUE(solid.at("warnings").empty());
  EXPECT_EQ(solid.at("coordinates").number(), beams.at("coordinates").number() - 4 + 20);
  const auto a = csv_rows(folder / "solid.csv"), b = csv_rows(folder / "beams.csv");
  ASSERT_EQ(a.size(), b.size());
  double largest = 0, lowest = 1;
  for (std::size_t k = 0; k < a.size(); ++k) {
    for (int wheel_or_chassis : {1, 2})
      largest = std::max(largest, std::abs(a[k][static_cast<std::size_t>(wheel_or_chassis)] -
                                           b[k][static_cast<std::size_t>(wheel_or_chassis)]));
    lowest = std::min(lowest, a[k][1]);
  }
  EXPECT_LT(largest, 1e-3);
  EXPECT_LT(lowest, 0.4);  // the drop happened
}

/// Four solid arms, two of them mirrored, with as many modes as those of beams, in the whole car.
TEST_F(FiniteElements, VehicleMovesOnSolidArmsAsOnBeams) {
  const Outcome beams = run({"run", "examples/iltis/vehicle.yaml", "--csv", "beams.csv", "--json"});
  const Outcome solid = run({"run", "examples/iltis/vehicle.yaml", "--set", "arms=reduced", "--csv",
                             "solid.csv", "--output", "solid.h5", "--json"});
  ASSERT_EQ(solid.code, 0) << solid.err;
  EXPECT_TRUE(solid.json().at("warnings").empty());
  EXPECT_EQ(solid.json().at("coordinates"), beams.json().at("coordinates"));
  const auto a = csv_rows(folder / "beams.csv"), b = csv_rows(folder / "solid.csv");
  ASSERT_EQ(a.size(), b.size());
  double height = 0, sideways = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    height = std::max(height, std::abs(a[k][1] - b[k][1]));
    sideways = std::max({sideways, std::abs(b[k][2]), std::abs(b[k][4])});  // roll, yaw
  }
  EXPECT_LT(height, 3e-3);
  EXPECT_LT(sideways, 1e-8);  // the mirror images push as their originals do
  const json bodies = run({"stress", "solid.h5", "--json", "--spots", "1"}).json().at("bodies");
  ASSERT_EQ(bodies.size(), 4u);
  const auto peak = [&](int k) { return bodies[k].at("hot_spots")[0].at("von_mises").number(); };
  EXPECT_GT(peak(0), 3e7);
  EXPECT_LT(peak(0), 3e8);
  EXPECT_NEAR(peak(1), peak(0), 1e-6 * peak(0));
  EXPECT_NEAR(peak(3), peak(2), 1e-6 * peak(2));
}

/// What a body has twice must be said, and `as` chooses.
TEST_F(FiniteElements, AsChoosesTheDescription) {
  const auto model = [](const std::string& as) {
    return "mimbre: 1\ntitle: Two arms in one\ngravity: [0, 0, -9.81]\nmaterials:\n"
           "  steel: {young: 2.1e11, poisson: 0.3, density: 7850}\nsections:\n"
           "  round: {type: round, diameter: 0.03}\nbodies:\n  arm:\n" +
           as +
           "    frame: {at: [0, 0, 0]}\n    reduced: examples/solid-arm/arm.h5\n"
           "    flexible:\n      material: steel\n      section: round\n"
           "      nodes: {front: [0.108, 0, 0], ball: [0, 0.32, 0]}\n"
           "      bars: {bar: {from: front, to: ball, elements: 2}}\n"
           "      clamped: [front]\n      dynamic_modes: 2\n"
           "joints:\n  hinge: {type: revolute, between: [ground, arm.front], axis: [1, 0, 0]}\n"
           "simulation: {step: 0.001, end: 0.01}\n";
  };
  for (const auto& [as, coordinates] : {std::pair{"flexible", 3}, {"reduced", 21}}) {
    write_file(folder / "arm.yaml", model(std::string("    as: ") + as + "\n"));
    const Outcome outcome = run({"run", "arm.yaml", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.json().at("coordinates"), coordinates);
  }
  write_file(folder / "arm.yaml", model(""));
  const Outcome unclear = run({"run", "arm.yaml"});
  EXPECT_EQ(unclear.code, 1);
  EXPECT_NE(unclear.err.find("as: reduced"), std::string::npos) << unclear.err;
}

/// Interfaces that leave the rest singular, masses that are too small to count: a message, whatever the
/// basis.
TEST_F(FiniteElements, ModelsWithoutSoundModesAreRefused) {
  const std::string data = MIMBRE_SOURCE_DIR "/tests/data/";
  const std::vector<std::vector<std::string>> commands{
      {data + "calculix/elements/C3D4.inp", "--interface", "r=box(-9,-9,-9,0.01,9,9)", "--basis",
       "free_interface", "--modes", "3"},
      {data + "calculix/elements/C3D10.inp", "--interface", "r=box(-9,-9,-9,9,9,0.01)", "--modes", "2",
       "--free-modes", "3"},
      {data + "gmsh/block-22.msh", "--material", "2.1e11,0.3,1e-100", "--interface", "left=group:left",
       "--modes", "2"}};
  for (std::vector<std::string> command : commands) {
    command.insert(command.begin(), "reduce");
    for (const char* rest : {"--no-cache", "-o", "o.h5"}) command.push_back(rest);
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.signal, 0) << command[1];
    EXPECT_TRUE(outcome.code == 0 || outcome.err.find("error: ") != std::string::npos) << outcome.err;
  }
  std::string model = read_file(MIMBRE_SOURCE_DIR "/examples/tutorial/flexible.yaml");
  const std::string young = "young: 2.1e11";
  ASSERT_NE(model.find(young), std::string::npos);
  write_file(folder / "stiff.yaml", model.replace(model.find(young), young.size(), "young: 1e200"));
  const Outcome outcome = run({"check", "stiff.yaml"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("stiff.yaml:"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace mimbre::app_test::finite_elements_test
