#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <numbers>
#include <sstream>
#include <tuple>

#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"
#include "support/run.h"

/// Beams of any deflection: corotational and by absolute nodal coordinates (in a plane, as cables, as thick
/// beams).
namespace mimbre::test::nonlinear_beam_test {
namespace {

using std::numbers::pi;

double value(const StaticResult& r, const std::string& channel) {
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    if (r.channels[k].name == channel) return r.values[static_cast<Eigen::Index>(k)];
  ADD_FAILURE() << "no channel " << channel;
  return std::nan("");
}

constexpr double EI = 100;  // of the beam below, N m²

/// A beam of length 1 along x, bent in the plane x–y, EA = 1.2e7 N: bending shortens it far more than
/// tension.
std::string beam(const std::string& kind, int elements, const std::string& rest,
                 const std::string& gravity = "[0, 0, 0]") {
  const bool in_space = kind == "ancf_cable" || kind == "ancf_thick";  // the latter with hardly any shear
  return "gravity: " + gravity + R"(
materials: {m: {young: 1e10, poisson: 0.3, density: 1000}}
sections: {s: {area: 1.2e-3, Iy: 1e-8, Iz: 1e-8, J: 2e-8, shear_areas: [0.01, 0.01]}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: m
      section: s
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: )" +
         std::to_string(elements) + R"(}}
      clamped: [root]
)" +
         (in_space ? kind == "ancf_thick" ? "      beam_theory: timoshenko\n" : ""
                   : "      planar: [0, 0, 1]\n") +
         "      beam: " + kind + "\n" + rest + R"(
outputs:
  - {name: ux, displacement: beam.tip, relative_to: beam, component: x}
  - {name: uy, displacement: beam.tip, relative_to: beam, component: y}
)";
}

const std::string wall = "joints: {wall: {type: bracket, between: [ground, beam], at: [0, 0, 0]}}\n";

std::string load(const std::string& what) { return "loads: {end: {on: beam.tip, " + what + "}}\n"; }

class NonlinearBeam : public testing::TestWithParam<std::tuple<std::string, spec::Simulation::Formulation>> {
 protected:
  const std::string kind = std::get<0>(GetParam());
  RunOptions options() const {
    RunOptions o;
    o.formulation = std::get<1>(GetParam());
    return o;
  }
};

/// The kinds whose equilibria are found with any number of elements.
class SlenderBeam : public NonlinearBeam {};

/// M = 2π EI / L closes the circle.
TEST_P(SlenderBeam, AnEndMomentRollsItUp) {
  const bool natural = std::get<1>(GetParam()) == spec::Simulation::Formulation::natural;
  for (const double turn : {0.25, 0.5, 1.0}) {
    if (natural && turn == 1) continue;  // the statics' search goes astray on the way
    const double angle = 2 * pi * turn;
    double previous = 0;
    for (const int elements : {10, 20}) {
      const StaticResult r = static_equilibrium(
          model_of(beam(kind, elements, wall + load("moment: [0, 0, " + std::to_string(angle * EI) + "]"))),
          options());
      const double error = std::hypot(1 + value(r, "ux") - std::sin(angle) / angle,
                                      value(r, "uy") - (1 - std::cos(angle)) / angle);
      std::cout << "  " << kind << ", " << turn << " turns, " << elements << " elements: " << error << '\n';
      EXPECT_LT(error, elements == 10 ? 1.3e-3 : 1.1e-4);
      if (elements == 20 && turn < 1) {
        EXPECT_GT(previous / error, 7.5) << "at least of the third order";
      }
      previous = error;
    }
  }
}

/// Deflection of the elastica under a transverse end load (K. E. Bisshopp, D. C. Drucker, Quarterly of
/// Applied Mathematics 3 (1945) 272–275), by quadrature: with the end's slope φ0, √(P L²/EI) = F(k) − F(k,
/// θ1), k² = (1 + sin φ0)/2, sin θ1 = 1/(k√2).
struct Elastica {
  double x = 0, y = 0;  ///< of the end, over the length
  explicit Elastica(double load_number) {
    const double goal = std::sqrt(load_number);
    const auto length = [](double k) {
      return std::comp_ellint_1(k) - std::ellint_1(k, std::asin(1 / (k * std::numbers::sqrt2)));
    };
    double low = 1 / std::numbers::sqrt2 + 1e-12, high = 1 - 1e-12;
    for (int i = 0; i < 200; ++i) (length(0.5 * (low + high)) < goal ? low : high) = 0.5 * (low + high);
    const double k = 0.5 * (low + high), theta = std::asin(1 / (k * std::numbers::sqrt2));
    x = std::sqrt(2 * (2 * k * k - 1)) / goal;
    y = 1 - 2 * (std::comp_ellint_2(k) - std::ellint_2(k, theta)) / goal;
  }
};

