#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/exchange_importer.h"
#include "support/hostile_importer.h"

/// Importers that call FMUs for model exchange wrongly.
namespace mimbre::test::model_exchange_calls_test {
namespace {

using testing::HasSubstr;

class ModelExchangeCalls : public ExchangeTest {};

TEST_P(ModelExchangeCalls, RefusesWrongCalls) {
  const FmuLibrary& of = library(driven_loop(), "driven");
  const double nan = std::nan("");
  ExchangeInstance f(of);
  const std::size_t n = f.size();
  std::vector<double> x(n + 1, 0.0);
  EXPECT_EQ(f.set_time(0), fmi_error);
  EXPECT_EQ(f.set_states(x.data(), n), fmi_error);
  EXPECT_EQ(f.simple("EnterContinuousTimeMode"), fmi_error);
  EXPECT_EQ(f.simple("EnterEventMode"), fmi_error);
  f.start();
  EXPECT_EQ(f.set(reference(of.fmu(), "k"), 2), fmi_ok);  // at an event
  EXPECT_EQ(f.update().status, fmi_ok);
  EXPECT_EQ(f.set_states(x.data(), n), fmi_error);
  EXPECT_EQ(f.set_time(0), fmi_ok);  // importers do so at events
  EXPECT_EQ(f.simple("EnterEventMode"), GetParam() == 2 ? fmi_ok : fmi_error);
  EXPECT_EQ(f.simple("EnterContinuousTimeMode"), fmi_ok);
  EXPECT_EQ(f.update().status, fmi_error);
  const std::vector<double> before = f.derivatives(), states = f.states();
  EXPECT_EQ(f.set(reference(of.fmu(), "k"), 1), fmi_error);
  EXPECT_THAT(f.messages(), HasSubstr("events"));
  EXPECT_EQ(f.set(reference(of.fmu(), "wanted"), nan), fmi_error);
  EXPECT_EQ(f.set(reference(of.fmu(), "state.1"), 1), fmi_error);
  EXPECT_EQ(f.get({static_cast<unsigned>(of.fmu().variables.size())}, x.data()), fmi_error);
  EXPECT_EQ(f.set_time(nan), fmi_error);
  EXPECT_EQ(f.set_states(states.data(), n - 1), fmi_error);
  EXPECT_EQ(f.set_states(nullptr, n), fmi_error);
  std::vector<double> wrong = states;
  wrong[0] = nan;
  EXPECT_EQ(f.set_states(wrong), fmi_error);
  for (const char* function : {"GetContinuousStates", "GetNominalsOfContinuousStates", "GetEventIndicators"})
    EXPECT_EQ(f.read(function, x.data(), n + 1), fmi_error) << function;
  EXPECT_EQ(f.read(f.derivatives_function(), x.data(), n + 1), fmi_error);
  EXPECT_EQ(f.read(f.derivatives_function(), nullptr, n), fmi_error);
  EXPECT_EQ(f.derivatives(), before);
  EXPECT_EQ(f.simple("Terminate"), fmi_ok);
  EXPECT_EQ(f.set_time(1), fmi_error);
  EXPECT_EQ(f.simple("Reset"), fmi_ok);
  f.start_continuous();
  EXPECT_NE(f.derivatives(), std::vector<double>(n, 0.0));
}

/// Positions that the loop cannot reach: the importer may try a shorter step.
TEST_P(ModelExchangeCalls, DiscardsStatesOutOfReach) {
  const FmuLibrary& of = library(swinging(), "swinging");
  ExchangeInstance f(of);
  f.start_continuous();
  const std::vector<double> before = f.derivatives(), states = f.states();
  std::vector<double> far = states, found(f.size());
  far[0] += 3;
  EXPECT_EQ(f.set_states(far), fmi_ok);
  EXPECT_EQ(f.read(f.derivatives_function(), found.data(), f.size()), fmi_discard);
  EXPECT_THAT(f.messages(), HasSubstr("dependent"));
  EXPECT_EQ(f.get({reference(of.fmu(), "crank")}, found.data()), fmi_discard);
  EXPECT_EQ(f.set_states(states), fmi_ok);
  const std::vector<double> after = f.derivatives();
  for (std::size_t k = 0; k < f.size(); ++k) EXPECT_NEAR(after[k], before[k], 1e-12 * std::abs(before[k]));
}

TEST_P(ModelExchangeCalls, NamesDirectionalDerivativesWhereAdjointOnesAreCalled) {
  const FmuLibrary& of = library(driven_loop(), "driven");
  ExchangeInstance f(of);
  f.start_continuous();
  if (of.two()) {
    EXPECT_FALSE(of.has("fmi2GetAdjointDerivative"));  // FMI 3 has introduced them
    return;
  }
  const unsigned unknown = reference(of.fmu(), "der(state.1)"), known = reference(of.fmu(), "state.1");
  const double seed = 1;
  double result = 7;
  EXPECT_EQ(of.call("GetAdjointDerivative", f.handle(), &unknown, std::size_t{1}, &known, std::size_t{1},
                    &seed, std::size_t{1}, &result, std::size_t{1}),
            fmi_error);
  EXPECT_EQ(result, 7);
  EXPECT_THAT(f.messages(),
              testing::AllOf(HasSubstr("no adjoint"), HasSubstr("fmi3GetDirectionalDerivative")));
}

/// Random calls with wrong arguments, under the sanitizers.
TEST_P(ModelExchangeCalls, StandsHostileImporters) {
  const FmuCode fmu = exchange_fmu(driven_loop(), GetParam(), "hostile_exchange");
  const std::string printed =
      printed_by_hostile(fmu, "hostile_exchange", "-DSTATES=" + std::to_string(fmu.code.states.size()));
  if (printed.empty()) GTEST_SKIP() << "the compiler has no sanitizers";
  expect_good_calls(printed, 15, {});
}

INSTANTIATE_TEST_SUITE_P(Versions, ModelExchangeCalls, testing::Values(2, 3), name_of_version);

}  // namespace
}  // namespace mimbre::test::model_exchange_calls_test
