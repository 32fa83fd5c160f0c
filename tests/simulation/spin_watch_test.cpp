#include "simulation/watch/spin_watch.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <regex>

#include "mimbre/simulation.h"
#include "support/models.h"

/// The watch over bodies that turn too far in a step.
namespace mimbre::test::spin_watch_test {
namespace {

using Formulation = spec::Simulation::Formulation;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

std::shared_ptr<const Model> top(const Eigen::Vector3d& inertia, const Eigen::Vector3d& spin) {
  return model_of(fmt::format(R"(
gravity: [0, 0, 0]
bodies: {{top: {{mass: 1, com: [0, 0, 0], inertia: [{}, {}, {}]}}}}
joints: {{free: {{type: floating, between: [ground, top], at: [0, 0, 0], velocity: [0, 0, 0, {}, {}, {}]}}}}
outputs:
  - {{name: wx, angular_velocity: top, component: x}}
  - {{name: wy, angular_velocity: top, component: y}}
  - {{name: wz, angular_velocity: top, component: z}}
  - {{name: px, position: top, at: [1, 0, 0], component: x}}
  - {{name: py, position: top, at: [1, 0, 0], component: y}}
  - {{name: pz, position: top, at: [1, 0, 0], component: z}}
)",
                              inertia[0], inertia[1], inertia[2], spin[0], spin[1], spin[2]));
}

struct Turned {
  std::vector<std::string> warnings;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

Turned turned(const std::shared_ptr<const Model>& model, Formulation formulation, double step, double end) {
  RunOptions options;
  options.step = step;
  options.formulation = formulation;
  Simulation s(model, options);
  for (int k = 0; k < std::lround(end / step); ++k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      break;
    }
  }
  Turned out;
  for (std::string& text : s.warnings())
    if (text.find("turns too far") != std::string::npos) out.warnings.push_back(std::move(text));
  for (int k = 0; k < 3; ++k) out.point[k] = s.value({3 + k});
  return out;
}

double step_named_in(const std::string& warning) {
  std::smatch found;
  if (!std::regex_search(warning, found, std::regex("take a step of ([0-9.e-]+) s"))) return 0;
  return std::stod(found[1]);
}

const Eigen::Vector3d skew(60, 60, 50);

/// 300 rad/s in steps of 10 ms: by 3 rad. With the step that the warning names nothing is said, and the turn
/// is right.
TEST(SpinWatch, NamesTheBodyTheTurnAndTheStepThatWouldDo) {
  const auto model = top({1, 1.5, 2}, 3 * skew);
  for (const Formulation formulation : {Formulation::relative, Formulation::natural}) {
    const Turned coarse = turned(model, formulation, 0.01, 0.2);
    ASSERT_EQ(coarse.warnings.size(), 1u);
    EXPECT_THAT(coarse.warnings[0], HasSubstr("body 'top' turns too far in a step, from t = 0.01 s on"));
    const double enough = step_named_in(coarse.warnings[0]);
    EXPECT_GT(enough, 2e-4);
    EXPECT_LT(enough, 4e-3);
    const Turned fine = turned(model, formulation, enough, 20 * enough);
    EXPECT_THAT(fine.warnings, testing::IsEmpty());
    const Turned exact = turned(model, Formulation::relative, enough / 32, 20 * enough);
    // 0.5 % of a turn of 20 × |ω| × enough.
    EXPECT_LT((fine.point - exact.point).norm(), 0.005 * 20 * 3 * skew.norm() * enough);
  }
}

/// Where nothing is said ten steps are right to 1 % of their turn; of tops that are missed by more than 3 %
/// something is said.
TEST(SpinWatch, WarnsWhereTheTurnIsMissed) {
  int silent = 0, warned = 0;
  for (const Eigen::Vector3d& inertia :
       {Eigen::Vector3d(1, 1.5, 2), Eigen::Vector3d(1, 2, 2.8), Eigen::Vector3d(1, 1, 1.9),
        Eigen::Vector3d(1.9, 1, 1.7), Eigen::Vector3d(1, 1.1, 1.2)})
    for (const Eigen::Vector3d& axis : {Eigen::Vector3d(6, 6, 5), Eigen::Vector3d(1, 5, 2)})
      for (const Formulation formulation : {Formulation::relative, Formulation::natural})
        for (const double turn : {0.1, 0.3, 0.6, 1.0, 2.0}) {
          const auto model = top(inertia, 100 * axis.normalized());
          const double step = turn / 100;
          const Turned run = turned(model, formulation, step, 10 * step);
          const Turned exact = turned(model, Formulation::relative, step / 32, 10 * step);
          const double missed = (run.point - exact.point).norm() / (10 * turn);
          if (run.warnings.empty()) {
            EXPECT_LT(missed, 0.01) << turn << ' ' << inertia.transpose();
            ++silent;
          } else {
            ++warned;
          }
          if (missed > 0.03) {
            EXPECT_FALSE(run.warnings.empty()) << turn << ' ' << inertia.transpose();
          }
        }
  EXPECT_GT(silent, 20);
  EXPECT_GT(warned, 20);
}

/// About a principal axis the turn is exact in relative coordinates, and so is a wheel's on its axle.
TEST(SpinWatch, SaysNothingOfTurnsThatAreExact) {
  const Turned run = turned(top({1, 1.5, 2}, {0, 0, 300}), Formulation::relative, 0.01, 1);
  EXPECT_THAT(run.warnings, testing::IsEmpty());
  EXPECT_NEAR(run.point.x(), std::cos(300.0), 1e-9);
  EXPECT_NEAR(run.point.y(), std::sin(300.0), 1e-9);
  const auto wheel = model_of(R"(
gravity: [0, 0, 0]
bodies: {wheel: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.02, 0.01]}}
joints: {axle: {type: revolute, between: [ground, wheel], at: [0, 0, 0], axis: [0, 1, 0], velocity: 300}}
outputs:
  - {name: w, joint_velocity: axle}
)");
  RunOptions options;
  options.step = 0.01;
  Simulation s(wheel, options);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.value({0}), 300, 1e-9);
  EXPECT_THAT(s.warnings(), testing::IsEmpty());
}

