#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <complex>
#include <numbers>

#include "compile/flexible_data.h"
#include "dynamics/geometric.h"
#include "dynamics/natural/system.h"
#include "fe/meshes.h"
#include "integrate/initial.h"
#include "math/once/decompositions.h"
#include "mimbre/modes.h"
#include "mimbre/simulation.h"
#include "support/dense.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// Bodies that stress stiffens, in motion: frequencies from time series against theory, both formulations.
namespace mimbre::test::geometric_stiffness_test {
namespace {

/// Angular frequencies in a series of samples at equal intervals, ascending, by the matrix pencil (Hua,
/// Sarkar 1990): the series is a sum of `count` undamped oscillations and a constant.
std::vector<double> frequencies(const std::vector<double>& series, double interval, int count) {
  const Eigen::Index n = static_cast<Eigen::Index>(series.size()), width = n / 3;
  MatrixXd hankel(n - width, width + 1);
  for (Eigen::Index r = 0; r < hankel.rows(); ++r)
    for (Eigen::Index c = 0; c <= width; ++c) hankel(r, c) = series[static_cast<std::size_t>(r + c)];
  const MatrixXd V = symmetric_eigen(hankel.transpose() * hankel).vectors.rightCols(2 * count + 1);
  const MatrixXd shift = least_squares(V.topRows(width), V.bottomRows(width));
  std::vector<double> found;
  for (const std::complex<double>& z : eigenvalues(shift))
    if (std::arg(z) > 1e-6) found.push_back(std::arg(z) / interval);
  std::sort(found.begin(), found.end());
  return found;
}

/// A cantilever with EI = ρA = L = 1 that hardly stretches (E A L²/EI = 2.5e5), clamped to a hub of no
/// radius. A short push bends it both ways.
std::string turning_beam(const std::string& stiffening, double speed) {
  return R"(
gravity: [0, 0, 0]
materials: {unit: {young: 2.5e5, poisson: 0.3, density: 1}}
sections: {unit: {area: 1, Iy: 4e-6, Iz: 4e-6, J: 8e-6}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: unit
      section: unit
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 20}}
      clamped: [root]
)" + stiffening +
         R"(
joints:
  hub:
    type: revolute
    between: [ground, beam]
    at: [0, 0, 0]
    axis: [0, 0, 1]
    drive: {position: ")" +
         std::to_string(speed) + R"(*t"}
loads:
  push: {on: beam.tip, force: [0, 1e-5, 1e-5], scale: "t < 0.2 ? sin(pi*t/0.2)^2 : 0", follower: true}
outputs:
  - {name: lag, displacement: beam.tip, relative_to: beam, component: y}
  - {name: flap, displacement: beam.tip, relative_to: beam, component: z}
)";
}

/// Lowest frequencies in and out of the plane of rotation.
struct Lowest {
  double lag = 0, flap = 0;
};

Lowest lowest_of(const std::string& text, double from = 0.2) {
  RunOptions options;
  options.step = 0.002;
  options.integrator = spec::Simulation::Integrator::newmark;
  Simulation simulation(model_of(text), options);
  std::vector<double> lag, flap;
  ResultsRow row;
  for (int k = 1; simulation.time() < from + 3; ++k) {
    const StepReport report = simulation.step();
    if (!report.ok()) {
      ADD_FAILURE() << simulation.explain(report);
      return {};
    }
    if (simulation.time() < from + 1e-9 || k % 10 != 0) continue;
    simulation.sample(row);
    lag.push_back(row.channels[0]);
    flap.push_back(row.channels[1]);
  }
  return {frequencies(lag, 10 * *options.step, 3).front(), frequencies(flap, 10 * *options.step, 3).front()};
}

struct Remedy {
  const char* name;
  const char* text;
  double tolerance;
};
void PrintTo(const Remedy& r, std::ostream* out) { *out << r.name; }

