#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "mimbre/diagnostics.h"
#include "mimbre/equilibrium_path.h"
#include "support/models.h"

/// Paths of equilibria against closed forms.
namespace mimbre::test::equilibrium_path_test {
namespace {

using testing::HasSubstr;
using Kind = PathPoint::Kind;

double value(const EquilibriumPath& path, const PathPoint& point, const std::string& channel) {
  for (std::size_t k = 0; k < path.channels.size(); ++k)
    if (path.channels[k].name == channel) return point.values[static_cast<Eigen::Index>(k)];
  ADD_FAILURE() << "no channel " << channel;
  return 0;
}

std::vector<PathPoint> special(const PathBranch& branch, Kind kind) {
  std::vector<PathPoint> out;
  for (const PathPoint& point : branch.points)
    if (point.kind == kind) out.push_back(point);
  return out;
}

EquilibriumPath path_of(const std::string& text, double to,
                        const std::function<void(EquilibriumPathOptions&)>& more = {}) {
  EquilibriumPathOptions options;
  options.to = to;
  if (more) more(options);
  return equilibrium_path(model_of(text), options);
}

/// A rigid column of 1 m on a hinge with a spring of 10 N m/rad, pressed by 1 N; it leans by `lean`.
std::string column(double lean) {
  return fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  column: {{mass: 1, com: [0, 0, 0.5], inertia: [0.1, 0.1, 0.1]}}
frames: {{top: {{body: column, at: [0, 0, 1]}}}}
joints:
  foot: {{type: revolute, between: [ground, column], at: [0, 0, 0], axis: [0, 1, 0], position: {},
         spring: {{stiffness: 10, zero: {}}}}}
loads: {{press: {{on: top, force: [0, 0, -1]}}}}
outputs:
  - {{name: angle, joint: foot}}
  - {{name: height, position: column, at: [0, 0, 1], component: z}}
)",
                     lean, lean);
}

/// P sin θ = k θ: from P = k on, stable.
TEST(EquilibriumPath, OfAColumnBeyondItsBucklingLoad) {
  const EquilibriumPath path = path_of(column(0), 15);
  ASSERT_EQ(path.branches.size(), 3u);
  const auto found = special(path.branches[0], Kind::bifurcation);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].factor, 10, 1e-7);
  EXPECT_THAT(found[0].moving, HasSubstr("'foot' 100 %"));
  EXPECT_EQ(path.branches[0].points.back().unstable, 1);
  EXPECT_EQ(path.branches[0].points.back().factor, 15);
  for (std::size_t k = 1; k < 3; ++k) {
    const PathBranch& branch = path.branches[k];
    EXPECT_EQ(branch.parent, 0);
    EXPECT_NEAR(branch.leaves_at, 10, 1e-7);
    EXPECT_NEAR(branch.points.back().factor, 15, 1e-12);
    EXPECT_TRUE(branch.end.empty()) << branch.end;
    const double sign = value(path, branch.points.back(), "angle") > 0 ? 1 : -1;
    EXPECT_EQ(sign, branch.sense * (value(path, path.branches[1].points.back(), "angle") > 0 ? 1 : -1));
    for (std::size_t i = 1; i < branch.points.size(); ++i) {
      const double angle = value(path, branch.points[i], "angle");
      EXPECT_NEAR(branch.points[i].factor * std::sin(angle), 10 * angle, 1e-8);
      EXPECT_EQ(branch.points[i].unstable, 0);
      EXPECT_NEAR(value(path, branch.points[i], "height"), std::cos(angle), 1e-9);
    }
  }
}

/// One that leans has no bifurcation: P sin θ = k (θ − lean) all along.
TEST(EquilibriumPath, OfAColumnThatLeansHasNone) {
  const EquilibriumPath path = path_of(column(0.01), 20);
  ASSERT_EQ(path.branches.size(), 1u);
  EXPECT_TRUE(special(path.branches[0], Kind::bifurcation).empty());
  for (const PathPoint& point : path.branches[0].points) {
    const double angle = value(path, point, "angle");
    EXPECT_NEAR(point.factor * std::sin(angle), 10 * (angle - 0.01), 1e-8);
    EXPECT_EQ(point.unstable, 0);
  }
  EXPECT_GT(value(path, path.branches[0].points.back(), "angle"), 1.5);
}

