#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "support/exchange_importer.h"

/// Directional derivatives of FMUs for model exchange.
namespace mimbre::test::model_exchange_directions_test {
namespace {

using Role = FmuVariable::Role;

class ModelExchangeDirections : public ExchangeTest {};

/// Derivatives, outputs and indicators along random directions of states and inputs, by differences of
/// fourth order; largest difference by the size of each.
double difference_of_directions(ExchangeInstance& f, const FmuCode& fmu, double step) {
  const std::vector<double> x = f.states(), nominals = f.nominals();
  const std::vector<unsigned> inputs = references(fmu, {Role::input}),
                              states = references(fmu, {Role::state});
  const std::vector<unsigned> unknowns = references(fmu, {Role::derivative, Role::output, Role::indicator});
  std::vector<unsigned> knowns = states;
  knowns.insert(knowns.end(), inputs.begin(), inputs.end());
  std::vector<double> given;
  for (const unsigned input : inputs) given.push_back(f.get(input));
  double most = 0;
  for (int direction = 0; direction < 6; ++direction) {
    std::vector<double> seed, exact(unknowns.size());
    for (std::size_t k = 0; k < knowns.size(); ++k)
      seed.push_back(std::sin(1.7 * static_cast<double>(k) + direction) * (k < x.size() ? nominals[k] : 1));
    EXPECT_EQ(f.vary(unknowns, knowns, seed, exact.data()), fmi_ok) << f.messages();
    const auto at = [&](double ahead) {
      std::vector<double> y = x, out(unknowns.size());
      for (std::size_t k = 0; k < x.size(); ++k) y[k] += ahead * seed[k];
      for (std::size_t k = 0; k < inputs.size(); ++k)
        EXPECT_EQ(f.set(inputs[k], given[k] + ahead * seed[x.size() + k]), fmi_ok);
      EXPECT_EQ(f.set_states(y), fmi_ok);
      EXPECT_EQ(f.get(unknowns, out.data()), fmi_ok) << f.messages();
      return out;
    };
    const std::vector<double> a = at(step), b = at(-step), c = at(2 * step), d = at(-2 * step);
    at(0);
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      const double found = (8 * (a[k] - b[k]) - (c[k] - d[k])) / (12 * step);
      const double off = std::abs(found - exact[k]) / std::max(1.0, std::abs(exact[k]));
      EXPECT_TRUE(std::isfinite(off));
      EXPECT_LE(off, 1e-4) << fmu.variables[unknowns[k]].name << " " << found << " " << exact[k];
      most = off <= most ? most : off;
    }
  }
  return most;
}

TEST_P(ModelExchangeDirections, DirectionalDerivativesAreThoseOfDifferences) {
  for (const auto& [model, name, tolerance] : {std::tuple(double_pendulum(), "double_pendulum", 1e-9),
                                               {driven_loop(), "driven", 1e-7},
                                               {swinging(), "swinging", 1e-8},
                                               {turning(), "turning", 1e-8},
                                               {uphill(), "uphill", 1e-8}}) {
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(model, name);
    EXPECT_TRUE(of.fmu().code.varies);
    ExchangeSolver solver(of, 5e-4);
    solver.go_to(0.15);
    EXPECT_LE(difference_of_directions(solver.instance(), of.fmu(), 1e-4), tolerance);
  }
}

/// Partial derivatives by the time, states and inputs held, against differences of fourth order.
TEST_P(ModelExchangeDirections, DirectionalDerivativesByTheTime) {
  for (const auto& [model, name] :
       {std::pair(driven_loop(), "driven"), std::pair(timed_outputs(), "timed_outputs")}) {
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(model, name);
    const std::vector<unsigned> unknowns = references(of.fmu(), {Role::derivative, Role::output});
    ExchangeSolver solver(of, 5e-4);
    solver.go_to(0.15);
    ExchangeInstance& f = solver.instance();
    const std::vector<double> x = f.states();
    const auto at = [&](double time) {
      std::vector<double> out(unknowns.size());
      EXPECT_EQ(f.set_time(time), fmi_ok);
      EXPECT_EQ(f.set_states(x), fmi_ok);
      EXPECT_EQ(f.get(unknowns, out.data()), fmi_ok);
      return out;
    };
    constexpr double h = 1e-3;
    const std::vector<double> a = at(0.15 + h), b = at(0.15 - h), c = at(0.15 + 2 * h), d = at(0.15 - 2 * h);
    const std::vector<double> before = at(0.15);
    std::vector<double> exact(unknowns.size());
    EXPECT_EQ(f.vary(unknowns, {0}, {2}, exact.data()), fmi_ok) << f.messages();
    EXPECT_EQ(at(0.15), before);
    double largest = 0;
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      const double found = (8 * (a[k] - b[k]) - (c[k] - d[k])) / (12 * h);
      EXPECT_NEAR(exact[k] / 2, found, 1e-6 * std::max(1.0, std::abs(found)))
          << of.fmu().variables[unknowns[k]].name;
      largest = std::max(largest, std::abs(found));
    }
    EXPECT_GT(largest, 0.1);
  }
}

TEST_P(ModelExchangeDirections, RefusesWrongDirections) {
  const FmuLibrary& of = library(driven_loop(), "driven");
  const unsigned state = reference(of.fmu(), "state.1"), rate = reference(of.fmu(), "der(state.1)"),
                 speed = reference(of.fmu(), "state.2");
  ExchangeInstance f(of);
  double result = 7;
  EXPECT_EQ(f.vary({rate}, {speed}, {1}, &result), fmi_error);
  f.start_continuous();
  EXPECT_EQ(f.vary({state}, {speed}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {rate}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {4000000000u}, {1}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {speed}, {std::nan("")}, &result), fmi_error);
  EXPECT_EQ(f.vary({rate}, {speed}, {1}, nullptr), fmi_error);
  EXPECT_EQ(result, 7);
  EXPECT_EQ(f.vary({rate}, {speed}, {3}, &result), fmi_ok);
  EXPECT_EQ(result, 3);
  EXPECT_EQ(f.vary({rate}, {0}, {1}, &result), fmi_ok);  // by the time, the states held
  EXPECT_EQ(result, 0);
}

INSTANTIATE_TEST_SUITE_P(Versions, ModelExchangeDirections, testing::Values(2, 3), name_of_version);

}  // namespace
}  // namespace mimbre::test::model_exchange_directions_test