TEST_P(SlenderBeam, AnEndLoadBendsItLikeTheElastica) {
  EXPECT_NEAR(Elastica(10).y, 0.81061, 5e-6);  // K. Mattiasson, Int. J. Numer. Meth. Eng. 17 (1981) 145–153
  EXPECT_NEAR(1 - Elastica(10).x, 0.55500, 5e-6);
  for (const double number : {1.0, 5.0, 10.0}) {
    const Elastica exact(number);
    const StaticResult r = static_equilibrium(
        model_of(beam(kind, 20, wall + load("force: [0, " + std::to_string(number * EI) + ", 0]"))),
        options());
    EXPECT_NEAR(1 + value(r, "ux"), exact.x, 2e-4) << number;  // N stretches it by up to 1e-4
    EXPECT_NEAR(value(r, "uy"), exact.y, 2e-4) << number;
  }
}

/// Thick elements are of the fourth order. The statics' search finds half a circle with few of them only.
TEST(ThickBeams, AreOfTheFourthOrder) {
  const auto at = [](int elements, const std::string& what) {
    const StaticResult r = static_equilibrium(model_of(beam("ancf_thick", elements, wall + load(what))));
    return Eigen::Vector2d(1 + value(r, "ux"), value(r, "uy"));
  };
  for (const double turn : {0.25, 0.5}) {
    const double angle = 2 * pi * turn;
    const Eigen::Vector2d exact(std::sin(angle) / angle, (1 - std::cos(angle)) / angle);
    const std::string moment = "moment: [0, 0, " + std::to_string(angle * EI) + "]";
    const double coarse = (at(2, moment) - exact).norm(), fine = (at(4, moment) - exact).norm();
    EXPECT_LT(fine, turn < 0.5 ? 2e-4 : 4.5e-3);
    EXPECT_GT(coarse / fine, 11) << turn;
  }
  for (const double number : {1.0, 5.0}) {
    const std::string force = "force: [0, " + std::to_string(number * EI) + ", 0]";
    const Elastica exact(number);
    EXPECT_LT((at(5, force) - Eigen::Vector2d(exact.x, exact.y)).norm(), 1e-3) << number;
  }
}

/// The lowest frequency of small vibrations from the zero crossings, against 3.5160 √(EI/ρAL⁴).
TEST_P(NonlinearBeam, SmallVibrationsHaveTheCantileversFrequency) {
  const auto model =
      model_of(beam(kind, kind == "ancf_thick" ? 3 : 10,
                    wall + "initial: equilibrium\n" + load("force: [0, 0.1, 0], scale: \"t > 0 ? 0 : 1\"") +
                        "simulation: {step: 5e-4, end: 1.2}\n"));
  Simulation s(model, options());
  ResultsRow row;
  double last = 0, first_crossing = -1, last_crossing = -1;
  int crossings = 0;
  for (int k = 0; k < 2400; ++k) {
    ASSERT_TRUE(s.step().ok());
    s.sample(row);
    const double y = row.channels[1];
    if (k > 0 && last < 0 && y >= 0) {
      last_crossing = s.time() - 5e-4 * y / (y - last);
      if (crossings++ == 0) first_crossing = last_crossing;
    }
    last = y;
  }
  ASSERT_GT(crossings, 3);
  const double omega = 2 * pi * (crossings - 1) / (last_crossing - first_crossing);
  EXPECT_NEAR(omega / (3.51602 * std::sqrt(EI / 1.2)), 1, 2e-3);
}

/// Kicked sideways it flies, turns and vibrates without gravity.
std::string free_beam(const std::string& kind, const std::string& step, int elements = 8) {
  return beam(kind, elements,
              R"(
joints: {free: {type: planar, between: [ground, beam], at: [0, 0, 0], axis: [0, 0, 1], velocity: [0.3, -0.2, 4]}}
loads:
  kick: {on: beam.tip, force: [0, 150, 0], scale: "t < 0.012 ? sin(pi*t/0.012)^2 : 0"}
simulation: {end: 1, step: )" +
                  step + "}\n");
}