/// Two springs of natural length 1 m from (±0.8, 0) to a mass at the height 0.6 that slides down: the force
/// 2 k (1 − l) h / l has a largest value at l³ = 0.64, a smallest one below.
const char* const arch = R"(
gravity: [0, 0, 0]
bodies: {crown: {mass: 1, com: [0, 0, 0.6], inertia: [1, 1, 1]}}
frames: {top: {body: crown, at: [0, 0, 0.6]}}
joints: {guide: {type: prismatic, between: [ground, crown], at: [0, 0, 0.6], axis: [0, 0, 1]}}
springs:
  left: {between: [ground, crown], at: [[-0.8, 0, 0], [0, 0, 0.6]], elastic: {stiffness: 100, zero: 1}}
  right: {between: [ground, crown], at: [[0.8, 0, 0], [0, 0, 0.6]], elastic: {stiffness: 100, zero: 1}}
loads: {press: {on: top, force: [0, 0, -1]}}
outputs: [{name: height, position: crown, at: [0, 0, 0.6], component: z}]
)";

TEST(EquilibriumPath, OfAnArchThatSnapsThrough) {
  const EquilibriumPath path = path_of(arch, 30);
  ASSERT_EQ(path.branches.size(), 1u);
  const auto force = [](double h) {
    const double l = std::hypot(0.8, h);
    return 200 * (1 - l) * h / l;
  };
  const double l = std::cbrt(0.64), h = std::sqrt(l * l - 0.64);
  const auto limits = special(path.branches[0], Kind::limit);
  ASSERT_EQ(limits.size(), 2u);
  EXPECT_NEAR(limits[0].factor, force(h), 1e-7);
  EXPECT_NEAR(value(path, limits[0], "height"), h, 1e-6);
  EXPECT_NEAR(limits[1].factor, -force(h), 1e-7);
  bool was_unstable = false;
  for (const PathPoint& point : path.branches[0].points) {
    const double height = value(path, point, "height");
    EXPECT_NEAR(point.factor, force(height), 1e-7);
    if (point.kind != Kind::regular) continue;
    EXPECT_EQ(point.unstable, std::abs(height) < h ? 1 : 0);
    was_unstable = was_unstable || point.unstable > 0;
  }
  EXPECT_TRUE(was_unstable);
  EXPECT_EQ(path.branches[0].points.back().factor, 30);
  EXPECT_LT(value(path, path.branches[0].points.back(), "height"), -0.6);
}

/// A toggle: two bars of 1 m, the one on a hinge, the other on a slide with a spring of 1 kN/m, in a loop
/// whose equations repeat each other: F = 4 k (cos θ − 0.8) tan θ, largest at cos³ θ = 0.8.
TEST(EquilibriumPath, OfAToggleInALoop) {
  const char* const toggle = R"(
gravity: [0, 0, 0]
bodies:
  a: {mass: 1, com: [-0.4, 0, 0.3], inertia: [1, 1, 1]}
  b: {mass: 1, com: [0.4, 0, 0.3], inertia: [1, 1, 1]}
  foot: {mass: 1, com: [0.8, 0, 0], inertia: [1, 1, 1]}
frames: {top: {body: a, at: [0, 0, 0.6]}}
joints:
  left: {type: revolute, between: [ground, a], at: [-0.8, 0, 0], axis: [0, 1, 0]}
  crown: {type: revolute, between: [a, b], at: [0, 0, 0.6], axis: [0, 1, 0]}
  right: {type: revolute, between: [b, foot], at: [0.8, 0, 0], axis: [0, 1, 0]}
  slide: {type: prismatic, between: [ground, foot], at: [0.8, 0, 0], axis: [1, 0, 0], spring: {stiffness: 1000}}
loads: {press: {on: top, force: [0, 0, -1]}}
outputs: [{name: height, position: a, at: [0, 0, 0.6], component: z}]
)";
  const EquilibriumPath path = path_of(toggle, 500);
  const auto force = [](double angle) { return 4000 * (std::cos(angle) - 0.8) * std::tan(angle); };
  const auto limits = special(path.branches[0], Kind::limit);
  ASSERT_EQ(limits.size(), 2u);
  const double angle = std::acos(std::cbrt(0.8));
  EXPECT_NEAR(limits[0].factor, force(angle), 1e-5);
  EXPECT_NEAR(limits[1].factor, -force(angle), 1e-5);
  for (const PathPoint& point : path.branches[0].points)
    EXPECT_NEAR(point.factor, force(std::asin(value(path, point, "height"))), 1e-5);
  EXPECT_EQ(path.branches[0].points.back().factor, 500);
}