class TurningBeam : public testing::TestWithParam<Remedy> {};
INSTANTIATE_TEST_SUITE_P(
    Remedies, TurningBeam,
    testing::Values(Remedy{"geometric_stiffness",
                           "      dynamic_modes: 10\n      stiffening: geometric_stiffness\n", 1e-3},
                    Remedy{"foreshortening", "      dynamic_modes: 10\n      stiffening: foreshortening\n",
                           1e-3},
                    Remedy{"substructures",
                           "      substructures: {count: 10, dynamic_modes: 0}\n"
                           "      dynamic_modes: 2\n",
                           2e-2},
                    Remedy{"stiffened_substructures",
                           "      substructures: {count: 10, dynamic_modes: 0}\n"
                           "      dynamic_modes: 2\n      stiffening: geometric_stiffness\n",
                           2e-3}),
    [](const auto& remedy) { return remedy.param.name; });

/// Flapping frequencies over those at rest (Wright, Smith, Thresher, Wang 1982, no hub radius); lagging ones
/// are less by the square of the speed.
TEST_P(TurningBeam, HasTheFrequenciesOfTheory) {
  struct Turning {
    double speed, flap;
  };
  for (const auto& [speed, flap] :
       {Turning{0, 3.5160}, Turning{2, 4.1373}, Turning{6, 7.3604}, Turning{12, 13.1702}}) {
    const Lowest found = lowest_of(turning_beam(GetParam().text, speed));
    EXPECT_NEAR(found.flap, flap, GetParam().tolerance * flap) << speed;
    EXPECT_NEAR(std::hypot(found.lag, speed), flap, GetParam().tolerance * flap) << speed;
  }
}

/// The same cantilever on the ground, upright or hanging, with a dead load along it.
std::string column(double height, double gravity, double load) {
  const std::string z = std::to_string(height);
  return R"(
gravity: [0, 0, )" +
         std::to_string(-gravity) + R"(]
materials: {unit: {young: 2.5e5, poisson: 0.3, density: 1}}
sections: {unit: {area: 1, Iy: 4e-6, Iz: 4e-6, J: 8e-6}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: unit
      section: unit
      nodes: {root: [0, 0, 0], tip: [0, 0, )" +
         z + R"(]}
      bars: {beam: {from: root, to: tip, elements: 10}}
      clamped: [root]
      static_modes:
        - {node: tip, along: [0, 0, 1]}
      dynamic_modes: 8
      stiffening: geometric_stiffness
joints:
  base: {type: fixed, between: [ground, beam], at: [0, 0, 0]}
loads:
  push: {on: beam.tip, force: [1e-5, 1e-5, 0], scale: "t < 0.2 ? sin(pi*t/0.2)^2 : 0"}
  weight: {on: beam.tip, force: [0, 0, )" +
         std::to_string(-load) + R"(], scale: "t < 0.2 ? t/0.2 : 1"}
outputs:
  - {name: x, displacement: beam.tip, relative_to: beam, component: x}
  - {name: y, displacement: beam.tip, relative_to: beam, component: y}
)";
}

/// Lowest frequency of the cantilever under a dead load p along it: w'''' + p w'' = ω² w with w = w' = 0 at
/// the root, w'' = w''' + p w' = 0 at the tip.
double frequency_under(double p) {
  const auto determinant = [p](double square) {
    const double root = std::sqrt(p * p / 4 + square), a = std::sqrt(root + p / 2),
                 b = std::sqrt(root - p / 2);
    // w = A (cos ax − cosh bx) + B (sin ax − a/b sinh bx)
    const double bend_a = -a * a * std::cos(a) - b * b * std::cosh(b),
                 bend_b = -a * a * std::sin(a) - a * b * std::sinh(b),
                 shear_a = (a * a - p) * a * std::sin(a) - (b * b + p) * b * std::sinh(b),
                 shear_b = -(a * a - p) * a * std::cos(a) - (b * b + p) * a * std::cosh(b);
    return bend_a * shear_b - bend_b * shear_a;
  };
  double low = 1e-6, high = 0.1;
  while (determinant(low) * determinant(high) > 0) high += 0.1;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (determinant(low) * determinant(middle) > 0 ? low : high) = middle;
  }
  return std::sqrt(low);
}

TEST(GeometricStiffnessInMotion, AColumnSoftensUnderItsLoad) {
  const double critical = std::numbers::pi * std::numbers::pi / 4;
  for (const double part : {-0.5, 0.5, 0.8}) {
    const double expected = frequency_under(part * critical);
    EXPECT_NEAR(expected, 3.5160 * std::sqrt(1 - part), 0.05 * expected);
    const Lowest found = lowest_of(column(1, 0, part * critical));
    EXPECT_NEAR(found.flap, expected, 2e-3 * expected) << part;
    EXPECT_NEAR(found.lag, found.flap, 1e-4 * expected) << part;
  }
}

/// A strip on edge under a dead load P at its tip, EI = GJ = ρA = L = 1 sideways, ρ(Iy + Iz) = 4.004e-3.
std::string strip_on_edge(double load) {
  return R"(
gravity: [0, 0, 0]
materials: {unit: {young: 2.5e5, poisson: 0.3, density: 1}}
sections: {unit: {area: 1, Iy: 4e-3, Iz: 4e-6, J: 1.04e-5}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: unit
      section: unit
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 20, y: [0, 1, 0]}}
      clamped: [root]
      static_modes:
        - {node: tip, along: [0, 0, 1]}
      dynamic_modes: 20
      stiffening: geometric_stiffness
joints:
  base: {type: fixed, between: [ground, beam], at: [0, 0, 0]}
loads:
  push: {on: beam.tip, force: [0, 1e-5, 0], scale: "t < 0.2 ? sin(pi*t/0.2)^2 : 0"}
  weight: {on: beam.tip, force: [0, 0, )" +
         std::to_string(-load) + R"(], scale: "t < 0.2 ? t/0.2 : 1"}
outputs:
  - {name: sideways, displacement: beam.tip, relative_to: beam, component: y}
  - {name: down, displacement: beam.tip, relative_to: beam, component: z}
)";
}

