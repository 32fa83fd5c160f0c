#include "mimbre/mode_selection.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <filesystem>
#include <iostream>

#include "analysis/modes/mode_participation.h"
#include "analysis/rigid_response.h"
#include "fe/solid_meshes.h"
#include "mimbre/fe_reduce.h"
#include "mimbre/model_file.h"
#include "reduction/bases/project_modes.h"

/// The fewest modes that a mechanism needs.
namespace mimbre::test::mode_selection_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Keep = ModeSelectionOptions::Keep;

int body_of(const spec::Model& model, const std::string& name) {
  for (std::size_t k = 0; k < model.bodies.size(); ++k)
    if (model.bodies[k].name == name) return static_cast<int>(k);
  throw std::runtime_error("no body " + name);
}

/// Error with the first `count` modes in order of frequency.
double error_by_hand(const spec::Model& model, int body, int count, const AmplitudeHistory& all) {
  const ReducedBody& candidates = *model.bodies[static_cast<std::size_t>(body)].flexible;
  ReducedBody some = project_modes(candidates, MatrixXd::Identity(candidates.modes, count));
  make_orthogonal(some);
  try {
    return selection_error(candidates, all, some, amplitudes_with(model, body, some, {}));
  } catch (const std::runtime_error&) {
    return INFINITY;  // the loops do not close with so few
  }
}

int modes_by_hand(const spec::Model& model, int body, double error) {
  const ReducedBody& candidates = *model.bodies[static_cast<std::size_t>(body)].flexible;
  const AmplitudeHistory all = amplitudes_with(model, body, candidates, {});
  for (int count = 1; count < candidates.modes; ++count)
    if (error_by_hand(model, body, count, all) <= error) return count;
  return candidates.modes;
}

void print(const char* what, const ModeSelection& s, int hand) {
  std::cout << what << ": " << s.body.modes << " of " << s.candidates << " modes, " << 100 * s.achieved_error
            << " % (estimated " << 100 * s.estimated_error << " %), " << s.runs << " runs; by hand " << hand
            << '\n';
}

/// A solid arm with 26 modes on a hinge, a mass at its tip, let go from the horizontal.
spec::Model solid_pendulum() {
  fe::SolidMesh mesh = block(fe::ElementType::hex8, {1, 0.05, 0.02}, {12, 1, 1}, {2.1e11, 0.3, 7850});
  for (auto column : mesh.nodes.colwise()) column -= Eigen::Vector3d(0, 0.025, 0.01);
  fe::ModelReduction options;
  for (const double end : {0.0, 1.0}) {
    fe::Interface interface;
    interface.name = end == 0 ? "root" : "tip";
    for (int k = 0; k < mesh.nodes.cols(); ++k)
      if (std::abs(mesh.nodes(0, k) - end) < 1e-9) interface.nodes.push_back(k);
    interface.point = {end, 0, 0};
    options.interfaces.push_back(interface);
  }
  options.dynamic_modes = 20;
  options.free_modes = 0;
  options.stiffness_damping = 1e-4;
  const std::string folder = fmt::format("{}/mimbre-mode-selection-{}", testing::TempDir(), getpid());
  std::filesystem::create_directories(folder);
  save(fe::reduce(mesh, fe::assemble(mesh), options).body, folder + "/arm.h5");
  const spec::Model model = parse_model(R"(mimbre: 1
title: A solid pendulum
bodies:
  arm: {frame: {at: [0, 0, 0]}, reduced: arm.h5}
  bob: {mass: 5, com: [1, 0, 0], inertia: [0.01, 0.01, 0.01]}
joints:
  hinge: {type: revolute, between: [ground, arm.root], axis: [0, 1, 0]}
  weld: {type: fixed, between: [arm.tip, bob]}
outputs:
  - {name: tip, deflection: arm.tip, along: [0, 0, 1]}
simulation: {step: 0.002, end: 1}
)",
                                        "pendulum.yaml", folder);
  std::filesystem::remove_all(folder);
  return model;
}

spec::Model suspension() {
  return load_model(std::string(MIMBRE_SOURCE_DIR) + "/examples/solid-arm/suspension.yaml");
}

// The figures of these two are those of docs/finite-elements.md.
TEST(ModeSelection, OfTheSolidArmNeedsFewerModesThanByHand) {
  const spec::Model model = suspension();
  const int body = body_of(model, "front_left.arm"), hand = modes_by_hand(model, body, 0.01);
  const ModeSelection combined = select_mechanism_modes(model, body, {});
  print("suspension, combinations", combined, hand);
  EXPECT_TRUE(combined.reached);
  EXPECT_LE(combined.achieved_error, 0.01);
  EXPECT_LE(combined.body.modes, 3);
  EXPECT_LE(combined.body.modes, hand);
  EXPECT_TRUE(check(combined.body).empty());
  EXPECT_EQ(combined.body.checks.back().name, "mode selection");
  EXPECT_EQ(combined.body.frames.size(), 4U);
  // What was achieved is what a run gives.
  const ReducedBody& candidates = *model.bodies[static_cast<std::size_t>(body)].flexible;
  const double again = selection_error(candidates, amplitudes_with(model, body, candidates, {}),
                                       combined.body, amplitudes_with(model, body, combined.body, {}));
  EXPECT_NEAR(again, combined.achieved_error, 1e-9);

  ModeSelectionOptions options;
  options.keep = Keep::modes;
  const ModeSelection some = select_mechanism_modes(model, body, options);
  print("suspension, modes as they are", some, hand);
  EXPECT_LE(some.achieved_error, 0.01);
  EXPECT_LE(some.body.modes, hand);
  EXPECT_EQ(some.kept.size() + some.dropped.size(), 20U);
}

