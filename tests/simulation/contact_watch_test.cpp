#include "simulation/step/contact_watch.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "compile/triangle_mesh.h"
#include "forces/surfaces/mesh.h"
#include "mimbre/model_file.h"
#include "simulation/step/contact_sweep.h"
#include "support/models.h"
#include "support/simulate.h"

/// What steps do not show of contacts: passages found on the way, and spheres that are too deep.
namespace mimbre::test::contact_watch_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::shared_ptr<const Model> sample(const std::string& name) {
  return Model::compile(load_model(std::string(MIMBRE_SOURCE_DIR "/tests/data/monitors/") + name));
}

std::string list(const Vec3d& v) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v[0], v[1], v[2]); }

class ContactPassage : public testing::TestWithParam<Formulation> {};

/// 300 radii a step, straight onto each kind of surface: 0.8 of 600 m/s is left, in the opposite direction.
TEST_P(ContactPassage, WhatAStepJumpsOverIsStruck) {
  for (const char* kind : {"box", "ball", "mesh", "sphere", "capsule", "cylinder"}) {
    const auto model = sample(fmt::format("tunnel-{}.yaml", kind));
    Simulation simulation = simulation_of(model, GetParam());
    run_to(simulation, model->compiled().spec().simulation.end);
    // A ball of 100 kg is struck by one of 1 kg: it takes 1.8/101 of the speed.
    const double left = std::string(kind) == "ball" ? (100 * 0.8 - 1) / 101 : 0.8;
    EXPECT_NEAR(channel(simulation, "v"), 600 * left, 2) << kind;
    EXPECT_THAT(simulation.warnings(), IsEmpty()) << kind;
  }
}
INSTANTIATE_TEST_SUITE_P(Formulations, ContactPassage,
                         testing::Values(Formulation::relative, Formulation::natural), [](const auto& p) {
                           return p.param == Formulation::relative ? "relative" : "natural";
                         });