/// Its lowest frequency sideways: with the moment M = P (1 − x) and B = v'' + M φ, B'' = ω² v and
/// φ'' = M v'' − ρI ω² φ, v = v' = φ = 0 at the root, B = B' = φ' = 0 at the tip, by shooting.
double sideways_frequency_under(double load) {
  using State6 = Eigen::Matrix<double, 6, 3>;  // v, v', B, B', φ, φ' by their three values at the root
  const auto determinant = [load](double omega) {
    const auto rate = [&](double x, const State6& y) {
      const double moment = load * (1 - x);
      State6 d;
      d.row(0) = y.row(1);
      d.row(1) = y.row(2) - moment * y.row(4);
      d.row(2) = y.row(3);
      d.row(3) = omega * omega * y.row(0);
      d.row(4) = y.row(5);
      d.row(5) = moment * d.row(1) - 4.004e-3 * omega * omega * y.row(4);
      return d;
    };
    State6 y = State6::Zero();
    y(2, 0) = y(3, 1) = y(5, 2) = 1;
    const double h = 0.01;
    for (int k = 0; k < 100; ++k) {  // Runge, Kutta
      const double x = k * h;
      const State6 a = rate(x, y), b = rate(x + h / 2, y + h / 2 * a), c = rate(x + h / 2, y + h / 2 * b),
                   d = rate(x + h, y + h * c);
      y += h / 6 * (a + 2 * b + 2 * c + d);
    }
    Eigen::Matrix3d tip;
    tip << y.row(2), y.row(3), y.row(5);
    return tip.determinant();
  };
  double low = 1e-3, high = 0.05;
  while (determinant(low) * determinant(high) > 0) high += 0.05;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (determinant(low) * determinant(middle) > 0 ? low : high) = middle;
  }
  return low;
}

TEST(GeometricStiffnessInMotion, AStripOnEdgeSoftensSidewaysUnderItsLoad) {
  const double critical = 4.0126;
  EXPECT_NEAR(sideways_frequency_under(0), 3.5160, 1e-3);
  EXPECT_LT(sideways_frequency_under(0.99999 * critical), 0.05);
  for (const double part : {0.4, 0.8}) {
    const double expected = sideways_frequency_under(part * critical);
    EXPECT_LT(expected, 3.5160 * (part < 0.5 ? 0.95 : 0.7));
    EXPECT_NEAR(lowest_of(strip_on_edge(part * critical)).lag, expected, 5e-3 * expected) << part;
  }
}

