#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>

#include "mimbre/inverse_dynamics.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"
#include "support/text.h"

/// Forces that make a motion: against those that made it, and against an independent Newton–Euler recursion.
namespace mimbre::test::inverse_dynamics_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

std::string list(const Vector3d& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

/// What a run of the model does: coordinates of these joints of the tree, which have one each.
PrescribedMotion motion_of(const std::shared_ptr<const Model>& model, const std::vector<std::string>& joints,
                           double step, int steps) {
  RunOptions o;
  o.step = step;
  o.integrator = spec::Simulation::Integrator::rk4;
  o.formulation = Formulation::relative;
  Simulation s(model, o);
  PrescribedMotion motion;
  for (const std::string& name : joints)
    motion.columns.push_back({find_coordinate(model->spec(), name), {}, {}, {}});
  const Compiled& m = model->compiled();
  for (int k = 0; k <= steps; ++k) {
    if (k > 0) {
      EXPECT_TRUE(s.step().ok());
    }
    const Simulation::Snapshot now = s.save();
    motion.time.push_back(now.time);
    for (PrescribedMotion::Column& c : motion.columns)
      for (const BodyData& b : m.bodies)
        if (b.joint_spec == c.of.joint) {
          c.position.push_back(now.q[b.q]);
          c.velocity.push_back(now.v[b.v]);
          c.acceleration.push_back(now.a[b.v]);
        }
  }
  return motion;
}

std::string arm(const std::string& actuators) {
  return R"(
bodies:
  upper: {mass: 2, com: [0.2, 0, 0], inertia: [0.01, 0.05, 0.05]}
  lower: {mass: 1, com: [0.6, 0.05, 0], inertia: [0.01, 0.02, 0.02]}
joints:
  shoulder: {type: revolute, between: [ground, upper], at: [0, 0, 0], axis: [0, 1, 0.2]}
  elbow: {type: revolute, between: [upper, lower], at: [0.4, 0, 0], axis: [0, 1, 0]}
)" + actuators;
}