/// A ball at 1 to 10,000 radii a step onto a solid of its size or a tenth, at rest or in flight and turning
/// by up to a radian a step, aimed at the ball inside the solid: it is thrown off, or there is a word.
std::string shot(std::mt19937& random) {
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<>(a, b)(random); };
  const auto power = [&](double a, double b) { return std::pow(10, uniform(a, b)); };
  const auto direction = [&] {
    std::normal_distribution<> normal;
    return Vec3d(Vec3d(normal(random), normal(random), normal(random)).normalized());
  };
  const double r = power(-3, 0), h = power(-3, -1.5), speed = power(0, 4) * r / h, size = power(-1, 1) * r,
               thin = size * power(-1, 0);
  double core = 0, reach = 2 * size;
  std::string surface, contact;
  const int kind = std::uniform_int_distribution<>(0, 5)(random);
  if (kind == 0) {
    surface = fmt::format("type: box, size: [{}, {}, {}]", size, thin, size);
    core = 0.5 * thin;
  } else if (kind == 1) {
    surface = fmt::format("type: cylinder, radius: {}, length: {}", 0.5 * size, thin);
    core = 0.5 * thin;
  } else if (kind == 2) {
    surface = fmt::format("type: capsule, radius: {}, length: {}", 0.5 * thin, size);
    core = 0.5 * thin;
  } else if (kind == 3) {
    surface = fmt::format("type: sphere, radius: {}", 0.5 * size);
    core = 0.5 * size;
  } else if (kind == 4) {
    surface = fmt::format(
        "type: mesh, vertices: [[{0}, {0}, {0}], [{0}, -{0}, -{0}], [-{0}, {0}, -{0}], [-{0}, -{0}, {0}]], "
        "triangles: [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]",
        size);
    core = size / std::sqrt(3);
  } else {
    core = 0.5 * size;
  }
  const bool moves = kind == 5 || uniform(0, 1) < 0.5;
  const Vec3d velocity = speed * direction(),
              target = moves ? Vec3d(uniform(0, 0.6) * speed * direction()) : Vec3d(Vec3d::Zero()),
              spin = moves ? Vec3d(power(-2, 0) / h * direction()) : Vec3d(Vec3d::Zero());
  const Vec3d along = (velocity - target).normalized(), beside = along.unitOrthogonal();
  const double time = std::max(uniform(0.3, 5.7) * h, 1.2 * (reach + r) / (velocity - target).norm());
  const Vec3d from = uniform(0, 0.9) * (core + r) * beside - time * (velocity - target);
  contact = fmt::format("spheres: [{{on: ball, radius: {}}}{}], stiffness: {}, restitution: 0.8", r,
                        kind == 5 ? fmt::format(", {{on: solid, radius: {}}}", 0.5 * size) : "",
                        (velocity - target).squaredNorm() / std::pow(0.2 * std::min(r, size), 2));
  return fmt::format(
      R"y(
gravity: [0, 0, 0]
bodies:
  ball: {{mass: 1, com: {0}, inertia: [{1}, {1}, {1}]}}
  solid: {{mass: 100, com: [0, 0, 0], inertia: [{2}, {2}, {2}]}}
joints:
  flies: {{type: floating, between: [ground, ball], at: {0}, velocity: {3}}}
  {4}
{5}
contacts: {{touch: {{{6}, {7}}}}}
outputs: [{{name: vx, velocity: ball, component: x}}, {{name: vy, velocity: ball, component: y}}, {{name: vz, velocity: ball, component: z}}]
simulation: {{step: {8}, end: {9}}}
)y",
      list(from), 0.4 * r * r, 100 * size * size,
      fmt::format("[{}, {}, {}, 0, 0, 0]", velocity[0], velocity[1], velocity[2]),
      moves ? fmt::format("drifts: {{type: floating, between: [ground, solid], at: [0, 0, 0], "
                          "velocity: [{}, {}, {}, {}, {}, {}]}}",
                          target[0], target[1], target[2], spin[0], spin[1], spin[2])
            : "rests: {type: fixed, between: [ground, solid]}",
      kind == 5 ? "" : fmt::format("surfaces: {{face: {{on: solid, at: [0, 0, 0], {}}}}}", surface), contact,
      kind == 5 ? "among: true" : "surfaces: face", h, (std::ceil(time / h) + 2) * h);
}

TEST(ContactPassages, NoneIsSilent) {
  std::mt19937 random(26);
  int thrown_off = 0;
  constexpr int shots = 240;
  for (int k = 0; k < shots; ++k) {
    const std::string text = shot(random);
    const auto model = model_of(text);
    Simulation simulation = simulation_of(model, k % 4 == 0 ? Formulation::natural : Formulation::relative);
    const auto velocity = [&] {
      return Vec3d(channel(simulation, "vx"), channel(simulation, "vy"), channel(simulation, "vz"));
    };
    const Vec3d before = velocity();
    run_to(simulation, model->compiled().spec().simulation.end);
    const bool hit = (velocity() - before).norm() > 1e-3 * before.norm();
    EXPECT_TRUE(hit || !simulation.warnings().empty()) << text;
    thrown_off += hit;
  }
  EXPECT_GT(thrown_off, 0.98 * shots);
}

