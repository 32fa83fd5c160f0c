#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "mimbre/diagnostics.h"
#include "mimbre/method.h"

/// Options that are out of range, or that conflict, are refused by name.
namespace mimbre::test::conflicting_options_test {
namespace {

using Integrator = spec::Simulation::Integrator;
using testing::HasSubstr;

std::string refusal(const spec::Simulation& given, const std::function<void(RunOptions&)>& change) {
  RunOptions options;
  change(options);
  try {
    resolve_method(given, options);
  } catch (const InputError& error) {
    return error.diagnostics().front().message;
  }
  return "accepted";
}

TEST(ConflictingOptions, OfIntegrators) {
  spec::Simulation given;
  const auto rho = [](RunOptions& o) { o.rho = 0.5; };
  using Given = std::optional<double>;
  constexpr Given none;
  const auto named = [](Integrator rule, Given radius, Given xi) {
    return [=](RunOptions& o) {
      o.integrator = rule;
      o.rho = radius;
      o.xi = xi;
    };
  };
  EXPECT_THAT(refusal(given, named(Integrator::conserve, 0.5, none)),
              HasSubstr("rho is 0.5, but the integrator is conserve"));
  EXPECT_THAT(refusal(given, named(Integrator::newmark, 0.5, none)),
              HasSubstr("rho is 0.5, but the integrator is newmark"));
  EXPECT_THAT(refusal(given, named(Integrator::conserve, none, 0)),
              HasSubstr("xi is 0, but the integrator is conserve"));
  EXPECT_THAT(refusal(given, named(Integrator::generalized_alpha, none, -0.1)),
              HasSubstr("xi belongs to newmark"));
  EXPECT_THAT(refusal(given, named(Integrator::hht, 0.4, none)), HasSubstr("hht takes 0.5 to 1"));
  EXPECT_THAT(refusal(given, named(Integrator::newmark, 0.5, 0)), HasSubstr("exclude each other"));
  given.integrator = Integrator::conserve;
  EXPECT_THAT(refusal(given, rho), HasSubstr("the integrator is conserve in the model"));
  EXPECT_EQ(refusal(given, named(Integrator::generalized_alpha, 0.5, none)), "accepted");
  given.integrator = Integrator::newmark;  // as documented: generalised-α in its place
  RunOptions options;
  rho(options);
  EXPECT_EQ(resolve_method(given, options).integrator, Integrator::generalized_alpha);
}

TEST(ConflictingOptions, OfFixedCost) {
  spec::Simulation given;
  EXPECT_THAT(refusal(given,
                      [](RunOptions& o) {
                        o.fixed_cost = true;
                        o.substeps = 4;
                      }),
              HasSubstr("substeps is 4"));
  given.fixed_cost = true;
  EXPECT_THAT(refusal(given, [](RunOptions& o) { o.substeps = 2; }), HasSubstr("substeps is 2"));
  EXPECT_EQ(refusal(given,
                    [](RunOptions& o) {
                      o.fixed_cost = false;
                      o.substeps = 2;
                    }),
            "accepted");
}

TEST(ConflictingOptions, OutOfRange) {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  const spec::Simulation given;
  for (const double step : {nan, infinite, -0.01})
    EXPECT_THAT(refusal(given, [&](RunOptions& o) { o.step = step; }), HasSubstr("step is "));
  for (const double radius : {nan, -0.5, 1.5})
    EXPECT_THAT(refusal(given, [&](RunOptions& o) { o.rho = radius; }), HasSubstr("rho is "));
  for (const double xi : {nan, 0.5, 2.0, -infinite})
    EXPECT_THAT(refusal(given, [&](RunOptions& o) { o.xi = xi; }), HasSubstr("xi is "));
  for (const double tolerance : {nan, -1.0, 0.0})
    EXPECT_THAT(refusal(given, [&](RunOptions& o) { o.tolerance = tolerance; }), HasSubstr("tolerance is "));
  for (const int count : {-1, 0, 101})
    EXPECT_THAT(refusal(given, [&](RunOptions& o) { o.substeps = count; }), HasSubstr("substeps is "));
  for (const int count : {-1, 0, 1001})
    EXPECT_THAT(refusal(given, [&](RunOptions& o) { o.max_iterations = count; }),
                HasSubstr("max_iterations is "));
  EXPECT_THAT(refusal(given, [&](RunOptions& o) { o.end = nan; }), HasSubstr("end is "));
  EXPECT_EQ(refusal(given, [](RunOptions&) {}), "accepted");
}

}  // namespace
}  // namespace mimbre::test::conflicting_options_test