TEST(InverseDynamics, ReturnsTheTorquesThatMadeTheMotionOfATree) {
  const auto driven = model_of(arm(R"yaml(
actuators:
  one: {joint: shoulder, torque: "8*sin(3*t) - 5"}
  two: {joint: elbow, torque: "1 + cos(7*t)"}
)yaml"));
  const PrescribedMotion motion = motion_of(driven, {"shoulder", "elbow"}, 0.005, 100);
  const InverseDynamics found = inverse_dynamics(model_of(arm("")), &motion);
  ASSERT_EQ(found.names, (std::vector<std::string>{"shoulder", "elbow"}));
  EXPECT_EQ(found.units[0], "N m");
  EXPECT_EQ(found.free, 0);
  for (Eigen::Index k = 0; k < found.time.size(); ++k) {
    const double t = found.time[k];
    EXPECT_NEAR(found.force(k, 0), 8 * std::sin(3 * t) - 5, 1e-8) << t;
    EXPECT_NEAR(found.force(k, 1), 1 + std::cos(7 * t), 1e-8) << t;
  }
  // Of positions alone, by a spline: with the fourth power of the interval, about, but for its ends.
  PrescribedMotion positions = motion;
  for (auto& c : positions.columns) c.velocity = c.acceleration = {};
  const InverseDynamics near = inverse_dynamics(model_of(arm("")), &positions);
  EXPECT_LT((near.force - found.force).middleRows(3, 88).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(InverseDynamics, ReturnsTheTorqueThatMadeTheMotionOfALoop) {
  const std::map<std::string, std::string> cut{{"rocker_pin", ", axis: [0, 1, 0], cut: always"}};
  const auto text = [&](const std::string& more) { return four_bar_text(cut, "revolute") + more; };
  const auto driven = model_of(text("actuators: {one: {joint: crank, torque: \"2 + sin(4*t)\"}}"));
  const PrescribedMotion motion = motion_of(driven, {"crank"}, 0.002, 150);
  const InverseDynamics found = inverse_dynamics(model_of(text("")), &motion);
  for (Eigen::Index k = 0; k < found.time.size(); ++k)
    EXPECT_NEAR(found.force(k, 0), 2 + std::sin(4 * found.time[k]), 1e-8) << found.time[k];

  // At another joint, whose power is the same; and at both the smallest.
  InverseDynamicsOptions other;
  other.forces = {find_coordinate(driven->spec(), "rocker")};
  const InverseDynamics at_rocker = inverse_dynamics(model_of(text("")), &motion, other);
  EXPECT_EQ(at_rocker.names, std::vector<std::string>{"rocker"});
  InverseDynamicsOptions both;
  both.forces = {find_coordinate(driven->spec(), "crank"), find_coordinate(driven->spec(), "rocker")};
  const InverseDynamics shared = inverse_dynamics(model_of(text("")), &motion, both);
  EXPECT_EQ(shared.redundant, 1);
  EXPECT_EQ(shared.warnings.size(), 1u);
  for (Eigen::Index k = 20; k < found.time.size(); k += 10) {
    const double power = found.force(k, 0) * found.velocity(k, 0);
    EXPECT_NEAR(at_rocker.force(k, 0) * at_rocker.velocity(k, 0), power, 1e-8 * std::abs(power));
    const Eigen::Vector2d u = shared.force.row(k), v = shared.velocity.row(k);
    EXPECT_NEAR(u.dot(v), power, 1e-8 * std::abs(power));
    EXPECT_NEAR(u[0] * v[1] - u[1] * v[0], 0, 1e-7 * u.norm() * v.norm());
  }
}

/// A chain of revolute joints, all drawn in global axes.
struct Chain {
  explicit Chain(unsigned seed) {
    Random random(seed);
    Vector3d at = Vector3d::Zero();
    const int count = 2 + random.index(6);
    for (int k = 0; k < count; ++k) {
      Link link;
      link.joint = at;
      link.axis = random.vector(1).normalized();
      at += random.vector(0.5);
      link.com = (link.joint + at) / 2 + random.vector(0.1);
      link.mass = random.number(0.5, 4);
      const Vector3d d(random.number(0.2, 1), random.number(0.2, 1), random.number(0.2, 1));
      link.inertia = 0.01 * Vector3d(d[1] + d[2], d[0] + d[2], d[0] + d[1]);
      links.push_back(link);
    }
    std::string bodies, joints;
    for (std::size_t k = 0; k < links.size(); ++k) {
      bodies += fmt::format("  b{}: {{mass: {}, com: {}, inertia: {}}}\n", k, links[k].mass,
                            list(links[k].com), list(links[k].inertia));
      joints += fmt::format("  j{}: {{type: revolute, between: [{}, b{}], at: {}, axis: {}}}\n", k,
                            k == 0 ? "ground" : fmt::format("b{}", k - 1), k, list(links[k].joint),
                            list(links[k].axis));
    }
    text = "bodies:\n" + bodies + "joints:\n" + joints;
  }
  /// Recursive Newton–Euler in global axes (Luh, Walker, Paul 1980).
  std::vector<double> torques(const std::vector<double>& q, const std::vector<double>& v,
                              const std::vector<double>& a) const {
    const std::size_t n = links.size();
    std::vector<Vector3d> place(n), axis(n), centre(n), force(n), moment(n);
    Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
    Vector3d p = Vector3d::Zero(), omega = p, alpha = p, acceleration(0, 0, 9.81), last = p;
    for (std::size_t k = 0; k < n; ++k) {
      const Link& l = links[k];
      const Vector3d arm = A * (l.joint - last);
      p += arm;
      acceleration += alpha.cross(arm) + omega.cross(omega.cross(arm));
      axis[k] = A * l.axis;
      alpha += axis[k] * a[k] + omega.cross(axis[k] * v[k]);
      omega += axis[k] * v[k];
      A = A * Eigen::AngleAxisd(q[k], l.axis);
      place[k] = p;
      const Vector3d r = A * (l.com - l.joint);
      centre[k] = p + r;
      force[k] = l.mass * (acceleration + alpha.cross(r) + omega.cross(omega.cross(r)));
      const Eigen::Matrix3d I = A * l.inertia.asDiagonal() * A.transpose();
      moment[k] = I * alpha + omega.cross(I * omega);
      last = l.joint;
    }
    std::vector<double> out(n);
    Vector3d f = Vector3d::Zero(), m = f;  // about the joint behind
    for (std::size_t k = n; k-- > 0;) {
      if (k + 1 < n) m += (place[k + 1] - place[k]).cross(f);
      m += moment[k] + (centre[k] - place[k]).cross(force[k]);
      f += force[k];
      out[k] = axis[k].dot(m);
    }
    return out;
  }

  struct Link {
    Vector3d joint, axis, com, inertia;
    double mass;
  };
  std::vector<Link> links;
  std::string text;
};

TEST(InverseDynamics, EqualsAnIndependentRecursionForThirtyRobots) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const Chain chain(seed);
    const auto model = model_of(chain.text);
    Random random(seed + 100);
    PrescribedMotion motion;
    for (int k = 0; k < 5; ++k) motion.time.push_back(0.1 * k);
    for (std::size_t j = 0; j < chain.links.size(); ++j) {
      PrescribedMotion::Column c{find_coordinate(model->spec(), fmt::format("j{}", j)), {}, {}, {}};
      for (int k = 0; k < 5; ++k) {
        c.position.push_back(random.number(-2, 2));
        c.velocity.push_back(random.number(-3, 3));
        c.acceleration.push_back(random.number(-9, 9));
      }
      motion.columns.push_back(c);
    }
    const InverseDynamics found = inverse_dynamics(model, &motion);
    for (int k = 0; k < 5; ++k) {
      std::vector<double> q, v, a;
      const auto at = static_cast<std::size_t>(k);
      for (const auto& c : motion.columns) {
        q.push_back(c.position[at]);
        v.push_back(c.velocity[at]);
        a.push_back(c.acceleration[at]);
      }
      const std::vector<double> expected = chain.torques(q, v, a);
      for (std::size_t j = 0; j < expected.size(); ++j)
        EXPECT_NEAR(found.force(k, static_cast<Eigen::Index>(j)), expected[j],
                    1e-9 * std::max(10.0, std::abs(expected[j])))
            << seed;
    }
  }
}

/// A mass that a spring holds to a slider: where the motion is slow both answers are the same.
TEST(InverseDynamics, LetsWhatSpringsHoldFollow) {
  const auto text = [](const std::string& law) {
    return fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  cart: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
  load: {{mass: 0.5, com: [1, 0, 0], inertia: [1, 1, 1]}}
joints:
  rail: {{type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0], drive: {{position: "{}"}}}}
  slide: {{type: prismatic, between: [cart, load], at: [1, 0, 0], axis: [1, 0, 0], spring: {{stiffness: 200}}}}
simulation: {{end: 1, step: 0.001}}
)",
                       law);
  };
  // Quasi-static: both masses are accelerated, the spring bends by −m a / k.
  InverseDynamicsOptions quasistatic;
  quasistatic.flexible = InverseDynamicsOptions::Flexible::quasistatic;
  quasistatic.steps = 20;
  const InverseDynamics still = inverse_dynamics(model_of(text("0.1*t^2")), nullptr, quasistatic);
  EXPECT_EQ(still.free, 1);
  EXPECT_LT((still.force.array() - 1.5 * 0.2).abs().maxCoeff(), 1e-9);
  // By its own dynamics: steady vibration ẍ = −k/m x − a of x(0) = 0.
  InverseDynamicsOptions dynamic;
  dynamic.steps = 20;
  const InverseDynamics moving = inverse_dynamics(model_of(text("0.1*t^2")), nullptr, dynamic);
  for (Eigen::Index k = 1; k < moving.time.size(); ++k) {
    const double x = -0.2 * 0.5 / 200 * (1 - std::cos(20 * moving.time[k]));
    EXPECT_NEAR(moving.force(k, 0), 0.2 - 200 * x, 2e-4);
  }
}

