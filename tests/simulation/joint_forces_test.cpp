#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// Joint forces, which are what a tolerance is felt in first: those of light bodies between heavy ones.
namespace mimbre::test {
namespace {

struct Course {
  std::vector<Eigen::VectorXd> rows;  ///< of the model's outputs
};

Course course(const std::shared_ptr<const Model>& model, const RunOptions& options, double duration) {
  Simulation s(model, options);
  Course c;
  ResultsRow row;
  for (int k = static_cast<int>(std::lround(duration / options.step)); k > 0; --k) {
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

}  // namespace
}  // namespace mimbre::test