TEST_P(NonlinearBeam, AFreeBeamKeepsItsEnergy) {
  std::array<double, 2> drift{};
  for (const bool fine : {false, true}) {
    Simulation s(model_of(free_beam(kind, fine ? "0.00025" : "0.0005", kind == "ancf_thick" ? 4 : 8)),
                 options());
    double most = 0, least = 1e300, elastic = 0;
    while (s.time() < 1 - 1e-9) {
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok()) << s.explain(report);
      if (s.time() < 0.014) continue;
      const auto e = s.energy();
      most = std::max(most, e.kinetic + e.elastic);
      least = std::min(least, e.kinetic + e.elastic);
      elastic = std::max(elastic, e.elastic);
    }
    std::cout << "  " << kind << ": energy from " << least << " to " << most << ", elastic up to " << elastic
              << '\n';
    EXPECT_GT(elastic, 0.05 * most);
    drift[fine] = (most - least) / most;
  }
  EXPECT_LT(drift[1], 6e-3);  // the integrator damps the highest modes
  EXPECT_GT(drift[0] / drift[1], 2.5);
}

std::string name_of(const testing::TestParamInfo<NonlinearBeam::ParamType>& which) {
  const bool relative = std::get<1>(which.param) == spec::Simulation::Formulation::relative;
  return std::get<0>(which.param) + (relative ? "_relative" : "_natural");
}
const auto formulations =
    testing::Values(spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural);
INSTANTIATE_TEST_SUITE_P(All, SlenderBeam,
                         testing::Combine(testing::Values("corotational", "ancf", "ancf_cable"),
                                          formulations),
                         name_of);
INSTANTIATE_TEST_SUITE_P(All, NonlinearBeam,
                         testing::Combine(testing::Values("corotational", "ancf", "ancf_cable", "ancf_thick"),
                                          formulations),
                         name_of);

/// Steady rotation: the tip moves out by ρΩ²L³/3E.
TEST(NonlinearBeams, RotationStretchesTheSpinUpBeam) {
  for (const std::string method : {"ancf", "nonlinear_beam"}) {
    const auto model = example("spin-up-beam/beam-2d.yaml", {{"method", method}});
    Simulation s(model);
    ResultsRow row;
    double sum = 0;
    int count = 0;
    while (s.time() < 19.995) {
      ASSERT_TRUE(s.step().ok());
      if (s.time() < 17) continue;
      s.sample(row);
      sum += row.channels[0];
      ++count;
    }
    EXPECT_NEAR(sum / count, 3000.0 * 36 * 1000 / (3 * 7e10), 2e-6) << method;  // 0.514 mm
  }
}

/// Momentum and angular momentum about the origin, the forces that the velocities as accelerations would
/// need.
Eigen::Vector3d momentum(relative::RelativeSystem& system, const State& s) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(s.v.size());
  Eigen::VectorXd with(s.v.size()), without(s.v.size());
  system.residual(1, s.q.data(), zero.data(), s.v.data(), s.multipliers.data(), 0, with.data());
  system.residual(1, s.q.data(), zero.data(), zero.data(), s.multipliers.data(), 0, without.data());
  const Eigen::VectorXd p = with - without;
  return {p[0], p[1], p[2] + s.q[0] * p[1] - s.q[1] * p[0]};
}

TEST(NonlinearBeams, AFreeBeamKeepsItsMomentum) {
  for (const std::string kind : {"corotational", "ancf", "ancf_cable", "ancf_thick"}) {
    std::array<double, 2> change{};
    for (const bool fine : {false, true}) {
      const double step = fine ? 0.00025 : 0.0005;
      const auto model = model_of(free_beam(kind, std::to_string(step)));
      Eigen::Vector3d start = Eigen::Vector3d::Zero();
      run(model, generalised_alpha(step, 0.4), 0.6, initial_state(model),
          [&](relative::RelativeSystem& system, const State& s) {
            if (s.time < 0.0125) return;
            const Eigen::Vector3d p = momentum(system, s);
            if (start.isZero(0)) start = p;
            change[fine] = std::max(change[fine], (p - start).norm() / start.norm());
          });
      EXPECT_GT(start.norm(), 3);
    }
    std::cout << "  " << kind << ": momentum changes by " << change[0] << ", " << change[1] << '\n';
    EXPECT_LT(change[1], 2e-3) << kind;
    EXPECT_GT(change[0] / change[1], 3) << kind;
  }
}