/// A motion without a start of its own is the same whenever its table begins, also where it begins with a
/// speed: what springs hold starts with it, and friction slides from its first instant on.
TEST(InverseDynamics, DoesNotDependOnWhenTheTableBegins) {
  const auto model_with = [](const std::string& more) {
    return model_of(R"(
bodies:
  cart: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  load: {mass: 0.5, com: [1, 0, 0], inertia: [1, 1, 1]}
joints:
  rail: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0]}
  slide: {type: prismatic, between: [cart, load], at: [1, 0, 0], axis: [1, 0, 0], spring: {stiffness: 200}}
frictions: {f: {joint: rail, force: 1.5}}
simulation: {end: 1, step: 0.001}
)" + more);
  };
  const auto forces = [](const std::shared_ptr<const Model>& model, double begin,
                         InverseDynamicsOptions::Flexible flexible) {
    PrescribedMotion motion;
    PrescribedMotion::Column c{find_coordinate(model->spec(), "rail"), {}, {}, {}};
    for (int k = 0; k <= 40; ++k) {
      const double t = 0.025 * k;
      motion.time.push_back(begin + t);
      c.position.push_back(0.3 * std::sin(1.5 * t));
      c.velocity.push_back(0.45 * std::cos(1.5 * t));
      c.acceleration.push_back(-0.675 * std::sin(1.5 * t));
    }
    motion.columns.push_back(c);
    InverseDynamicsOptions options;
    options.flexible = flexible;
    return VectorXd(inverse_dynamics(model, &motion, options).force.col(0));
  };
  using Flexible = InverseDynamicsOptions::Flexible;
  const auto level = model_with("gravity: [0, 0, 0]\n"),
             hanging = model_with("gravity: [9.81, 0, 0]\ninitial: equilibrium\n");
  EXPECT_NEAR(forces(level, 0, Flexible::dynamic)[0], 1.5, 1e-6);
  EXPECT_NEAR(forces(hanging, 0, Flexible::dynamic)[0], 1.5 - 1.5 * 9.81, 1e-3);
  for (const auto& model : {level, hanging})
    for (const auto flexible : {Flexible::dynamic, Flexible::quasistatic}) {
      const VectorXd at_once = forces(model, 0, flexible);
      for (const double begin : {0.5, 20.0})
        EXPECT_LT((forces(model, begin, flexible) - at_once).cwiseAbs().maxCoeff(), 1e-6) << begin;
    }
}

