#include "integrate/prediction.h"

#include <gtest/gtest.h>
#include <cmath>
#include <vector>

namespace mimbre::test::prediction_test {
namespace {

using Eigen::VectorXd;

Scales scales_of_two() {
  Scales scales;
  scales.coordinates = {1, 100};
  return scales;
}
const Scales scales = scales_of_two();

/// Steps whose ends differ from the rule's prediction by errors[k]: how far each one's beginning was off.
std::vector<double> misses(Prediction& prediction, const std::vector<VectorXd>& errors) {
  std::vector<double> out;
  for (const VectorXd& error : errors) {
    VectorXd own(2);
    own << 3 + static_cast<double>(out.size()), -700;
    VectorXd x = own;
    prediction.begin(0.01, x);
    const VectorXd end = own + error;
    const VectorXd rest = end - x;
    out.push_back(scales.of_coordinates(rest.data()));
    EXPECT_NEAR(prediction.off(scales, end), scales.of_coordinates(error.data()), 1e-12);
    prediction.learn(0.01, scales, end);
  }
  return out;
}

TEST(Prediction, ErrorsThatStayAreTakenAwayAfterTwoSteps) {
  Prediction prediction(2);
  const VectorXd error = VectorXd::Constant(2, 0.25);
  const std::vector<double> off = misses(prediction, std::vector<VectorXd>(5, error));
  EXPECT_EQ(off[0], 0.25);
  EXPECT_EQ(off[1], 0.25);  // nothing has shown yet that they stay
  for (int k = 2; k < 5; ++k) EXPECT_NEAR(off[static_cast<std::size_t>(k)], 0, 1e-12);
}

TEST(Prediction, ErrorsAlongALineAreTakenAwayAfterThreeSteps) {
  Prediction prediction(2);
  std::vector<VectorXd> errors;
  for (int k = 0; k < 6; ++k) errors.push_back(VectorXd::Constant(2, 1 + 0.25 * k));
  const std::vector<double> off = misses(prediction, errors);
  EXPECT_NEAR(off[2], 0.25, 1e-12);
  for (int k = 3; k < 6; ++k) EXPECT_NEAR(off[static_cast<std::size_t>(k)], 0, 1e-12);
}

TEST(Prediction, ErrorsThatAlternateAreLeftAlone) {
  Prediction prediction(2);
  std::vector<VectorXd> errors;
  for (int k = 0; k < 6; ++k) errors.push_back(VectorXd::Constant(2, k % 2 == 0 ? 1 : -1));
  for (const double off : misses(prediction, errors)) EXPECT_EQ(off, 1);
}

const std::vector<VectorXd> constant(3, VectorXd::Constant(2, 0.25));

TEST(Prediction, LearnsNothingFromWhatWasReplaced) {
  Prediction prediction(2);
  misses(prediction, constant);
  VectorXd x = VectorXd::Zero(2);
  prediction.begin(0.01, x);
  EXPECT_EQ(x[0], 0.25);
  x.setConstant(5);
  prediction.replace(x);
  x.setConstant(9);
  prediction.learn(0.01, scales, x);
  EXPECT_EQ(misses(prediction, constant)[0], 0.25);
}

TEST(Prediction, LearnsNothingFromStepsOfAnotherLength) {
  Prediction prediction(2);
  misses(prediction, constant);
  VectorXd x = VectorXd::Zero(2);
  prediction.begin(0.02, x);
  EXPECT_EQ(x[0], 0);
  x.setConstant(0.5);
  prediction.learn(0.02, scales, x);
  EXPECT_EQ(misses(prediction, constant)[0], 0.25);
}

TEST(Prediction, GoesOnFromASavedState) {
  Prediction first(2), second(2);
  std::vector<VectorXd> errors;
  for (int k = 0; k < 5; ++k) errors.push_back(VectorXd::Constant(2, 1 + 0.25 * k * k));
  misses(first, errors);
  StateTransfer count;
  first.transfer(count);
  std::vector<double> block(count.count());
  StateTransfer to = StateTransfer::to(block), from = StateTransfer::from(block);
  first.transfer(to);
  second.transfer(from);
  EXPECT_EQ(misses(first, errors), misses(second, errors));
}

}  // namespace
}  // namespace mimbre::test::prediction_test
