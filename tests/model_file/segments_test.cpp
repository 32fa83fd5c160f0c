#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "mimbre/modes.h"
#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// Bars made of rigid segments with springs: frequencies and deflections against closed forms.
namespace mimbre::test::segments_test {
namespace {

constexpr double young = 2.1e11, density = 7850, length = 1.2, width = 0.004, height = 0.006;
constexpr double area = width * height, Iy = width * height * height * height / 12,
                 Iz = height * width * width * width / 12, J = 1e-11, shear = young / 2.6;

std::string cantilever(int elements, const std::string& beam, const std::string& more = "") {
  return fmt::format(R"(
gravity: [0, 0, 0]
materials: {{steel: {{young: {}, poisson: 0.3, density: {}}}}}
sections: {{bar: {{area: {}, Iy: {}, Iz: {}, J: {}}}}}
bodies:
  beam:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: steel
      section: bar
      nodes: {{root: [0, 0, 0], middle: {{on: [bar, 0.5]}}, tip: [{}, 0, 0]}}
      bars: {{bar: {{from: root, to: tip, elements: {}, y: [0, 1, 0]}}}}
      clamped: [root]
      beam: {}
joints: {{clamp: {{type: fixed, between: [ground, beam], at: [0, 0, 0]}}}}
{})",
                     young, density, area, Iy, Iz, J, length, elements, beam, more);
}

std::vector<double> frequencies(const std::string& text) {
  std::vector<double> all;
  for (const Mode& m : find_modes(model_of(text)).modes) all.push_back(2 * std::numbers::pi * m.frequency);
  std::sort(all.begin(), all.end());
  return all;
}
double nearest(const std::vector<double>& all, double to) {
  return *std::min_element(all.begin(), all.end(),
                           [&](double a, double b) { return std::abs(a - to) < std::abs(b - to); });
}

/// Bending both ways and twist of the fixed–free bar (Euler, Bernoulli), rad/s; stretching, too.
struct Exact {
  std::vector<double> bending, others;
};
Exact exact(bool stretches) {
  const auto bending = [](double I, double root) {
    return root * root / (length * length) * std::sqrt(young * I / (density * area));
  };
  const double quarter = std::numbers::pi / (2 * length);
  Exact e{{bending(Iz, 1.8751040687), bending(Iy, 1.8751040687), bending(Iz, 4.6940911330)},
          {quarter * std::sqrt(shear * J / (density * (Iy + Iz)))}};
  if (stretches) e.others.push_back(quarter * std::sqrt(young / density));
  return e;
}

TEST(Segments, FrequenciesConvergeWithTheSquareOfTheirNumber) {
  for (const bool stretches : {false, true}) {
    const std::string beam = stretches ? "stretching_segments" : "segments";
    const Exact e = exact(stretches);
    std::vector<double> expected = e.bending;
    expected.insert(expected.end(), e.others.begin(), e.others.end());
    std::vector<std::vector<double>> errors;
    for (const int elements : {8, 16, 32}) {
      const std::vector<double> found = frequencies(cantilever(elements, beam));
      std::vector<double> row;
      for (const double f : expected) row.push_back(nearest(found, f) / f - 1);
      errors.push_back(row);
    }
    for (std::size_t k = 0; k < expected.size(); ++k)
      for (int level = 0; level < 2; ++level) {
        const double ratio = errors[level][k] / errors[level + 1][k];
        EXPECT_GT(ratio, 3.4) << beam << ", frequency " << expected[k] << ", errors " << errors[level][k];
        EXPECT_LT(ratio, 4.6) << beam << ", frequency " << expected[k] << ", errors " << errors[level][k];
        EXPECT_LT(std::abs(errors[2][k]), 0.01) << beam << ", frequency " << expected[k];
      }
  }
}

double deflection(const std::string& text) {
  const StaticResult r = static_equilibrium(model_of(text));
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    if (r.channels[k].name == "sag") return r.values[static_cast<Eigen::Index>(k)];
  return NAN;
}

/// Springs in the middles of n elements: 1 − 1/(4 n²) of P L³/3EI by the midpoint rule; with the elements'
/// own bending across, all of it.
TEST(Segments, SagAsTheirSpringsSay) {
  const double load = 1e-3;
  for (const bool vertical : {true, false}) {
    const double exact_sag = load * length * length * length / (3 * young * (vertical ? Iy : Iz));
    const std::string more = fmt::format(R"(
loads: {{pull: {{on: beam, at: [{}, 0, 0], force: {}}}}}
outputs: [{{name: sag, deflection: beam, at: [{}, 0, 0], along: {}}}]
)",
                                         length, vertical ? "[0, 0, 0.001]" : "[0, 0.001, 0]", length,
                                         vertical ? "[0, 0, 1]" : "[0, 1, 0]");
    for (const int n : {2, 4, 10}) {
      EXPECT_NEAR(deflection(cantilever(n, "segments", more)), exact_sag * (1 - 1.0 / (4 * n * n)),
                  1e-7 * exact_sag);
      EXPECT_NEAR(deflection(cantilever(n, "stretching_segments", more)), exact_sag, 1e-7 * exact_sag);
    }
  }
}

