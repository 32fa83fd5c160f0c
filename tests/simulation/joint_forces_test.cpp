#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// Joint forces, which are what a tolerance is felt in first: those of light bodies between heavy ones.
namespace mimbre::test::joint_forces_test {
namespace {

struct Course {
  std::vector<Eigen::VectorXd> rows;  ///< of the model's outputs
};

Course course(const std::shared_ptr<const Model>& model, const RunOptions& options, double duration) {
  Simulation s(model, options);
  Course c;
  ResultsRow row;
  for (int k = static_cast<int>(std::lround(duration / *options.step)); k > 0; --k) {
    const StepReport report = s.step();
    if (!report.ok()) {
      ADD_FAILURE() << s.explain(report);
      break;
    }
    s.sample(row);
    c.rows.push_back(row.channels.head(s.output_count()));
  }
  return c;
}

/// Largest difference of an output over the run, by its largest value.
double difference(const Course& a, const Course& b, int output) {
  double largest = 0, value = 0;
  for (std::size_t k = 0; k < std::min(a.rows.size(), b.rows.size()); ++k) {
    largest = std::max(largest, std::abs(a.rows[k][output] - b.rows[k][output]));
    value = std::max(value, std::abs(b.rows[k][output]));
  }
  return largest / value;
}

/// A double wishbone axle with bushings of dummy bodies, 0.01 kg beside 600 kg, over a kerb: the force in a
/// bushing.
TEST(JointForces, OfLightBodiesBesideHeavyOnes) {
  const auto model = Model::compile(load_model(MIMBRE_SOURCE_DIR "/tests/data/hard/axle.yaml"));
  const auto& outputs = model->spec().outputs;
  const int force = static_cast<int>(
      std::find_if(outputs.begin(), outputs.end(), [](const auto& o) { return o.name == "bush.fx"; }) -
      outputs.begin());
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural})
    for (const double step : {0.01, 0.002, 0.0005}) {
      RunOptions options;
      options.step = step;
      options.formulation = formulation;
      RunOptions tight = options;
      tight.tolerance = 1e-9;
      const double duration = 1.3;
      EXPECT_LT(difference(course(model, options, duration), course(model, tight, duration), force), 1e-3)
          << step << " s";
    }
}

/// Rigid double four-bar: between bars 4 and 5, which stand at θ and lie level, bar 5 needs, with
/// accelerations r̈ = θ̈ u⊥ − θ̇² u of bar 4,
///   fy = −½ (ÿ + g),   fx sin θ = fy cos θ − ½ g cos θ − ⅓ θ̈ → −g/36 where the bars align:
/// a pole, so that there any error of θ is felt; the forces are right for the motion as it is.
TEST(JointForces, OfTheDoubleFourBarFollowItsMotionUpToThePole) {
  const auto model = example("double-four-bar/mechanism.yaml");
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    RunOptions options;
    options.step = 0.01;
    options.formulation = formulation;
    Simulation s(model, options);
    const auto channel = [&](const std::string& name) {
      const auto& info = s.channels();
      return std::find_if(info.begin(), info.end(), [&](const auto& c) { return c.name == name; }) -
             info.begin();
    };
    const auto fx = channel("joint.E.force.x"), fy = channel("joint.E.force.y"),
               rate = channel("joint.A.velocity");
    ResultsRow row;
    double near_pole = 0;
    for (int k = 0; k < 500; ++k) {
      ASSERT_TRUE(s.step().ok());
      s.sample(row);
      const double theta = row.channels[0], omega = row.channels[rate], g = 9.81, sine = std::sin(theta),
                   cosine = std::cos(theta), alpha = -3.5 * g * cosine / 3;
      const double up = -0.5 * (alpha * cosine - omega * omega * sine + g);
      const double along = (up * cosine - 0.5 * g * cosine - alpha / 3) / sine;
      EXPECT_NEAR(row.channels[fy], up, 1e-3 * 60) << s.time();
      EXPECT_NEAR(row.channels[fx], along, 1e-3 * 40 * std::max(1.0, 0.01 / (sine * sine))) << s.time();
      near_pole = std::max(near_pole, 1 / std::abs(sine));
    }
    EXPECT_GT(near_pole, 50);
  }
}

}  // namespace
}  // namespace mimbre::test::joint_forces_test
