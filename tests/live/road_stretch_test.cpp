#include "live/road_stretch.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mimbre::live::road_stretch_test {
namespace {

/// Of the profile's straight lines.
double height_at(const RoadDrawing& drawing, double x) {
  const auto& p = drawing.profile;
  for (Eigen::Index k = 0; k + 1 < p.cols(); ++k)
    if (p(0, k) <= x && x <= p(0, k + 1))
      return p(1, k) + (p(1, k + 1) - p(1, k)) * (x - p(0, k)) / (p(0, k + 1) - p(0, k));
  ADD_FAILURE() << "nothing is drawn at " << x;
  return NAN;
}

TEST(RoadStretch, RepeatsWithAsFewPointsAsItNeeds) {
  spec::Road road;
  road.height =
      Function::table({10, 30, 40, 110}, {0, 0, 1, 0}, Function::Interpolation::linear).repeated(10, 100);
  road.draw_from = 10;
  road.draw_to = 110;
  const RoadDrawing drawing = road_stretch(road);
  EXPECT_NEAR(drawing.profile(0, 0), -190, 1e-9);
  EXPECT_NEAR(drawing.profile(0, drawing.profile.cols() - 1), 1810, 1e-9);
  EXPECT_LE(drawing.profile.cols(), 20 * 3 + 2);
  for (double x = -190; x < 1810; x += 0.37)
    EXPECT_NEAR(height_at(drawing, x), road.height.value(x), 1e-3) << x;
}

TEST(RoadStretch, WhatBendsIsRightToAMillimetre) {
  spec::Road road;
  road.height = Function::expression("0.3*sin(x/3)", "x");
  road.draw_to = 60;
  const RoadDrawing drawing = road_stretch(road);
  EXPECT_LT(drawing.profile.cols(), 10'000);
  for (double x = -120; x < 1080; x += 0.37)
    EXPECT_NEAR(height_at(drawing, x), road.height.value(x), 1e-3) << x;
}

TEST(RoadStretch, WhereItClimbsOutOfSightOrIsNotFiniteNothingIsDrawn) {
  spec::Road road;
  road.height = Function::expression("sqrt(x)*x/20", "x");
  road.draw_to = 100;
  const RoadDrawing drawing = road_stretch(road);
  EXPECT_EQ(drawing.profile(0, 0), 0);
  EXPECT_NEAR(drawing.profile(1, drawing.profile.cols() - 1), 150, 0.5);
  EXPECT_TRUE(drawing.profile.allFinite());
}

}  // namespace
}  // namespace mimbre::live::road_stretch_test
