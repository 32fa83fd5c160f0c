#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/fmu.h"
#include "support/fmu_importer.h"
#include "support/models.h"

/// Importers of FMUs for model exchange, and models for them.
namespace mimbre::test {

FmuCode exchange_fmu(const std::shared_ptr<const Model>& model, int version, const std::string& name);

/// A solver as importers have them: Runge-Kutta's rule with steps of h, events in time at their instants, and
/// of states at the ends of steps.
class ExchangeSolver {
 public:
  ExchangeSolver(const FmuLibrary& library, double h) : f_(library), h_(h) {
    const ExchangeInstance::Update first = f_.start_continuous();
    next_ = first.has_next ? first.next : HUGE_VAL;
    x_ = f_.states();
  }

  void go_to(double end) {
    while (time_ < end - 1e-12) {
      const double to = std::min({time_ + h_, end, next_});
      step(to - time_);
      time_ = to;
      f_.set_time(time_);
      f_.set_states(x_);
      const std::vector<double> indicators = f_.indicators();
      const bool event = std::any_of(indicators.begin(), indicators.end(), [](double z) { return z < 0; });
      if (event || time_ >= next_) update();
    }
  }
  ExchangeInstance& instance() { return f_; }
  int changes() const { return changes_; }
  int times() const { return times_; }

 private:
  void step(double h) {
    const auto at = [&](double ahead, const std::vector<double>& k) {
      std::vector<double> x = x_;
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += ahead * k[i];
      return f_.derivatives(time_ + ahead, x);
    };
    const std::vector<double> a = f_.derivatives(time_, x_), b = at(h / 2, a), c = at(h / 2, b), d = at(h, c);
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  void update() {
    times_ += time_ >= next_ ? 1 : 0;
    const ExchangeInstance::Update u = f_.event();
    next_ = u.has_next ? u.next : HUGE_VAL;
    EXPECT_GT(next_, time_ + 1e-9);  // and none is told twice
    if (!u.changed) return;
    ++changes_;
    x_ = f_.states();
    for (const double z : f_.indicators()) EXPECT_GT(z, 0);
  }

  ExchangeInstance f_;
  double h_, time_ = 0, next_ = HUGE_VAL;
  std::vector<double> x_;
  int changes_ = 0, times_ = 0;
};

/// Outputs of a run of the library every `every` seconds: from steps of h and h/2, whose errors are of second
/// order, and with an accuracy of 1e-11.
std::vector<std::vector<double>> extrapolated_run(const std::shared_ptr<const Model>& model,
                                                  const FmuCode& fmu, double h, double end, double every);
std::vector<std::vector<double>> accurate_run(const std::shared_ptr<const Model>& model, const FmuCode& fmu,
                                              double end, double every);

/// Largest difference over both of the outputs, by their size or 1.
double difference(ExchangeSolver& solver, const std::vector<std::vector<double>>& expected, double every);

/// Tests of both versions of the standard.
class ExchangeTest : public testing::TestWithParam<int> {
 protected:
  /// Compiled once in a process.
  const FmuLibrary& library(const std::shared_ptr<const Model>& model, const std::string& name) const;
};
std::string name_of_version(const testing::TestParamInfo<int>& version);

std::shared_ptr<const Model> double_pendulum();
/// A loop, controllers, and elements that remember.
std::shared_ptr<const Model> driven_loop();
/// A four-bar that swings over: no coordinate is independent all the way.
std::shared_ptr<const Model> swinging();
/// A top, and a body that flies.
std::shared_ptr<const Model> turning();
/// Functions of time in signals and in a drive, and a parameter.
std::shared_ptr<const Model> timed_outputs();
/// A wheel that goes up a road with its car.
std::shared_ptr<const Model> uphill();

}  // namespace mimbre::test