/// The mass of the whole, where it is, and its inertia about the root, whatever the number of segments.
TEST(Segments, HaveTheInertiaOfTheBar) {
  for (const int n : {2, 4, 10}) {
    const auto model = model_of(cantilever(n, "segments"));
    double mass = 0, about_root = 0;
    for (const spec::Body& b : model->spec().bodies) {
      const Eigen::Vector3d place = b.pose.position + b.com;
      mass += b.mass;
      about_root += b.mass * place.squaredNorm() + b.inertia(1, 1);
      EXPECT_FALSE(b.flexible);
    }
    EXPECT_NEAR(mass, density * area * length, 1e-12 * mass);
    EXPECT_NEAR(about_root, density * length * (area * length * length / 3 + Iy), 1e-12 * about_root);
    EXPECT_EQ(model->spec().bodies.size(), static_cast<std::size_t>(n) + 1);
  }
}

/// A frame that branches, and one that closes.
TEST(Segments, OfFramesThatBranchAndClose) {
  const auto frame = [](const std::string& beam, bool closed, int elements) {
    return fmt::format(R"(
gravity: [0, 0, 0]
materials: {{steel: {{young: {}, poisson: 0.3, density: {}}}}}
sections: {{bar: {{type: round, diameter: 0.02}}}}
bodies:
  frame:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: steel
      section: bar
      beam_theory: rayleigh
      nodes: {{root: [0, 0, 0], knee: [0, 0, 1], left: [-0.6, 0.2, 1.2], right: [0.6, 0, 1.5]}}
      bars:
        post: {{from: root, to: knee, elements: {}}}
        left: {{from: knee, to: left, elements: {}}}
        right: {{from: knee, to: right, elements: {}}}
        {}
      clamped: [root]
      {}
joints: {{clamp: {{type: fixed, between: [ground, frame], at: [0, 0, 0]}}}}
)",
                       young, density, elements, elements, elements,
                       closed ? fmt::format("top: {{from: left, to: right, elements: {}}}", elements) : "",
                       beam);
  };
  for (const bool closed : {false, true}) {
    const std::vector<double> reference = frequencies(frame("dynamic_modes: 24", closed, 20)),
                              coarse = frequencies(frame("beam: stretching_segments", closed, 6)),
                              fine = frequencies(frame("beam: stretching_segments", closed, 12));
    for (int k = 0; k < 4; ++k) {
      const double f = reference[static_cast<std::size_t>(k)],
                   first = coarse[static_cast<std::size_t>(k)] / f - 1,
                   second = fine[static_cast<std::size_t>(k)] / f - 1;
      EXPECT_LT(std::abs(second), 0.01) << "closed: " << closed << ", mode " << k;
      EXPECT_LT(std::abs(second), 0.4 * std::abs(first) + 1e-5) << "closed: " << closed << ", mode " << k;
    }
  }
}

/// In a plane, all the way around: a bar under an end moment rolls up into a circle.
TEST(Segments, RollUpIntoACircle) {
  const double moment = 2 * std::numbers::pi * young * Iy / length;
  std::string planar = cantilever(20, "segments");
  planar.insert(planar.find("      beam: segments"), "      planar: [0, 1, 0]\n");
  planar += fmt::format(R"yaml(
loads: {{roll: {{on: beam, at: [{}, 0, 0], moment: [0, {}, 0], scale: "min(t, 1)"}}}}
outputs: [{{name: x, position: beam, at: [{}, 0, 0], component: x}}, {{name: z, position: beam, at: [{}, 0, 0], component: z}}]
)yaml",
                        length, moment, length, length);
  planar.replace(planar.find("      clamped"), 0, "      stiffness_damping: 0.02\n");
  Simulation simulation(model_of(planar), {});
  const auto x = simulation.channel("x"), z = simulation.channel("z");
  while (simulation.time() < 4) ASSERT_TRUE(simulation.step().ok());
  EXPECT_NEAR(simulation.value(x), 0, 0.01 * length);
  EXPECT_NEAR(simulation.value(z), 0, 0.01 * length);
}

/// In a loop that moves at the start the rod moves as a whole: no segment is left behind, none bends.
TEST(Segments, StartInMotionAsOneBody) {
  std::vector<double> turning;
  for (const char* approach : {"segments", "floating_frame"}) {
    Simulation simulation(example("slider-crank/slider-crank.yaml",
                                  {{"approach", approach}, {"elements", "8"}, {"speed", "20"}}));
    ResultsRow row;
    simulation.sample(row);
    int elastic = 0;
    for (std::size_t k = 0; k < simulation.channels().size(); ++k) {
      const std::string& name = simulation.channels()[k].name;
      const double value = row.channels[static_cast<Eigen::Index>(k)];
      if (name.find(".velocity") == std::string::npos) continue;
      if (name.starts_with("joint.pin.")) turning.push_back(value);
      if (!name.starts_with("joint.rod.")) continue;
      ++elastic;
      EXPECT_NEAR(value, 0, 1e-9) << name;
    }
    EXPECT_EQ(elastic, approach == std::string("segments") ? 24 : 0);
  }
  ASSERT_EQ(turning.size(), 2U);
  // The crank's 20 rad/s forwards, and the rod's 10 back.
  EXPECT_NEAR(std::abs(turning[0]), 30, 1e-9);
  EXPECT_NEAR(turning[0], turning[1], 1e-9);
}

TEST(Segments, DoNotBendByElastodynamics) {
  std::string text = cantilever(4, "segments");
  text.replace(text.find("    frame:"), 0, "    flexibility: elastodynamics\n");
  try {
    model_of(text);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("several pieces"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace mimbre::test::segments_test