/// At 1 to 10,000 radii a step onto ground that has no other side: 0.8 of the speed is left.
TEST_P(ContactPassage, OntoGroundAtAnySpeedIsThrownBack) {
  constexpr double radius = 0.01, step = 0.01;
  for (const char* ground :
       {"type: half_space", "type: heights, at: [-1, -1, 0], spacing: [2, 2], heights: [[0, 0], [0, 0]]"})
    for (const double radii : {1.0, 10.0, 100.0, 1000.0, 10000.0}) {
      const double speed = radii * radius / step;
      const auto model = model_of(fmt::format(
          R"y(
gravity: [0, 0, 0]
bodies: {{ball: {{mass: 1, com: [0, 0, {}], inertia: [1, 1, 1]}}}}
joints: {{free: {{type: floating, between: [ground, ball], velocity: [0, 0, -{}, 0, 0, 0]}}}}
surfaces: {{floor: {{{}}}}}
contacts: {{touch: {{spheres: {{on: ball, radius: {}}}, surfaces: floor, stiffness: {}, restitution: 0.8}}}}
outputs: [{{name: v, velocity: ball, component: z}}]
simulation: {{step: {}, end: {}}}
)y",
          radius + 1.3 * speed * step, speed, ground, radius, std::pow(speed / (0.2 * radius), 2), step,
          5 * step));
      Simulation simulation = simulation_of(model, GetParam());
      run_to(simulation, 5 * step);
      EXPECT_NEAR(channel(simulation, "v") / speed, 0.8, 0.01) << ground << ' ' << radii;
      EXPECT_THAT(simulation.warnings(), IsEmpty()) << ground << ' ' << radii;
    }
}

std::string passing_by(double beside, int substeps) {
  return fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{ball: {{mass: 1, com: [{}, 0, 3.3], inertia: [1, 1, 1]}}}}
joints: {{free: {{type: floating, between: [ground, ball], velocity: [0, 0, -100, 0, 0, 0]}}}}
surfaces: {{post: {{type: sphere, radius: 0.01}}}}
contacts: {{touch: {{spheres: {{on: ball, radius: 0.01}}, surfaces: post, stiffness: 1e8}}}}
simulation: {{step: 0.01, end: 0.1, substeps: {}}}
)y",
                     beside, substeps);
}

/// Where steps are not repeated it is said; what flies past by a tenth of the radius is left alone.
TEST(ContactPassages, AreSaidWhereStepsAreNotRepeated) {
  Simulation through = simulation_of(passing_by(0.005, 1), Formulation::relative);
  run_to(through, 0.1);
  EXPECT_THAT(
      through.warnings(),
      ElementsAre(AllOf(HasSubstr("contact 'touch': the sphere of body 'ball' went through surface 'post' "
                                  "within a step (first at t = 0.04 s)"),
                        HasSubstr("or `substeps: 4`"))));
  for (const int substeps : {1, 4}) {
    Simulation past = simulation_of(passing_by(0.021, substeps), Formulation::relative);
    int parts = 0;
    while (past.time() < 0.0999) parts = std::max(parts, past.step().substeps);
    EXPECT_EQ(parts, 1);
    EXPECT_THAT(past.warnings(), IsEmpty());
  }
}

/// What is saved and resumed warns as well.
TEST(ContactPassages, AreRememberedInStates) {
  const auto model = model_of(passing_by(0.005, 1));
  Simulation first = simulation_of(model, Formulation::relative);
  run_to(first, 0.05);
  Simulation second = simulation_of(model, Formulation::relative);
  second.restore(first.save());
  EXPECT_EQ(second.warnings(), first.warnings());
  EXPECT_EQ(second.warnings().size(), 1u);
}

/// 35 mm deep by its weight in a box of 50 mm: it sinks in, and that is said when its centre enters.
TEST(Depth, OfASphereBelowItsCentreIsSaid) {
  Simulation simulation = simulation_of(sample("deep.yaml"), Formulation::relative);
  run_to(simulation, 5);
  EXPECT_THAT(
      simulation.warnings(),
      ElementsAre(AllOf(HasSubstr("contact 'c': the sphere of body 'b' is deeper in surface 's' than its "
                                  "radius, 0.02 m, from t = 1.092 s on"),
                        HasSubstr("larger stiffness"))));
}