TEST(ModeSelection, OfTheSolidPendulumNeedsFewerModesThanByHand) {
  const spec::Model model = solid_pendulum();
  const int hand = modes_by_hand(model, 0, 0.01);
  for (const auto pre : {ModeSelectionOptions::Pre::candidates, ModeSelectionOptions::Pre::rigid})
    for (const Keep keep : {Keep::combinations, Keep::modes}) {
      ModeSelectionOptions options;
      options.pre = pre;
      options.keep = keep;
      const ModeSelection s = select_mechanism_modes(model, 0, options);
      print(pre == ModeSelectionOptions::Pre::rigid ? "pendulum, ranked by the rigid run" : "pendulum", s,
            hand);
      EXPECT_TRUE(s.reached);
      EXPECT_LE(s.achieved_error, 0.01);
      EXPECT_LE(s.body.modes, hand);
    }
}

TEST(ModeSelection, TakesMoreModesForASmallerError) {
  const spec::Model model = solid_pendulum();
  int last = 0;
  for (const double error : {0.05, 1e-3, 1e-4}) {
    ModeSelectionOptions options;
    options.error = error;
    const ModeSelection s = select_mechanism_modes(model, 0, options);
    EXPECT_LE(s.achieved_error, error);
    EXPECT_GE(s.body.modes, last);
    last = s.body.modes;
  }
  EXPECT_GT(last, 1);
}

TEST(ModeSelection, ForcesOnTheRigidBodyGiveItsDeflection) {
  const spec::Model model = solid_pendulum();
  const ReducedBody& body = *model.bodies[0].flexible;
  const MatrixXd flexible = frame_deflections(body, amplitudes_with(model, 0, body, {}).amplitudes);
  const AmplitudeHistory rigid = rigid_response(model, 0, {});
  ASSERT_EQ(rigid.amplitudes.cols(), flexible.cols());
  // The bob's inertia does not take part in the vibration of the modes: their mean is that of the run.
  const VectorXd mean_rigid = frame_deflections(body, rigid.amplitudes).rowwise().mean(),
                 mean_flexible = flexible.rowwise().mean();
  EXPECT_LT((mean_rigid - mean_flexible).norm(), 0.05 * mean_flexible.norm());
}

TEST(ModeSelection, WhatHasNoModesIsRefused) {
  spec::Model model = solid_pendulum();
  EXPECT_THROW(select_mechanism_modes(model, 1, {}), std::invalid_argument);
  auto ancf = std::make_shared<ReducedBody>(*model.bodies[0].flexible);
  ancf->ancf.emplace();
  model.bodies[0].flexible = ancf;
  EXPECT_THROW(select_mechanism_modes(model, 0, {}), std::invalid_argument);
}

/// Two frames and three modes: the first two move the first frame along x and y, the third the second.
ReducedBody three_modes() {
  ReducedBody b;
  b.modes = 3;
  b.stiffness = Eigen::Vector3d(1, 4, 9).asDiagonal();
  b.frames.resize(2);
  for (BodyFrame& frame : b.frames) frame.X.setZero(3, 3);
  b.frames[0].X(0, 0) = b.frames[0].X(1, 1) = 1;
  b.frames[1].X(2, 2) = 1;
  return b;
}

TEST(ModeParticipation, IsTheShareOfTheDeflectionLost) {
  MatrixXd y(3, 4);
  y << 4, -4, 4, -4, 3, 3, -3, 3, 1, 0, 2, -2;
  const ModeRanking ranking = rank_modes(three_modes(), y);
  EXPECT_NEAR(ranking.participation[0], 4. / 5, 1e-15);
  EXPECT_NEAR(ranking.participation[1], 3. / 5, 1e-15);
  EXPECT_NEAR(ranking.participation[2], 1.25 / 2, 1e-15);
  EXPECT_EQ(ranking.order, (std::vector<int>{0, 2, 1}));
  EXPECT_NEAR(ranking.error[3], 0, 1e-15);
  EXPECT_NEAR(ranking.error[2], 3. / 5, 1e-15);
  EXPECT_NEAR(ranking.error[1], 1.25 / 2, 1e-15);
  EXPECT_NEAR(ranking.error[0], 1, 1e-15);
}

TEST(ModeParticipation, OneShapeIsOneCombination) {
  MatrixXd y(3, 5);
  y = Eigen::Vector3d(1, -2, 0.5) * Eigen::RowVectorXd::LinSpaced(5, -1, 3);
  const ReducedBody body = three_modes();
  const ModeCombinations c = combine_modes(body, y);
  ASSERT_EQ(c.T.cols(), 1);
  EXPECT_NEAR(c.error[1], 0, 1e-14);
  EXPECT_NEAR(c.share[0], 1, 1e-14);
  EXPECT_NEAR(c.participation[0], c.error[0], 1e-14);
  EXPECT_NEAR((c.T.transpose() * body.stiffness * c.T)(0, 0), 1, 1e-14);
  EXPECT_THROW(combine_modes(body, MatrixXd::Zero(3, 5)), std::invalid_argument);
}

}  // namespace
}  // namespace mimbre::test::mode_selection_test
