#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "support/exchange_importer.h"

/// Motions of FMUs for model exchange, integrated by an explicit rule, against fine runs of the library.
namespace mimbre::test::model_exchange_motion_test {
namespace {

class ModelExchange : public ExchangeTest {};

TEST_P(ModelExchange, DoublePendulumSwingsAsInTheLibrary) {
  const auto model = double_pendulum();
  const FmuLibrary& of = library(model, "double_pendulum");
  EXPECT_EQ(of.fmu().code.states.size(), 4u);
  EXPECT_EQ(of.fmu().code.indicators, 0);
  EXPECT_EQ(of.fmu().code.states[0].unit, "rad");
  ExchangeSolver solver(of, 5e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 2, 0.1), 0.1), 1e-8);
}

TEST_P(ModelExchange, LoopsControllersAndElementsThatRememberMoveAsInTheLibrary) {
  const auto model = driven_loop();
  const FmuLibrary& of = library(model, "driven");
  ExchangeSolver solver(of, 1e-4);
  EXPECT_LE(difference(solver, extrapolated_run(model, of.fmu(), 1e-4, 0.5, 0.05), 0.05), 1e-6);
}

TEST_P(ModelExchange, ChangesCoordinatesWhereTheyBecomeSingular) {
  const auto model = swinging();
  const FmuLibrary& of = library(model, "swinging");
  ExchangeSolver solver(of, 1e-4);
  EXPECT_LE(difference(solver, extrapolated_run(model, of.fmu(), 5e-5, 2, 0.1), 0.1), 1e-6);
  EXPECT_GE(solver.changes(), 2);
}

/// Rotations are counted from a reference that follows them; a body may fly, which co-simulation leaves out.
TEST_P(ModelExchange, RotationsGoOnThroughAnyNumberOfTurns) {
  const auto model = turning();
  const FmuLibrary& of = library(model, "turning");
  EXPECT_EQ(of.fmu().code.indicators, 2);
  ExchangeSolver solver(of, 2e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 2, 0.1), 0.1), 1e-7);
  EXPECT_GE(solver.changes(), 4);
}

TEST_P(ModelExchange, DrivesOverRoadsAsInTheLibrary) {
  const auto model = uphill();
  const FmuLibrary& of = library(model, "uphill");
  ExchangeSolver solver(of, 2e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 0.5, 0.1), 0.1), 1e-7);
}

TEST_P(ModelExchange, EightThreadsHaveTheSameBits) {
  const FmuLibrary& of = library(driven_loop(), "driven");
  std::vector<std::vector<double>> found(8);
  std::vector<std::thread> threads;
  for (std::vector<double>& one : found)
    threads.emplace_back([&] {
      ExchangeSolver solver(of, 1e-3);
      solver.go_to(0.05);
      one = solver.instance().states();
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& one : found) EXPECT_EQ(one, found[0]);
}

TEST_P(ModelExchange, GoesOnFromSavedStates) {
  const FmuLibrary& of = library(driven_loop(), "driven");
  ExchangeSolver solver(of, 1e-3);
  solver.go_to(0.1);
  ExchangeInstance& f = solver.instance();
  void* state = nullptr;
  ASSERT_EQ(f.get_state(&state), fmi_ok);
  const std::vector<double> x = f.states();
  const auto ahead = [&](ExchangeInstance& g) {
    std::vector<double> y = g.states();
    for (double& z : y) z += 1e-3;
    std::vector<double> out = g.derivatives(0.101, y);
    y[0] += 1e-3;
    const std::vector<double> more = g.derivatives(0.102, y);
    out.insert(out.end(), more.begin(), more.end());
    return out;
  };
  const std::vector<double> first = ahead(f);
  ASSERT_EQ(f.set_state(state), fmi_ok);
  EXPECT_EQ(f.states(), x);
  EXPECT_EQ(ahead(f), first);
  std::vector<char> bytes(f.state_size(state));
  ASSERT_EQ(f.write_state(state, bytes.data(), bytes.size()), fmi_ok);
  ExchangeInstance other(of);
  void* read = nullptr;
  ASSERT_EQ(other.read_state(bytes.data(), bytes.size(), &read), fmi_ok);
  ASSERT_EQ(other.set_state(read), fmi_ok);
  EXPECT_EQ(ahead(other), first);
}

/// The scales of the mechanism: 1 rad, a length, and rates by a pace that is one of all.
TEST_P(ModelExchange, NominalsAreOfTheScaleOfTheStates) {
  for (const auto& [model, name] : {std::pair(double_pendulum(), "double_pendulum"),
                                    {driven_loop(), "driven"},
                                    {swinging(), "swinging"},
                                    {turning(), "turning"}}) {
    SCOPED_TRACE(name);
    const FmuLibrary& of = library(model, name);
    ExchangeSolver solver(of, 5e-4);
    std::vector<double> largest(of.fmu().code.states.size());
    for (int k = 0; k <= 20; ++k) {
      solver.go_to(0.01 * k);
      const std::vector<double> x = solver.instance().states();
      for (std::size_t i = 0; i < x.size(); ++i) largest[i] = std::max(largest[i], std::abs(x[i]));
    }
    const std::vector<double> nominals = solver.instance().nominals();
    ASSERT_EQ(nominals.size(), largest.size());
    for (std::size_t i = 0; i < nominals.size(); ++i) {
      EXPECT_TRUE(std::isfinite(nominals[i]) && nominals[i] > 0) << nominals[i];
      EXPECT_LE(largest[i], 30 * nominals[i]) << i << " " << of.fmu().code.states[i].meaning;
    }
  }
  const std::vector<double> nominals = [&] {
    ExchangeInstance f(library(double_pendulum(), "double_pendulum"));
    f.start_continuous();
    return f.nominals();
  }();
  EXPECT_EQ(nominals[0], 1);  // rad
  EXPECT_EQ(nominals[1], 1);
  EXPECT_EQ(nominals[2], nominals[3]);
  EXPECT_GT(nominals[2], 1);  // rad/s: the pace of a pendulum of the mechanism's length
  EXPECT_LT(nominals[2], 10);
}

INSTANTIATE_TEST_SUITE_P(Versions, ModelExchange, testing::Values(2, 3), name_of_version);

}  // namespace
}  // namespace mimbre::test::model_exchange_motion_test