/// Two links in line with equal springs in both hinges: in absolute angles K = [[2, -1], [-1, 1]] k, P l of
/// the eigenvalues (3 ∓ √5)/2 k, and beyond them k θ1 + k (θ1 − θ2) = P l sin θ1, k (θ2 − θ1) = P l sin θ2.
TEST(EquilibriumPath, OfTwoLinksBucklesTwice) {
  const char* const links = R"(
gravity: [0, 0, 0]
bodies:
  lower: {mass: 1, com: [0, 0, 0.5], inertia: [0.1, 0.1, 0.1]}
  upper: {mass: 1, com: [0, 0, 1.5], inertia: [0.1, 0.1, 0.1]}
frames: {top: {body: upper, at: [0, 0, 2]}}
joints:
  foot: {type: revolute, between: [ground, lower], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 10}}
  knee: {type: revolute, between: [lower, upper], at: [0, 0, 1], axis: [0, 1, 0], spring: {stiffness: 10}}
loads: {press: {on: top, force: [0, 0, -1]}}
outputs: [{name: foot, joint: foot}, {name: knee, joint: knee}]
)";
  const EquilibriumPath path =
      path_of(links, 30, [](EquilibriumPathOptions& options) { options.bifurcations = 2; });
  const auto found = special(path.branches[0], Kind::bifurcation);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].factor, 5 * (3 - std::sqrt(5.0)), 1e-6);
  EXPECT_NEAR(found[1].factor, 5 * (3 + std::sqrt(5.0)), 1e-6);
  ASSERT_EQ(path.branches.size(), 5u);
  for (std::size_t k = 1; k < 5; ++k) {
    const PathBranch& branch = path.branches[k];
    EXPECT_GT(branch.points.size(), 5u);
    for (const PathPoint& point : branch.points) {
      const double first = value(path, point, "foot"), knee = value(path, point, "knee");
      EXPECT_NEAR(10 * first - 10 * knee, point.factor * std::sin(first), 1e-7);
      EXPECT_NEAR(10 * knee, point.factor * std::sin(first + knee), 1e-7);
    }
    EXPECT_EQ(branch.points.back().unstable, k < 3 ? 0 : 1);
  }
}

/// A cantilever under a load along it, by corotational elements: the elastica has P/P₁ = (2 K(p)/π)² with
/// p = sin(α/2), α the angle at the tip, which is at 2 E(p)/K(p) − 1 along and 2 p/K(p) across (Timoshenko,
/// Gere, Theory of elastic stability, 1961, 2.7).
TEST(EquilibriumPath, OfACantileverIsTheElastica) {
  const char* const beam = R"(
gravity: [0, 0, 0]
materials: {unit: {young: 1e6, poisson: 0.3, density: 1}}
sections: {unit: {area: 1, Iy: 1e-6, Iz: 1e-4, J: 1e-5}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: unit
      section: unit
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 12, y: [0, 1, 0]}}
      clamped: [root]
      beam: corotational
