#include <cmath>
#include <numbers>

#include "examples/example.h"

/// examples/robot against the bending of its links by hand, and where a rigid robot goes.
namespace mimbre::examples_test::robot_test {
namespace {

constexpr double pi = std::numbers::pi;

class Robot : public ExampleTest {
 protected:
  /// How far an axis of the real robot ever is from the plan's after the start, rad.
  static double apart(const Table& run, int axis) {
    const std::string q = ".q" + std::to_string(axis);
    return (run["real" + q] - run["plan" + q]).abs().maxCoeff();
  }
  /// How far the tool is from where the plan has it, m.
  static Eigen::ArrayXd tool_apart(const Table& run) {
    return ((run["real.x"] - run["plan.x"]).square() + (run["real.y"] + 1.5 - run["plan.y"]).square() +
            (run["real.z"] - run["plan.z"]).square())
        .sqrt();
  }
};

/// With rigid links the torques of the plan are the right ones.
TEST_F(Robot, ComputedTorqueIsExactForRigidLinks) {
  const Table run = run_example("robot", {"--set", "links=rigid"});
  for (int axis = 1; axis <= 6; ++axis) EXPECT_LT(apart(run, axis), 2e-4) << axis;
  EXPECT_LT(tool_apart(run).maxCoeff(), 3e-4);
  for (int axis = 1; axis <= 6; ++axis) {
    const double way[] = {1.2, 0.6, -0.9, 0.8, 0.7, 1.5};
    EXPECT_NEAR(run["real.q" + std::to_string(axis)].tail(1)[0], way[axis - 1], 1e-4);
  }
}

/// The way stops each joint where it is wanted: the integral takes over what the torques of the plan, whose
/// links do not sag, leave of gravity. Controllers at their limits do not wind up while the links swing into
/// their sag.
TEST_F(Robot, EndsWhereItIsWanted) {
  const double way[] = {1.2, 0.6, -0.9, 0.8, 0.7, 1.5};
  for (const char* limit : {"limit=60", "limit=5"}) {
    const Table run = run_example("robot", {"--set", limit});
    const Table moving = run.from(0.7);
    for (int axis = 1; axis <= 6; ++axis) {
      EXPECT_NEAR(run["real.q" + std::to_string(axis)].tail(1)[0], way[axis - 1], 1e-5) << axis << limit;
      EXPECT_LT(apart(moving, axis), 9e-4) << axis << limit;
    }
  }
}

/// With flexible ones the joints still go where they are wanted, and the tool does not quite.
TEST_F(Robot, JointsFollowWhileTheToolSags) {
  const Table run = run_example("robot").from(0.7);
  for (int axis = 1; axis <= 6; ++axis) EXPECT_LT(apart(run, axis), 9e-4) << axis;
  EXPECT_LT(tool_apart(run).maxCoeff(), 7e-3);
  EXPECT_GT(tool_apart(run).minCoeff(), 2e-3);
}

/// Cantilevers: the forearm under what its end carries and its own weight, the upper arm under the moment of
/// all that.
TEST_F(Robot, SagsByTheBendingOfItsLinks) {
  const Table before = run_example("robot", {"--until", "0.8"}).from(0.75);
  const double outer = 0.06, inner = 0.056, length = 0.6, tool = 0.12, g = 9.81;
  const double stiffness = 7e10 * pi / 64 * (std::pow(outer, 4) - std::pow(inner, 4));
  const double own = 2700 * pi / 4 * (outer * outer - inner * inner) * g;  // N/m
  const double force = (2 + 1 + 5) * g, moment = (1 * 0.04 + 5 * tool) * g;
  const double drop =
      force * std::pow(length, 3) / 3 + moment * length * length / 2 + own * std::pow(length, 4) / 8;
  const double turn = force * length * length / 2 + moment * length + own * std::pow(length, 3) / 6;
  const double below =
      (force * length + moment + own * length * length / 2) * length;  // turn of the upper arm's end
  const double sag = (drop + turn * tool + below * (length + tool)) / stiffness;
  EXPECT_NEAR(sag, 3.0e-3, 0.1e-3) << "examples/robot/README.md says so";
  // Less what the joints give way.
  const auto off = [&](const char* q) {
    return (before["real." + std::string(q)] - before["plan." + std::string(q)]).mean();
  };
  const double of_joints = (off("q2") + off("q3")) * (length + tool) + off("q5") * tool;
  EXPECT_NEAR((before["plan.z"] - before["real.z"]).mean() - of_joints, sag, 0.02 * sag);
}

}  // namespace
}  // namespace mimbre::examples_test::robot_test
