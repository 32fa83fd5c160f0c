#include <gtest/gtest.h>

#include <unistd.h>
#include <filesystem>

#include "fe/bar_ends.h"
#include "fe/solid_meshes.h"
#include "mimbre/fe_reduce.h"
#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// A solid bar with the body frame tied to its root, to its centre of mass or to its mean motion is the same
/// bar: it swings alike, in relative and in natural coordinates.
namespace mimbre::test::body_frames_test {
namespace {

using fe::Interface;
using Frame = fe::ModelReduction::Frame;

fe::ReductionResult reduced(Frame frame) {
  const fe::Material stiff{2.1e11, 0.3, 7850};
  const fe::SolidMesh mesh = block(fe::ElementType::hex20, {1, 0.02, 0.01}, {12, 1, 1}, stiff);
  fe::ModelReduction o;
  o.interfaces = {end(mesh, "root", 0), end(mesh, "tip", 1)};
  o.dynamic_modes = 4;
  o.frame = frame;
  o.free_modes = 4;
  o.stiffness_damping = 1e-4;
  return fe::reduce(mesh, fe::assemble(mesh), o);
}

/// Heights of the tip of a pendulum that is let go from the horizontal, every 20 ms.
std::vector<double> swing(const ReducedBody& body, const std::string& formulation) {
  const auto path =
      std::filesystem::temp_directory_path() / ("mimbre-frames-" + std::to_string(getpid()) + ".h5");
  save(body, path.string());
  const std::string text =
      "mimbre: 1\ngravity: [0, 0, -9.81]\nbodies:\n  bar: {frame: {at: [0, 0, 0]}, reduced: " +
      path.filename().string() +
      "}\njoints:\n  hinge: {type: revolute, between: [ground, bar.root], axis: [0, 1, 0]}\n"
      "outputs:\n  - {name: z, position: bar.tip, component: z}\n"
      "simulation: {step: 0.001, end: 0.4, formulation: " +
      formulation + "}\n";
  const auto model = Model::compile(parse_model(text, "frames.yaml", path.parent_path().string()));
  std::filesystem::remove(path);
  Simulation simulation(model);
  std::vector<double> heights;
  ResultsRow row;
  for (int k = 1; k <= 400; ++k) {
    simulation.step();
    if (k % 20 != 0) continue;
    simulation.sample(row);
    heights.push_back(row.channels[0]);
  }
  return heights;
}

TEST(BodyFrames, MoveTheSameBar) {
  std::vector<std::vector<double>> runs;
  for (const Frame frame : {Frame::tangent, Frame::centre_of_mass, Frame::mean_axis})
    for (const char* formulation : {"relative", "natural"})
      runs.push_back(swing(reduced(frame).body, formulation));
  for (std::size_t r = 1; r < runs.size(); ++r)
    for (std::size_t k = 0; k < runs[r].size(); ++k)
      EXPECT_NEAR(runs[r][k], runs[0][k], 2e-5) << "run " << r << " at " << 0.02 * static_cast<double>(k + 1);
  EXPECT_LT(runs[0].back(), -0.5);  // it fell
}

TEST(BodyFrames, OfTheCentreOfMassKeepsItStill) {
  const fe::ReductionResult tangent = reduced(Frame::tangent), centre = reduced(Frame::centre_of_mass);
  EXPECT_EQ(centre.body.modes, tangent.body.modes);
  EXPECT_GT(tangent.body.S.norm(), 0.1 * std::sqrt(tangent.body.mass));
  EXPECT_LT(centre.body.S.norm(), 1e-9 * std::sqrt(centre.body.mass));
  EXPECT_LT(centre.body.frames[0].X_theta.norm(), 1e-9);  // the root does not turn, but moves
  EXPECT_GT(centre.body.frames[0].X.norm(), 1e-3);
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(centre.reduced_free_frequencies[k] / tangent.reduced_free_frequencies[k], 1, 1e-6);
}

}  // namespace
}  // namespace mimbre::test::body_frames_test