joints: {base: {type: fixed, between: [ground, beam], at: [0, 0, 0]}}
loads: {press: {on: beam.tip, force: [-1, 0, 0]}}
outputs:
  - {name: x, position: beam.tip, component: x}
  - {name: z, position: beam.tip, component: z}
)";
  const double buckles = std::numbers::pi * std::numbers::pi / 4;
  const EquilibriumPath path = path_of(beam, 1.8 * buckles);
  const auto found = special(path.branches[0], Kind::bifurcation);
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found[0].factor / buckles, 1, 2e-3);
  ASSERT_EQ(path.branches.size(), 3u);
  for (std::size_t k = 1; k < 3; ++k) {
    EXPECT_EQ(path.branches[k].points.back().factor, 1.8 * buckles);
    EXPECT_EQ(path.branches[k].points.back().unstable, 0);
    for (const PathPoint& point : path.branches[k].points) {
      const double K = std::numbers::pi / 2 * std::sqrt(point.factor / found[0].factor);
      double low = 0, high = 0.999999;
      while (high - low > 1e-12) {
        const double p = (low + high) / 2;
        (std::comp_ellint_1(p) < K ? low : high) = p;
      }
      if (low < 0.05) continue;
      EXPECT_NEAR(value(path, point, "x"), 2 * std::comp_ellint_2(low) / K - 1, 4e-3);
      EXPECT_NEAR(std::abs(value(path, point, "z")), 2 * low / K, 4e-3);
    }
  }
}

/// A column of the stiffness k along a direction in space, so that nothing is zero by luck.
std::string column_in_space(double k, const Eigen::Vector3d& up) {
  const Eigen::Vector3d axis = up.unitOrthogonal();
  const auto list = [](const Eigen::Vector3d& v) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v[0], v[1], v[2]);
  };
  return fmt::format(R"(
gravity: [0, 0, 0]
bodies: {{column: {{mass: 1, com: {}, inertia: [0.1, 0.1, 0.1]}}}}
frames: {{top: {{body: column, at: {}}}}}
joints:
  foot: {{type: revolute, between: [ground, column], at: [0, 0, 0], axis: {}, spring: {{stiffness: {}}}}}
loads: {{press: {{on: top, force: {}}}}}
outputs: [{{name: angle, joint: foot}}]
)",
                     list(0.5 * up), list(up), list(axis), k, list(-up));
}

TEST(EquilibriumPath, FindsBifurcationsThatRoundOffBlurs) {
  for (const Eigen::Vector3d& up : {Eigen::Vector3d(0.54, 0.41, 0.73), Eigen::Vector3d(-0.3, 0.9, 0.1)})
    for (const double k : {3., 4.3, 5., 7.7, 10., 13.}) {
      SCOPED_TRACE(fmt::format("k = {}, up {}", k, up.x()));
      const EquilibriumPath path = path_of(column_in_space(k, up.normalized()), 15);
      EXPECT_TRUE(path.warnings.empty()) << path.warnings.front();
      const auto found = special(path.branches[0], Kind::bifurcation);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_NEAR(found[0].factor, k, 1e-7 * k);
      EXPECT_EQ(found[0].unstable, 0);
      ASSERT_EQ(path.branches.size(), 3u);
      for (std::size_t b = 1; b < 3; ++b) {
        EXPECT_EQ(path.branches[b].points.back().factor, 15) << path.branches[b].end;
        for (const PathPoint& point : path.branches[b].points) {
          const double angle = value(path, point, "angle");
          EXPECT_NEAR(point.factor * std::sin(angle), k * angle, 1e-6);
          EXPECT_EQ(point.unstable, 0);
        }
      }
    }
}