/// Gravity alone, q L³ = 7.837 EI being the load under which a standing beam buckles.
TEST(GeometricStiffnessInMotion, AHangingBeamStiffensAndAStandingOneSoftens) {
  for (const double height : {1., -1.}) {
    const double expected = 3.5160 * std::sqrt(1 - height * 4 / 7.8373);
    EXPECT_NEAR(lowest_of(column(height, 4, 0)).flap, expected, 0.01 * expected) << height;
  }
}

/// A tree of random bodies without constraints: its residual is affine in the accelerations.
VectorXd exact_accelerations(relative::RelativeSystem& system, const State& s) {
  const int n = system.velocities();
  const auto residual = [&](const VectorXd& a) {
    VectorXd r(n);
    system.residual(0, s.q.data(), s.v.data(), a.data(), nullptr, 0, r.data());
    return r;
  };
  const VectorXd rest = residual(VectorXd::Zero(n));
  MatrixXd mass(n, n);
  for (int k = 0; k < n; ++k) mass.col(k) = residual(VectorXd::Unit(n, k)) - rest;
  VectorXd a = -mimbre::solve(mass, rest);
  a -= mimbre::solve(mass, residual(a));
  return a;
}

TEST(GeometricStiffnessInMotion, FormulationsAgreeOnRandomMechanisms) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    RandomOptions options;
    options.bodies = 2 + static_cast<int>(seed % 4);
    options.flexible_share = 0.7;
    options.springs = options.damping = options.loads = true;
    options.stiffening = fe::Stiffening::geometric_stiffness;
    const RandomMechanism mechanism = random_mechanism(seed, options);
    const Compiled& m = mechanism.compiled();
    const double amplitude = 0.2;  // deflections of some 5 % of the length
    relative::RelativeSystem relative(m);
    natural::NaturalSystem natural(m);
    ASSERT_EQ(m.equations, 0);
    Random random(seed + 77);
    State s;
    s.time = 0;
    s.q = mechanism.q;
    for (const BodyData& b : m.bodies) s.q.segment(b.q + b.joint_positions, b.modes) *= amplitude;
    s.v = random.values(m.velocities, 1.0);
    for (const BodyData& b : m.bodies) s.v.segment(b.v + b.joint_velocities, b.modes) *= 0.1;
    s.a = exact_accelerations(relative, s);
    s.algorithmic = s.a;
    s.multipliers.resize(0);
    relative.kinematics(0, s.q.data(), s.v.data(), s.a.data());
    State n = natural.from_relative(s, relative.workspace().bodies, relative.workspace().origin);
    find_multipliers(natural, n);
    VectorXd r(natural.velocities()), size(natural.velocities());
    const VectorXd none = VectorXd::Zero(natural.equations());
    natural.residual(0, n.q.data(), n.v.data(), n.a.data(), none.data(), 0, size.data());
    natural.residual(0, n.q.data(), n.v.data(), n.a.data(), n.multipliers.data(), 0, r.data());
    EXPECT_LT(r.cwiseAbs().maxCoeff(), 1e-12 * (1 + size.cwiseAbs().maxCoeff() + s.a.cwiseAbs().maxCoeff()))
        << seed;
    // And the iteration with the leading matrices, which lack what accelerations do to the stress, gets
    // there.
    const VectorXd exact = s.a, exact_natural = n.a;
    EXPECT_TRUE(solve_accelerations(relative, s)) << seed;
    EXPECT_LT((s.a - exact).cwiseAbs().maxCoeff(), 1e-8 * std::max(1.0, exact.cwiseAbs().maxCoeff())) << seed;
    EXPECT_TRUE(solve_accelerations(natural, n)) << seed;
    EXPECT_LT((n.a - exact_natural).cwiseAbs().maxCoeff(),
              1e-8 * std::max(1.0, exact_natural.cwiseAbs().maxCoeff()))
        << seed;
  }
}