/// A drive's own motion: friction slides against it in the first row too, also on a cut hinge.
TEST(InverseDynamics, FrictionSlidesFromTheFirstInstantOn) {
  const auto model = model_of(R"(
gravity: [0, 0, 0]
bodies:
  crank: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 0, 1], drive: {position: sin(t)}}
  cut: {type: revolute, between: [ground, crank], at: [0, 0, 1], axis: [0, 0, 1], cut: always}
frictions: {f: {joint: crank, torque: 1.5}, g: {joint: cut, torque: 0.5}}
simulation: {end: 3, step: 0.001}
)");
  InverseDynamicsOptions options;
  for (const double start : {0.0, 2.5}) {
    options.start = start;
    options.end = start + 0.1;
    options.steps = 10;
    const InverseDynamics found = inverse_dynamics(model, nullptr, options);
    for (Eigen::Index k = 0; k <= 10; ++k)
      EXPECT_NEAR(found.force(k, 0), 0.01 * -std::sin(found.time[k]) + (start > 0 ? -2 : 2), 1e-6)
          << start << " " << k;
  }
}

/// A bending arm: the torque that made its motion comes back, from rest on, where nothing acts yet.
TEST(InverseDynamics, ReturnsTheTorqueThatMovedAFlexibleArm) {
  const auto text = [](const std::string& more) {
    return R"(
gravity: [0, 0, 0]
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {bar: {type: round, diameter: 0.02}}
bodies:
  arm:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: bar
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {all: {from: root, to: tip, elements: 8}}
      clamped: [root]
      dynamic_modes: 4
joints:
  hub: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1]}
simulation: {end: 0.5, step: 0.0001}
)" + more;
  };
  const auto driven = model_of(text("actuators: {motor: {joint: hub, torque: '2*sin(4*t)^4'}}\n"));
  const PrescribedMotion motion = motion_of(driven, {"hub"}, 1e-4, 5000);
  InverseDynamicsOptions options;
  options.step = 1e-4;
  const InverseDynamics found = inverse_dynamics(model_of(text("")), &motion, options);
  EXPECT_GT(found.free, 0);
  EXPECT_LT(found.residual, 1e-9);
  for (Eigen::Index k = 0; k < found.time.size(); ++k)
    ASSERT_NEAR(found.force(k, 0), 2 * std::pow(std::sin(4 * found.time[k]), 4), 1e-6) << found.time[k];
}