/// Two columns with a bar across their tops, in a loop.
TEST(EquilibriumPath, OfAParallelogramBuckles) {
  for (const double k : {3., 6.1, 10., 13.}) {
    const EquilibriumPath path = path_of(fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  l: {{mass: 1, com: [0, 0, 0.5], inertia: [0.1, 0.1, 0.1]}}
  r: {{mass: 1, com: [1, 0, 0.5], inertia: [0.1, 0.1, 0.1]}}
  c: {{mass: 1, com: [0.5, 0, 1], inertia: [0.1, 0.1, 0.1]}}
frames: {{top: {{body: c, at: [0.5, 0, 1]}}}}
joints:
  a: {{type: revolute, between: [ground, l], at: [0, 0, 0], axis: [0, 1, 0], spring: {{stiffness: {}}}}}
  b: {{type: revolute, between: [ground, r], at: [1, 0, 0], axis: [0, 1, 0]}}
  d: {{type: revolute, between: [l, c], at: [0, 0, 1], axis: [0, 1, 0]}}
  e: {{type: revolute, between: [r, c], at: [1, 0, 1], axis: [0, 1, 0]}}
loads: {{press: {{on: top, force: [0, 0, -1]}}}}
outputs: [{{name: angle, joint: a}}]
)",
                                                     k),
                                         15);
    const auto found = special(path.branches[0], Kind::bifurcation);
    ASSERT_EQ(found.size(), 1u) << k;
    EXPECT_NEAR(found[0].factor, k, 1e-6 * k);
    ASSERT_EQ(path.branches.size(), 3u);
    for (std::size_t b = 1; b < 3; ++b) EXPECT_EQ(path.branches[b].points.back().factor, 15);
  }
}

/// P = k θ / sin θ grows without bounds towards π: no step leads to where it comes back from below.
TEST(EquilibriumPath, DoesNotJumpAcrossAPole) {
  const EquilibriumPath path = path_of(column(0), 1500);
  for (const PathBranch& branch : path.branches)
    for (const PathPoint& point : branch.points) {
      EXPECT_LT(std::abs(value(path, point, "angle")), std::numbers::pi);
      EXPECT_GE(point.factor, 0);
    }
}

/// The last factor at the buckling load, just beyond it, and just below a limit.
TEST(EquilibriumPath, EndsAtTheLastFactor) {
  const EquilibriumPath at = path_of(column(0), 10);
  EXPECT_EQ(at.branches[0].points.back().kind, Kind::bifurcation);
  const EquilibriumPath beyond = path_of(column(0), 10.0005);
  ASSERT_EQ(beyond.branches.size(), 3u);
  for (const PathBranch& branch : beyond.branches) EXPECT_LE(branch.points.back().factor, 10.0005);
  const double limit = 10.278155663;
  for (const double below : {1e-2, 1e-4, 1e-6}) {
    const EquilibriumPath path = path_of(arch, limit - below);
    EXPECT_EQ(path.branches[0].points.back().factor, limit - below);
    EXPECT_GT(value(path, path.branches[0].points.back(), "height"), 0.3);
  }
}

/// Where a stop is reached the path has a corner.
TEST(EquilibriumPath, GoesRoundCorners) {
  const EquilibriumPath path = path_of(R"(
gravity: [0, 0, 0]
bodies: {block: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
frames: {c: {body: block, at: [0, 0, 0]}}
joints:
  slide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0],
          spring: {elastic: {table: [[-1, -10], [0.3, 3], [1.3, 1003]], interpolation: linear}}}
loads: {push: {on: c, force: [1, 0, 0]}}
outputs: [{name: x, joint: slide}]
)",
                                       50);
  EXPECT_EQ(path.branches[0].points.back().factor, 50) << path.branches[0].end;
  for (const PathPoint& point : path.branches[0].points) {
    const double x = value(path, point, "x");
    EXPECT_NEAR(point.factor, x < 0.3 ? 10 * x : 3 + 1000 * (x - 0.3), 1e-7);
    EXPECT_EQ(point.kind, Kind::regular);
  }
}