/// Forces at the boundary have an energy: they are its gradient, and the tangent is theirs.
TEST(GeometricStiffnessInMotion, ForcesAtTheBoundaryHaveAnEnergy) {
  fe::Mesh mesh = bent_frame();
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  for (int k = 0; k < 3; ++k)
    options.boundary.push_back({2, false, Vec3d::Unit(k), std::string(1, "xyz"[k])});
  options.dynamic_modes = 4;
  options.stiffening = fe::Stiffening::geometric_stiffness;
  const FlexibleData f = flexible_data(fe::reduce(mesh, options, {}));
  const GeometricData& g = f.geometric;
  ASSERT_GT(g.boundary_loads.rows(), 1);
  const int n = f.modes, s = f.stride;
  AlignedVector<double> scratch((1 + g.loads.size()) * static_cast<std::size_t>(s));
  const auto forces = [&](const VectorXd& y) {
    VectorXd out = VectorXd::Zero(s);
    geometric::add_boundary_forces(g, y.data(), scratch.data(), out.data());
    return out;
  };
  Random random(5);
  VectorXd y = VectorXd::Zero(s);
  y.head(n) =
      random.values(n, 0.02).cwiseQuotient(f.stiffness.matrix().diagonal().head(n).cwiseSqrt() / 1000);
  const VectorXd force = forces(y);
  AlignedVector<double> tangent(static_cast<std::size_t>(n) * s);
  geometric::stiffness<double>(g, {Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero()}, y.data(), tangent.data(),
                               scratch.data());
  for (int k = 0; k < n; ++k) {
    const double step = 1e-4 * y.norm();
    VectorXd up = y, down = y;
    up[k] += step;
    down[k] -= step;
    const double slope = (geometric::boundary_energy(g, up.data(), scratch.data()) -
                          geometric::boundary_energy(g, down.data(), scratch.data())) /
                         (2 * step);
    EXPECT_NEAR(slope, force[k], 1e-6 * force.norm()) << k;
    const VectorXd column = (forces(up) - forces(down)) / (2 * step);
    for (int r = 0; r < n; ++r) {
      EXPECT_NEAR(tangent[static_cast<std::size_t>(r * s + k)], column[r], 1e-5 * column.norm()) << r << k;
      EXPECT_NEAR(tangent[static_cast<std::size_t>(r * s + k)], tangent[static_cast<std::size_t>(k * s + r)],
                  1e-9 * column.norm())
          << "symmetric";
    }
  }
}

/// A rod in a fast slider-crank, which its static mode along it stiffens: vibrations along the rod must not
/// feed its bending, however little the step damps them; and the shortening of the bent rod moves the slider.
TEST(GeometricStiffnessInMotion, AFastSliderCrankStaysBoundedAsTheStepShrinks) {
  const auto run = [](const char* method, double step, auto formulation) {
    RunOptions options;
    options.step = step;
    options.formulation = formulation;
    Simulation simulation(
        Model::compile(
            load_model(MIMBRE_SOURCE_DIR "/tests/data/hard/fast-slider-crank.yaml", {{"method", method}})),
        options);
    double bent = 0;
    ResultsRow row;
    while (simulation.time() < 0.08 - 1e-9) {
      const StepReport report = simulation.step();
      if (!report.ok()) {
        ADD_FAILURE() << method << ' ' << step << ": " << simulation.explain(report);
        break;
      }
      simulation.sample(row);
      bent = std::max(bent, std::abs(row.channels[0]));
    }
    EXPECT_LT(std::abs(simulation.energy().numerical), 0.5) << method << ' ' << step;
    return bent;
  };
  using Formulation = spec::Simulation::Formulation;
  const double reference = run("foreshortening", 5e-5, Formulation::relative);
  for (const double step : {1e-4, 2.5e-5, 1.25e-5})
    EXPECT_NEAR(run("geometric_stiffness", step, Formulation::relative), reference, 0.02 * reference) << step;
  EXPECT_NEAR(run("geometric_stiffness", 2.5e-5, Formulation::natural), reference, 0.02 * reference);
}