/// A weight presses a ball in by 0.9 of the radius of the smaller, or by 1.1.
TEST(Depth, IsThatOfTheSmallerOfTwoSpheres) {
  for (const double share : {0.9, 1.1}) {
    Simulation simulation = simulation_of(fmt::format(R"y(
bodies:
  small: {{mass: 1, com: [0, 0, 0.11], inertia: [1, 1, 1]}}
  large: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints:
  guide: {{type: prismatic, between: [ground, small], at: [0, 0, 0.11], axis: [0, 0, 1]}}
  rest: {{type: fixed, between: [ground, large]}}
contacts: {{touch: {{spheres: [{{on: small, radius: 0.01}}, {{on: large, radius: 0.1}}], among: true, stiffness: {}, restitution: 0.05}}}}
initial: equilibrium
simulation: {{step: 0.001, end: 1}}
)y",
                                                      9.81 / (share * 0.01)),
                                          Formulation::relative);
    run_to(simulation, 0.01);
    EXPECT_EQ(simulation.warnings().size(), share > 1 ? 1u : 0u) << share;
  }
}

/// A wheel that begins with its hub 0.1 m below the road, of a tyre that rolls, and of one that is a spring.
TEST(Depth, OfAHubBelowTheRoadIsSaid) {
  for (const char* more :
       {"",
        ", model: brush, damping: 500, longitudinal_stiffness: 6e4, cornering_stiffness: 5e4, friction: 0.9, "
        "longitudinal_relaxation: 0.3, lateral_relaxation: 0.5, half_length: 0.07, load: 4000"}) {
    const auto wheel = [&](double height) {
      Simulation simulation = simulation_of(fmt::format(R"y(
bodies: {{wheel: {{mass: 20, com: [0, 0, {0}], inertia: [1, 1, 1]}}}}
joints: {{free: {{type: floating, between: [ground, wheel]}}}}
roads: {{flat: {{over: distance, points: [[-100, 0], [100, 0]]}}}}
tyres: {{tyre: {{on: wheel, at: [0, 0, {0}], road: flat, stiffness: 2e5, radius: 0.3{1}}}}}
simulation: {{step: 0.001, end: 1}}
)y",
                                                        height, more),
                                            Formulation::relative);
      run_to(simulation, 0.002);
      return simulation.warnings();
    };
    EXPECT_THAT(wheel(-0.1),
                testing::Contains(AllOf(HasSubstr("tyre 'tyre': its hub is below the road from t = 0 s"),
                                        HasSubstr("at the deepest 0.1 m"), HasSubstr("its radius, 0.3 m"))));
    EXPECT_THAT(wheel(0.28), testing::Not(testing::Contains(HasSubstr("hub"))));
  }
}

/// Against many points of the chord, of random triangles.
TEST(NearestOnChord, IsThatOfItsPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<> one(-1, 1);
  const auto point = [&] { return Vec3d(one(random), one(random), one(random)); };
  for (int round = 0; round < 200; ++round) {
    std::vector<Vec3d> vertices;
    std::vector<std::array<int, 3>> triangles;
    for (int k = 0; k < 30; ++k) {
      const Vec3d corner = 3 * point();
      for (int c = 0; c < 3; ++c) vertices.push_back(corner + 0.5 * point());
      triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    }
    const TriangleMesh mesh = triangle_mesh(vertices, triangles);
    const Vec3d from = 3 * point(), to = 3 * point();
    double least = 1e9;
    for (int k = 0; k <= 2000; ++k)
      least = std::min(
          least, std::abs(surfaces::nearest_point(mesh, Vec3d(from + k / 2000.0 * (to - from))).distance));
    const NearestOnChord nearest = nearest_on_chord(mesh, from, to, 100);
    EXPECT_LE(nearest.distance, least + 1e-12);
    EXPECT_GE(nearest.distance, least - 0.5 * (to - from).norm() / 2000);
    EXPECT_NEAR(std::abs(surfaces::nearest_point(mesh, Vec3d(from + nearest.at * (to - from))).distance),
                nearest.distance, 1e-9);
    EXPECT_EQ(nearest_on_chord(mesh, from, to, 0.5 * nearest.distance).distance, 0.5 * nearest.distance);
  }
}

}  // namespace
}  // namespace mimbre::test::contact_watch_test