/// The two beams are different theories of the same thing: they meet.
TEST(NonlinearBeams, AgreeWithEachOther) {
  std::array<std::vector<double>, 2> tips;
  for (const bool ancf : {false, true}) {
    Simulation s(example("spin-up-beam/beam-2d.yaml",
                         {{"method", ancf ? "ancf" : "nonlinear_beam"}, {"elements", "20"}}));
    ResultsRow row;
    while (s.time() < 9.995) {
      ASSERT_TRUE(s.step().ok());
      s.sample(row);
      tips[ancf].push_back(row.channels[1]);
    }
  }
  double most = 0, largest = 0;
  for (std::size_t k = 0; k < tips[0].size(); ++k) {
    most = std::max(most, std::abs(tips[0][k] - tips[1][k]));
    largest = std::max(largest, std::abs(tips[0][k]));
  }
  EXPECT_GT(largest, 0.5);
  EXPECT_LT(most, 3e-4 * largest);
}

std::string strip(double edgewise, double flapwise, double area, double weak, double strong, double twist) {
  const auto text = [](double x) {
    std::ostringstream out;
    out << std::setprecision(16) << x;
    return out.str();
  };
  return R"(
gravity: [0, 0, 0]
materials: {m: {young: 71.7e9, poisson: 0.31, density: 2800}}
sections: {s: {area: )" +
         text(area) + ", Iy: " + text(weak) + ", Iz: " + text(strong) + ", J: " + text(twist) + R"(}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: m
      section: s
      nodes: {root: [0, 0, 0], tip: [0.508, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 16, y: [0, 1, 0]}}
      clamped: [root]
      beam: corotational
)" + wall +
         load("force: [0, " + text(edgewise) + ", " + text(flapwise) + "]") + R"(
outputs:
  - {name: uy, displacement: beam.tip, relative_to: beam, component: y}
  - {name: uz, displacement: beam.tip, relative_to: beam, component: z}
)";
}

/// The Princeton beam (E. H. Dowell, J. Traybar, D. H. Hodges, An experimental-theoretical correlation study
/// of non-linear bending and torsion deformations of a cantilever beam, J. Sound Vib. 50 (1977) 533–544):
/// a strip under an end load at an angle to its plane. Deflections of converged beam elements of a commercial
/// code, as published by L. P. Obrezkov et al., Nonlinear Dynamics 109 (2022) 31–54. Edgewise, flapwise.
TEST(NonlinearBeams, PrincetonBeam) {
  struct Row {
    double angle, y, z;
  };
  const std::array<Row, 7> light{{{0, 1.071417630e-2, 0},
                                  {15, 1.061328706e-2, 4.208232124e-2},
                                  {30, 1.011169630e-2, 7.939482948e-2},
                                  {45, 8.837226265e-3, 0.108987937},
                                  {60, 6.604665004e-3, 0.129887616},
                                  {75, 3.538889001e-3, 0.142194370},
                                  {90, 0, 0.146245978}}},
      heavy{{{0, 1.606423724e-2, 0},
             {15, 1.645825752e-2, 6.435812858e-2},
             {30, 1.665873206e-2, 0.117735994},
             {45, 1.518618440e-2, 0.156467239},
             {60, 1.157837500e-2, 0.181861627},
             {75, 6.248967384e-3, 0.196097131},
             {90, 0, 0.200677707}}};
  const double h = 12.3777e-3, w = 3.2024e-3;
  const double strong = w * h * h * h / 12, weak = h * w * w * w / 12;
  // St Venant's torsion constant of the rectangle.
  const double twist = h * w * w * w / 3 * (1 - 0.63 * w / h * (1 - std::pow(w / h, 4) / 12));
  const auto check = [&](double force, const std::array<Row, 7>& rows) {
    for (const Row& row : rows) {
      const double a = row.angle * pi / 180;
      const StaticResult r = static_equilibrium(
          model_of(strip(force * std::cos(a), force * std::sin(a), h * w, weak, strong, twist)));
      const double y = value(r, "uy"), z = value(r, "uz");
      std::cout << "  " << force << " N, " << row.angle << " degrees: " << y << ' ' << z << " (" << row.y
                << ' ' << row.z << ")\n";
      EXPECT_NEAR(y, row.y, 0.02 * 1.6e-2) << force << " N at " << row.angle;
      EXPECT_NEAR(z, row.z, 0.005 * 0.2) << force << " N at " << row.angle;
    }
  };
  check(8.896, light);
  check(13.345, heavy);
}

}  // namespace
}  // namespace mimbre::test::nonlinear_beam_test