/// A round column may fall to any side: turning about its axis resists nothing, and is no bifurcation.
TEST(EquilibriumPath, OfARoundColumnHasNoFalseBifurcations) {
  const EquilibriumPath path = path_of(R"(
gravity: [0, 0, 0]
bodies: {column: {mass: 1, com: [0, 0, 0.5], inertia: [0.1, 0.1, 0.1]}}
frames: {top: {body: column, at: [0, 0, 1]}}
joints: {foot: {type: spherical, between: [ground, column], at: [0, 0, 0]}}
bushings: {b: {between: [ground, column], at: [0, 0, 0], stiffness: [0, 0, 0, 10, 10, 10]}}
loads: {press: {on: top, force: [0, 0, -1]}}
outputs: [{name: z, position: column, at: [0, 0, 1], component: z}]
)",
                                       15);
  ASSERT_EQ(path.branches.size(), 3u);
  EXPECT_EQ(special(path.branches[0], Kind::bifurcation).size(), 2u);
  ASSERT_EQ(path.warnings.size(), 1u);
  EXPECT_THAT(path.warnings[0], HasSubstr("several motions lose their stiffness at once"));
  for (std::size_t b = 1; b < 3; ++b) {
    for (std::size_t k = 1; k < path.branches[b].points.size(); ++k) {
      EXPECT_EQ(path.branches[b].points[k].kind, Kind::regular);
      EXPECT_EQ(path.branches[b].points[k].unstable, 0);
      const double angle = std::acos(value(path, path.branches[b].points[k], "z"));
      EXPECT_NEAR(path.branches[b].points[k].factor * std::sin(angle), 10 * angle, 1e-6);
    }
    EXPECT_EQ(path.branches[b].points.back().factor, 15);
  }
}

/// Forces that follow each other have no potential: K = [[10, 5], [-5, 10]], whose eigenvalues are complex.
TEST(EquilibriumPath, WarnsOfLoadsWithoutAPotential) {
  const EquilibriumPath path = path_of(R"(
gravity: [0, 0, 0]
bodies:
  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
frames: {c: {body: b, at: [0, 0, 0]}}
joints:
  x: {type: prismatic, between: [ground, a], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 10}}
  y: {type: prismatic, between: [a, b], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 10}}
signals: {px: {position: b, component: x}, py: {position: b, component: y}, fx: "-5*py", fy: "5*px"}
loads:
  skew_x: {on: c, force: [1, 0, 0], scale: fx}
  skew_y: {on: c, force: [0, 1, 0], scale: fy}
  push: {on: c, force: [1, 0, 0]}
outputs: [{name: x, joint: x}, {name: y, joint: y}]
)",
                                       5, [](auto& options) { options.loads = {"push"}; });
  ASSERT_EQ(path.warnings.size(), 1u);
  EXPECT_THAT(path.warnings[0], HasSubstr("not symmetric"));
  const PathPoint& last = path.branches[0].points.back();
  EXPECT_EQ(last.factor, 5);
  EXPECT_EQ(last.unstable, 0);
  EXPECT_NEAR(value(path, last, "x"), 0.4, 1e-9);
  EXPECT_NEAR(value(path, last, "y"), 0.2, 1e-9);
}

TEST(EquilibriumPath, RefusesByName) {
  const auto said = [](const std::string& text,
                       const std::function<void(EquilibriumPathOptions&)>& more) -> std::string {
    try {
      path_of(text, 1, more);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(said(column(0), [](auto& options) { options.loads = {"pres"}; }),
              HasSubstr("did you mean 'press'"));
  EXPECT_THAT(said(column(0), [](auto& options) { options.loads = {"gravity"}; }), HasSubstr("no gravity"));
  EXPECT_THAT(said(column(0), [](auto& options) { options.from = 1; }), HasSubstr("no range"));
  EXPECT_THAT(said(column(0),
                   [](auto& options) {
                     options.loads = {"press", "press"};
                   }),
              HasSubstr("'press' is named twice"));
  EXPECT_THAT(said(column(0) + "frictions: {rub: {joint: foot, torque: 5}}\n", {}), HasSubstr("remembers"));
  const char* const loose = R"(
bodies: {ball: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
frames: {centre: {body: ball, at: [0, 0, 0]}}
joints: {slide: {type: prismatic, between: [ground, ball], at: [0, 0, 0], axis: [1, 0, 0]}}
loads: {push: {on: centre, force: [0, 0, 1]}}
)";
  EXPECT_THAT(said(loose, {}), HasSubstr("nothing holds the mechanism along 'slide' 100 %"));
}

}  // namespace
}  // namespace mimbre::test::equilibrium_path_test
