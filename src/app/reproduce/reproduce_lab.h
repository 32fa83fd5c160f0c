#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/reproduce/reproduce_examples.h"
#include "mimbre/simulation.h"

namespace mimbre::app {

using Settings = std::map<std::string, std::string>;

/// One run: a built-in model with parameters, and how it is integrated.
struct Case {
  std::string file;  ///< below examples/
  Settings settings;
  RunOptions options;
};

/// Unknowns of a formulation.
struct Counts {
  int coordinates = 0, constraints = 0;
};

/// The longest of the steps that were tried with which a run goes through.
struct LongestStep {
  double step = 0;   ///< s
  double error = 0;  ///< m, see Lab::height_error
};

/// Runs cases and measures them. Models and references are kept, so that tables share them. What fails throws
/// std::runtime_error with the reason, an interrupt Failure.
class Lab {
 public:
  const ExampleFolder& examples() const { return examples_; }
  Counts counts(const Case& c);
  /// CPU seconds of the steps: the least of a few runs.
  double cpu_seconds(const Case& c);
  /// Mean absolute deviation of the chassis' height over the last 3 s from the same model in steps of 0.1 ms,
  /// default integrator, m (Lugrís 2008, 2.184).
  double height_error(const Case& c);
  /// The longest step of 50, 49, … 10 ms that goes through.
  LongestStep longest_step(const Case& c);
  /// The longest step, s, from 10 ms on up to which every whole millisecond goes through.
  double unbroken_step(const Case& c);
  /// Mean absolute deviation of the first outputs (the tip's displacements, by component) from the same model
  /// with 40 nonlinear beams in steps of 1 ms, default integrator, m, every 10 ms (Lugrís 2008, 4.37).
  Eigen::VectorXd tip_deviation(const Case& c);
  /// Energy that the numerics took out, J: mean of the magnitude over all steps; at the end.
  double mean_energy_loss(const Case& c);
  double energy_loss(const Case& c);

 private:
  /// The chassis' heights at equal intervals from zero.
  struct Trace {
    double interval = 0;
    std::vector<double> height;
    double at(double time) const;
  };
  std::shared_ptr<const Model> model(const Case& c);
  Trace heights(const Case& c, int stride);
  const Trace& reference(const Case& c);
  /// The error with every whole number of milliseconds, where the run goes through; computed when asked for.
  std::optional<double> error_at(const Case& c, int milliseconds);

  ExampleFolder examples_;
  std::map<std::string, std::shared_ptr<const Model>> models_;
  Eigen::MatrixXd tips(const Case& c, int stride);
  std::map<std::string, Eigen::MatrixXd> tip_references_;
  std::map<std::string, Trace> references_;
  std::map<std::string, std::optional<double>> errors_;
};

}  // namespace mimbre::app