std::string message(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(InverseDynamics, RefusesWhatCannotBeByName) {
  EXPECT_THAT(message([] { inverse_dynamics(model_of(arm(""))); }), HasSubstr("nothing prescribes a motion"));
  const auto model = model_of(arm(""));
  PrescribedMotion motion;
  motion.time = {0, 0.1, 0.2};
  motion.columns = {{find_coordinate(model->spec(), "shoulder"), {0, 0.1, 0.2}, {}, {}},
                    {find_coordinate(model->spec(), "elbow"), {0, 0.1, 0.4}, {}, {}}};
  InverseDynamicsOptions one;
  one.forces = {find_coordinate(model->spec(), "shoulder")};
  EXPECT_THAT(message([&] { inverse_dynamics(model, &motion, one); }),
              HasSubstr("forces along 'shoulder' cannot make this motion"));
  EXPECT_THAT(message([&] { find_coordinate(model->spec(), "elbo"); }), HasSubstr("elbow"));
  PrescribedMotion short_one = motion;
  short_one.columns[0].position.pop_back();
  EXPECT_THAT(message([&] { inverse_dynamics(model, &short_one); }),
              HasSubstr("'shoulder' has 2 positions at 3 instants"));
  PrescribedMotion backwards = motion;
  backwards.time = {0, 0.2, 0.1};
  EXPECT_THAT(message([&] { inverse_dynamics(model, &backwards); }), HasSubstr("must ascend"));
  PrescribedMotion one_instant = motion;
  one_instant.time = {0};
  for (PrescribedMotion::Column& column : one_instant.columns) column.position = {0};
  EXPECT_THAT(message([&] { inverse_dynamics(model, &one_instant); }), HasSubstr("has one instant; two are"));
}

TEST(InverseDynamics, ReadsTablesOfMotionAndNamesTheirFaults) {
  const auto model = model_of(arm(""));
  const std::string path = testing::TempDir() + "motion.csv";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return read_motion_table(path, model->spec());
  };
  const PrescribedMotion motion =
      read("time [s],shoulder [rad],elbow,elbow.velocity,elbow.acceleration\n0,0,1,2,3\n1,0.5,4,5,6\n");
  ASSERT_EQ(motion.columns.size(), 2u);
  EXPECT_EQ(motion.time, (std::vector<double>{0, 1}));
  EXPECT_EQ(motion.columns[1].acceleration, (std::vector<double>{3, 6}));
  EXPECT_EQ(read("time,joint.elbow.position\n0,1\n1,2\n").columns[0].position, (std::vector<double>{1, 2}));
  EXPECT_THAT(message([&] { read("time,elbo\n0,1\n"); }),
              HasSubstr("'elbo' is not a coordinate of a joint of the model (did you mean 'elbow'?)"));
  EXPECT_THAT(message([&] { read("time,elbow [m]\n0,1\n"); }), HasSubstr("rad"));
  EXPECT_THAT(message([&] { read("time,elbow\n0,x\n"); }), HasSubstr("is not a number"));
  EXPECT_THAT(message([&] { read("time,elbow\n1,1\n0,1\n"); }), HasSubstr("do not increase"));
  EXPECT_THAT(message([&] { read("time,elbow,shoulder\n0,1,2\n1,,2\n"); }), HasSubstr("without a number"));
  EXPECT_THAT(message([&] { read("time,elbow.velocity,elbow.acceleration\n0,1,2\n"); }),
              HasSubstr("has no positions of 'elbow'"));
  EXPECT_THAT(message([&] { read(""); }), HasSubstr("no line"));
}

/// Of few instants as of many: 5 rad from one to the next on a screw, whose nut of 1 kg climbs 2 mm a turn
/// against a spring.
TEST(InverseDynamics, InstantsMayBeFarApart) {
  const auto force = [](int steps) {
    InverseDynamicsOptions o;
    o.end = 5;
    o.steps = steps;
    const InverseDynamics r = inverse_dynamics(model_of(R"(
gravity: [0, 0, -9.81]
bodies: {nut: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}}
joints: {p: {type: cylindrical, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1], drive: {coordinate: 0, speed: '20'}}}
constraints: {s: {type: screw, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1], lead: 2 mm}}
springs: {k: {between: [ground, nut], at: [[0, 0, -1], [0, 0, 0]], elastic: {stiffness: 1000, zero: 1}}}
)"),
                                               nullptr, o);
    return r.force(r.force.rows() - 1, 0);
  };
  const double lead = 0.002 / (2 * std::acos(-1.0)), right = (9.81 + 1000 * 100 * lead) * lead;
  for (const int steps : {4, 20, 100}) EXPECT_NEAR(force(steps), right, 1e-9) << steps;
}

/// The same from rest to rest, where nothing is known of the way at first: at its end the weight and the
/// spring.
TEST(InverseDynamics, InstantsMayBeFarApartFromRest) {
  InverseDynamicsOptions o;
  o.end = 1;
  o.steps = 1;
  const InverseDynamics r = inverse_dynamics(model_of(R"y(
gravity: [0, 0, -9.81]
bodies: {nut: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}}
joints:
  p:
    type: cylindrical
    between: [ground, nut]
    at: [0, 0, 0]
    axis: [0, 0, 1]
    drive: {coordinate: 0, position: "100*(t^3*(10 - 15*t + 6*t^2))"
}
constraints : {
s : {
type:
  screw, between : [ ground, nut ], at : [ 0, 0, 0 ], axis : [ 0, 0, 1 ], lead : 2 mm
}
}
springs: {k: {between: [ground, nut], at: [[0, 0, -1], [0, 0, 0]], elastic: {stiffness: 1000, zero: 1}}}
)y"),
                                             nullptr, o);
  const double lead = 0.002 / (2 * std::acos(-1.0));
  EXPECT_NEAR(r.force(1, 0), (9.81 + 1000 * 100 * lead) * lead, 1e-9);
}

}  // namespace
}  // namespace mimbre::test::inverse_dynamics_test