/// Natural coordinates miss a turn about an axis that stands still, too, and nothing is said of an axis that
/// turns.
TEST(SpinWatch, SaysThatNaturalCoordinatesMissATurnAboutAFixedAxis) {
  const auto model = top({1, 1, 1}, {0, 0, 25});
  const Turned natural = turned(model, Formulation::natural, 0.01, 0.2),
               relative = turned(model, Formulation::relative, 0.01, 0.2);
  const auto missed = [](const Turned& run) {
    return std::abs(std::atan2(run.point.y(), run.point.x()) - std::remainder(5.0, 2 * std::numbers::pi)) / 5;
  };
  EXPECT_GT(missed(natural), 0.005);
  EXPECT_LT(missed(relative), 1e-9);
  EXPECT_THAT(relative.warnings, testing::IsEmpty());
  EXPECT_THAT(natural.warnings, testing::ElementsAre(AllOf(
                                    HasSubstr("natural coordinates in steps of 0.01 s miss more than 0.5 %"),
                                    Not(HasSubstr("axis")))));
}

/// What it has seen is saved with the state.
TEST(SpinWatch, IsSavedWithTheState) {
  const auto model = top({1, 1.5, 2}, 3 * skew);
  RunOptions options;
  options.step = 0.01;
  Simulation s(model, options), other(model, options);
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(s.step().ok());
  other.restore(s.save());
  EXPECT_EQ(other.warnings(), s.warnings());
  EXPECT_THAT(other.warnings(), Contains(HasSubstr("turns too far")));
}

}  // namespace
}  // namespace mimbre::test::spin_watch_test