/// A cantilever of 1 m that its weight bends, held at `place` and clamped at its origin.
std::shared_ptr<const Model> sagging(const std::string& stiffening, double gravity, double place) {
  return model_of(fmt::format(R"(
gravity: [0, 0, -{}]
materials: {{m: {{young: 7e10, poisson: 0.3, density: 2700}}}}
sections: {{s: {{area: 3e-4, Iy: 1e-9, Iz: 1.5e-9, J: 2e-9}}}}
bodies:
  b:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: m
      section: s
      nodes: {{a: [0, 0, 0], t: [1, 0, 0]}}
      bars: {{q: {{from: a, to: t, elements: 10}}}}
      clamped: [a]
      stiffening: {}
      static_modes: [{{node: t, all: true}}]
      dynamic_modes: 4
joints:
  j: {{type: fixed, between: [ground, b], at: [{}, 0, 0]}}
)",
                              gravity, stiffening, place));
}

double first_frequency(const std::string& stiffening, double gravity, double place) {
  return find_modes(sagging(stiffening, gravity, place)).modes.front().frequency;
}

/// Loads of inertia make the mass unsymmetric, which a body that is far bent may have and still vibrate.
TEST(GeometricStiffnessInMotion, AFarBentCantileverHasItsModes) {
  const double bent = first_frequency("geometric_stiffness", 60, 0),
               foreshortened = first_frequency("foreshortening", 60, 0);
  EXPECT_NEAR(bent / foreshortened, 1, 0.03);
}

/// Held by its other end, the bent body loses the mass of its twist: by the right name.
TEST(GeometricStiffnessInMotion, SaysWhereABodyIsHeldElsewhereThanClamped) {
  using testing::HasSubstr;
  const auto warned = [](const std::shared_ptr<const Model>& model) {
    std::string all;
    for (const std::string& w : Simulation(model).warnings()) all += w;
    return all;
  };
  EXPECT_THAT(warned(sagging("geometric_stiffness", 9.81, 1)),
              AllOf(HasSubstr("body 'b'"), HasSubstr("held at another place"), HasSubstr("foreshortening")));
  EXPECT_EQ(warned(sagging("geometric_stiffness", 9.81, 0)), "");
  EXPECT_EQ(warned(sagging("foreshortening", 9.81, 1)), "");
  EXPECT_NEAR(first_frequency("foreshortening", 30, 1), 5.21, 0.05);
  try {
    first_frequency("geometric_stiffness", 30, 1);
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("take away the mass of mode"), HasSubstr("body 'b'"),
                                    HasSubstr("foreshortening")));
  }
}

/// A soft beam that sags from a hub which spins up: what stress does is accounted for to the second order
/// of the step, in both formulations.
TEST(GeometricStiffnessInMotion, EnergyBalanceCloses) {
  const std::string text = R"(
gravity: [0, 0, -25]
materials: {soft: {young: 2e8, poisson: 0.3, density: 1000}}
sections: {bar: {area: 4e-4, Iy: 2e-8, Iz: 2e-8, J: 4e-8}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: soft
      section: bar
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {beam: {from: root, to: tip, elements: 6}}
      clamped: [root]
      dynamic_modes: 4
      stiffening: geometric_stiffness
joints:
  hub:
    type: revolute
    between: [ground, beam]
    at: [0, 0, 0]
    axis: [0, 0, 1]
    drive: {position: "8*t^2"}
simulation: {step: 0.01, end: 1}
)";
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    double before = 0;
    for (const double step : {0.004, 0.002, 0.001}) {
      RunOptions options;
      options.step = step;
      options.formulation = formulation;
      options.integrator = spec::Simulation::Integrator::newmark;
      Simulation simulation(model_of(text), options);
      double drift = 0, by_stress = 0, kinetic = 0;
      while (simulation.time() < 0.8) {
        const StepReport report = simulation.step();
        ASSERT_TRUE(report.ok()) << simulation.explain(report);
        drift = std::max(drift, std::abs(simulation.energy().numerical));
        by_stress = std::max(by_stress, std::abs(simulation.energy().load_work));
        kinetic = std::max(kinetic, simulation.energy().kinetic);
      }
      EXPECT_GT(by_stress, 0.01 * kinetic);  // there is something to account for
      EXPECT_LT(drift, 3e-3 * kinetic);
      if (before > 0) {
        EXPECT_GT(before / drift, 3) << step;
      }
      before = drift;
    }
  }
}

}  // namespace
}  // namespace mimbre::test::geometric_stiffness_test
