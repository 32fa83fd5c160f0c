#include "mimbre/function.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <array>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <thread>

#include "mimbre/diagnostics.h"

namespace mimbre::function_test {
namespace {

using std::numbers::pi;
using testing::HasSubstr;
using enum Function::Interpolation;

/// Central differences with extrapolation, apart from the library's own.
template <class F>
double slope_of(F f, double x, double h = 1e-4) {
  const double coarse = (f(x + h) - f(x - h)) / (2 * h), fine = (f(x + h / 2) - f(x - h / 2)) / h;
  return (4 * fine - coarse) / 3;
}

/// Value, derivative, second derivative and antiderivative belong together at x (away from breaks).
void expect_consistent(const Function& f, double x, double tolerance) {
  EXPECT_NEAR(f.derivative(x), slope_of([&](double s) { return f.value(s); }, x), tolerance) << "at " << x;
  EXPECT_NEAR(f.second_derivative(x), slope_of([&](double s) { return f.derivative(s); }, x, 1e-3),
              10 * tolerance)
      << "at " << x;
  EXPECT_NEAR(f.value(x), slope_of([&](double s) { return f.antiderivative(s); }, x), tolerance)
      << "at " << x;
}

std::string refusal(const std::string& text, const std::vector<std::string>& variables = {"x"}) {
  try {
    if (variables.size() == 1)
      Function::expression(text, variables[0]);
    else
      Formula::expression(text, variables);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Function, DefaultIsZero) {
  const Function f;
  EXPECT_TRUE(f.is_zero());
  EXPECT_EQ(f.value(3), 0);
  EXPECT_EQ(f.derivative(3), 0);
  EXPECT_EQ(f.second_derivative(3), 0);
  EXPECT_EQ(f.antiderivative(3), 0);
  EXPECT_TRUE(f.repeated(0, 1).is_zero());
}

TEST(Function, PolynomialsHaveClosedForms) {
  EXPECT_EQ(Function::constant(4).value(-7), 4);
  EXPECT_EQ(Function::constant(4).antiderivative(-7), -28);
  EXPECT_EQ(Function::linear(3, 0.5).value(2.5), 6);
  EXPECT_EQ(Function::linear(3, 0.5).derivative(2.5), 3);
  EXPECT_DOUBLE_EQ(Function::linear(3, 0.5).antiderivative(2), 3);
  const Function p = Function::polynomial({1, -2, 3, 0.5});
  EXPECT_DOUBLE_EQ(p.value(2), 1 - 4 + 12 + 4);
  EXPECT_DOUBLE_EQ(p.derivative(2), -2 + 12 + 6);
  EXPECT_DOUBLE_EQ(p.second_derivative(2), 6 + 6);
  EXPECT_DOUBLE_EQ(p.antiderivative(2), 2 - 4 + 8 + 2);
  EXPECT_EQ(Function::polynomial({}).value(2), 0);
}

TEST(Function, PiecesAreInTheAbsoluteVariableAndBreaksBelongToTheRight) {
  const Function f = Function::piecewise({1, 2}, {{5}, {0, 1}, {0, 0, 1}});
  EXPECT_EQ(f.value(-10), 5);
  EXPECT_EQ(f.value(std::nextafter(1, 0)), 5);
  EXPECT_EQ(f.value(1), 1);
  EXPECT_EQ(f.value(1.5), 1.5);
  EXPECT_EQ(f.value(2), 4);
  EXPECT_EQ(f.value(10), 100);
  EXPECT_EQ(f.derivative(1), 1);
  EXPECT_EQ(f.second_derivative(2), 2);
}

TEST(Function, AntiderivativeIsContinuousOverJumps) {
  const Function f = Function::piecewise({1, 2}, {{5}, {0, 1}, {0, 0, 1}});
  EXPECT_EQ(f.antiderivative(0), 0);
  EXPECT_DOUBLE_EQ(f.antiderivative(-1), -5);
  EXPECT_DOUBLE_EQ(f.antiderivative(1), 5);
  EXPECT_DOUBLE_EQ(f.antiderivative(2), 5 + 1.5);
  EXPECT_DOUBLE_EQ(f.antiderivative(3), 6.5 + 19.0 / 3);
}

TEST(Function, ManyPiecesAreFoundLikeFew) {
  std::vector<double> breaks;
  std::vector<std::vector<double>> pieces{{0}};
  for (int k = 1; k <= 40; ++k) {
    breaks.push_back(0.1 * k);
    pieces.push_back({static_cast<double>(k)});
  }
  const Function f = Function::piecewise(breaks, pieces);
  EXPECT_EQ(f.value(-1), 0);
  EXPECT_EQ(f.value(100), 40);
  for (std::size_t k = 0; k < breaks.size(); ++k) {
    EXPECT_EQ(f.value(breaks[k]), static_cast<double>(k + 1));
    EXPECT_EQ(f.value(std::nextafter(breaks[k], 0)), static_cast<double>(k));
  }
}

TEST(Function, NotANumberGoesThrough) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const Function few = Function::piecewise({0}, {{0, 1}, {0, 2}});
  const Function road = Function::table({0, 1, 2}, {0, 1, 0}, linear).repeated(0, 2);
  EXPECT_TRUE(std::isnan(few.value(nan)));
  EXPECT_TRUE(std::isnan(road.value(nan)));
  EXPECT_TRUE(std::isnan(road.value(inf)));
  EXPECT_TRUE(std::isnan(Function::expression("x+1", "x").value(nan)));
}

TEST(Function, BadPiecesAreRefused) {
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_THROW(Function::piecewise({1, 1}, {{0}, {1}, {2}}), InputError);
  EXPECT_THROW(Function::piecewise({2, 1}, {{0}, {1}, {2}}), InputError);
  EXPECT_THROW(Function::piecewise({1}, {{0}}), InputError);
  EXPECT_THROW(Function::piecewise({}, {}), InputError);
  EXPECT_THROW(Function::piecewise({inf}, {{0}, {1}}), InputError);
  EXPECT_THROW(Function::polynomial({1, inf}), InputError);
}

TEST(FunctionTable, LinearBetweenPointsAndOnBeyondThem) {
  const Function f = Function::table({0, 1, 3}, {0, 2, 1}, linear);
  EXPECT_EQ(f.value(0), 0);
  EXPECT_EQ(f.value(0.25), 0.5);
  EXPECT_EQ(f.value(1), 2);
  EXPECT_EQ(f.value(2), 1.5);
  EXPECT_EQ(f.value(3), 1);
  EXPECT_EQ(f.value(-1), -2);
  EXPECT_EQ(f.value(5), 0);
  EXPECT_EQ(f.derivative(2), -0.5);
  EXPECT_DOUBLE_EQ(f.antiderivative(3), 1 + 3);
}

TEST(FunctionTable, ARepeatedPointIsAJump) {
  const Function f = Function::table({0, 22, 22, 40}, {0.5, 0.5, 0.4, 0.4}, linear);
  EXPECT_EQ(f.value(std::nextafter(22, 0)), 0.5);
  EXPECT_EQ(f.value(22), 0.4);
  EXPECT_EQ(f.derivative(22), 0);
  EXPECT_DOUBLE_EQ(f.antiderivative(40), 22 * 0.5 + 18 * 0.4);
}

TEST(FunctionTable, AJumpAtAnEndIsLevelOutside) {
  const Function f = Function::table({0, 0, 1, 1}, {-1, 0, 2, 5}, linear);
  EXPECT_EQ(f.value(-3), -1);
  EXPECT_EQ(f.value(0), 0);
  EXPECT_EQ(f.value(0.5), 1);
  EXPECT_EQ(f.value(1), 5);
  EXPECT_EQ(f.value(9), 5);
  EXPECT_EQ(Function::table({2, 2}, {0, 1}, linear).value(2), 1);
}

TEST(FunctionTable, BadTablesAreRefused) {
  EXPECT_THROW(Function::table({0}, {1}, linear), InputError);
  EXPECT_THROW(Function::table({0, 1}, {1}, linear), InputError);
  EXPECT_THROW(Function::table({1, 0}, {1, 2}, linear), InputError);
  EXPECT_THROW(Function::table({0, 0, 0}, {1, 2, 3}, linear), InputError);
  EXPECT_THROW(Function::table({0, 1, 1}, {1, 2, 3}, cubic), InputError);
  EXPECT_THROW(Function::table({0, std::nan("")}, {1, 2}, linear), InputError);
  EXPECT_THROW(Function::table({0, 1e-320}, {0, 1}, linear), InputError);
}

TEST(FunctionTable, CubicGoesThroughItsPointsWithContinuousSlope) {
  const std::vector<double> x{-1, 0, 0.5, 2, 3, 3.1}, y{2, 1, 1, 4, 4.5, 9};
  const Function f = Function::table(x, y, cubic);
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(f.value(x[i]), y[i], 1e-14);
    EXPECT_NEAR(f.value(x[i] - 1e-12), f.value(x[i]), 1e-9);
    EXPECT_NEAR(f.derivative(x[i] - 1e-12), f.derivative(x[i]), 1e-6);
  }
  EXPECT_DOUBLE_EQ(f.value(-3), 2 - 2 * f.derivative(-1));
  EXPECT_EQ(f.second_derivative(-3), 0);
  EXPECT_EQ(f.second_derivative(5), 0);
  for (const double at : {-2.0, -0.4, 0.2, 1.3, 2.5, 4.0}) expect_consistent(f, at, 1e-7);
}

TEST(FunctionTable, CubicReproducesAMonotoneParabola) {
  const Function f = Function::table({1, 1.5, 2.25, 3}, {1, 2.25, 5.0625, 9}, cubic);
  for (double x = 1; x <= 3; x += 0.05) EXPECT_NEAR(f.value(x), x * x, 1e-13);
}

TEST(FunctionTable, CubicIsMonotoneWhereItsPointsAre) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> x{0}, y{0};
    for (int i = 0; i < 6; ++i) {
      x.push_back(x.back() + 1e-3 + uniform(random));
      y.push_back(y.back() + (i % 3 == 0 ? 0 : std::pow(uniform(random), 8)));  // plateaus and steep steps
    }
    const Function f = Function::table(x, y, cubic);
    double before = f.value(0);
    for (int i = 1; i <= 2000; ++i) {
      const double now = f.value(x.back() * i / 2000);
      ASSERT_GE(now, before - 1e-14) << "trial " << trial;
      before = now;
    }
  }
}

TEST(FunctionTable, CubicOfTwoPointsIsALine) {
  const Function f = Function::table({1, 3}, {2, 6}, cubic);
  EXPECT_DOUBLE_EQ(f.value(2), 4);
  EXPECT_DOUBLE_EQ(f.value(10), 20);
}

TEST(FunctionRepeated, WrapsRoundAPeriod) {
  const Function f =
      Function::table({0, 5, 15, 22, 22, 40}, {0, 0, 0.5, 0.5, 0.4, 0.4}, linear).repeated(0, 40);
  EXPECT_EQ(f.value(10), 0.25);
  for (const double x : {0.0, 3.0, 7.0, 21.0, 22.0, 39.0})
    for (const int turn : {-2, -1, 1, 2, 100})
      EXPECT_NEAR(f.value(x + 40 * turn), f.value(x), 1e-12) << x << " + 40·" << turn;
  EXPECT_EQ(f.value(-1), 0.4);
  EXPECT_EQ(f.value(40), 0);
  EXPECT_NEAR(f.derivative(50), 0.05, 1e-14);
}

TEST(FunctionRepeated, FromAnotherStart) {
  const Function f = Function::linear(1).repeated(-0.5, 1);
  EXPECT_DOUBLE_EQ(f.value(0.25), 0.25);
  EXPECT_DOUBLE_EQ(f.value(0.75), -0.25);
  EXPECT_DOUBLE_EQ(f.value(-0.75), 0.25);
}

TEST(FunctionRepeated, StaysInsideThePeriodInSpiteOfRounding) {
  const Function f = Function::linear(1).repeated(0.1, 0.3);
  std::mt19937 random(3);
  std::uniform_int_distribution<int> turns(-100000, 100000);
  for (int i = 0; i < 20000; ++i) {
    double x = 0.1 + 0.3 * turns(random);
    for (const double near : {x, std::nextafter(x, -1e9), std::nextafter(x, 1e9)}) {
      ASSERT_GE(f.value(near), 0.1);
      ASSERT_LT(f.value(near), 0.1 + 0.3);
    }
  }
}

TEST(FunctionRepeated, AntiderivativeAddsWholePeriods) {
  const Function f = Function::polynomial({1, 1}).repeated(-1, 3);  // 0 to 3 over [-1, 2): 4.5 in a period
  EXPECT_EQ(f.antiderivative(0), 0);
  EXPECT_DOUBLE_EQ(f.antiderivative(2), 4);
  EXPECT_DOUBLE_EQ(f.antiderivative(5), 4 + 4.5);
  EXPECT_DOUBLE_EQ(f.antiderivative(-1), -0.5);
  EXPECT_DOUBLE_EQ(f.antiderivative(-4), -5);
  for (const double x : {-3.3, 0.4, 7.9}) expect_consistent(f, x, 1e-8);
}

TEST(FunctionRepeated, BadRepetitionsAreRefused) {
  const Function f = Function::linear(1);
  EXPECT_THROW(f.repeated(0, 0), InputError);
  EXPECT_THROW(f.repeated(0, -1), InputError);
  EXPECT_THROW(f.repeated(0, std::nan("")), InputError);
  EXPECT_THROW(f.repeated(0, 1).repeated(0, 1), InputError);
  EXPECT_THROW(Function::expression("x", "x").repeated(0, 1), InputError);
}

TEST(FunctionExpression, HasTheUsualOperatorsAndFunctions) {
  const Function f = Function::expression("2*sin(pi*t)^2 + (t > 1 ? 10 : -abs(t)/4)", "t");
  EXPECT_DOUBLE_EQ(f.value(0.5), 2 - 0.125);
  EXPECT_NEAR(f.value(2), 10, 1e-12);
  EXPECT_DOUBLE_EQ(Function::expression("-2^2", "x").value(0), -4);
  EXPECT_DOUBLE_EQ(Function::expression("x >= 1 && x != 2", "x").value(1), 1);
  EXPECT_DOUBLE_EQ(Function::expression("max(x, 3) + exp(0)", "x").value(1), 4);
  EXPECT_EQ(Function::expression("5", "x").value(1), 5);
}

TEST(FunctionExpression, DerivativesMatchClosedForms) {
  const Function f = Function::expression("0.5*sin(2*pi*t)", "t");
  const double w = 2 * pi;
  for (double t = -3; t < 120; t += 0.173) {
    EXPECT_NEAR(f.derivative(t), 0.5 * w * std::cos(w * t), 1e-11) << t;
    EXPECT_NEAR(f.second_derivative(t), -0.5 * w * w * std::sin(w * t), 1e-10) << t;
  }
  const Function stiff = Function::expression("1e5*(x-0.25) + 3e7*(x-0.25)^3", "x");
  for (double x = 0.2; x < 0.3; x += 0.007) {
    const double s = x - 0.25;
    EXPECT_NEAR(stiff.derivative(x), 1e5 + 9e7 * s * s, 1e-14 * 1e5);
    EXPECT_NEAR(stiff.second_derivative(x), 18e7 * s, 1e-15 * 18e7);
  }
}

TEST(FunctionExpression, DerivativesSeeNarrowFeatures) {
  const Function friction = Function::expression("100*tanh(v/0.001)", "v");
  const double v = 0.0004, c = std::cosh(v / 0.001);
  EXPECT_NEAR(friction.derivative(v), 1e5 / (c * c), 1e-14 * 1e5);
  const Function kink = Function::expression("abs(x)", "x");
  EXPECT_NEAR(kink.derivative(1e-4), 1, 1e-9);
  EXPECT_NEAR(kink.derivative(-1e-4), -1, 1e-9);
  EXPECT_NEAR(Function::expression("sqrt(x)", "x").derivative(1e-3), 0.5 / std::sqrt(1e-3), 1e-14);
  EXPECT_NEAR(Function::expression("x^2", "x").derivative(1e8), 2e8, 1e-7);
}

TEST(FunctionExpression, AntiderivativeStartsAtZero) {
  const Function f = Function::expression("sin(2*pi*x)", "x");
  EXPECT_EQ(f.antiderivative(0), 0);
  for (const double x : {-2.3, -0.1, 0.4, 1.7, 5.1})
    EXPECT_NEAR(f.antiderivative(x), (1 - std::cos(2 * pi * x)) / (2 * pi), 1e-12);
  EXPECT_NEAR(Function::expression("x^19", "x").antiderivative(1.2), std::pow(1.2, 20) / 20, 1e-12);
  EXPECT_NEAR(Function::expression("x > 0.3 ? x - 0.3 : 0", "x").antiderivative(1), 0.245, 1e-4);
}

TEST(FunctionExpression, AntiderivativeStartsElsewhereWhereZeroIsAPole) {
  const Function f = Function::expression("1/x", "x");
  EXPECT_NEAR(f.antiderivative(2) - f.antiderivative(0.5), std::log(4), 1e-10);
}

TEST(FunctionExpression, FaultsAreNamed) {
  EXPECT_THAT(refusal("2*y"), HasSubstr("unknown name 'y'"));
  EXPECT_THAT(refusal("2*y"), HasSubstr("the variables here are: x"));
  EXPECT_THAT(refusal("sni(x)"), HasSubstr("did you mean 'sin'?"));
  EXPECT_THAT(refusal("length + q", {"l", "v", "t"}), HasSubstr("l, v, t"));
  EXPECT_THAT(refusal("2*(x+1"), HasSubstr("expression '2*(x+1'"));
  EXPECT_THAT(refusal("x = 3"), HasSubstr("write '=='"));
  EXPECT_THAT(refusal("x, 3"), HasSubstr("several values"));
  EXPECT_THAT(refusal("  "), HasSubstr("is empty"));
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("\"x\""), HasSubstr("quotes"));
  EXPECT_THAT(refusal("0/0"), HasSubstr("finite at none"));
  EXPECT_THAT(refusal("sqrt(-1-x^2)"), HasSubstr("finite at none"));
  EXPECT_THAT(refusal("log(-1-l^2)", {"l", "v", "t"}), HasSubstr("finite nowhere"));
  EXPECT_THAT(refusal(std::string("x\0+", 3)), HasSubstr("unexpected character"));
  EXPECT_THAT(refusal("x \xc2\xb7 2"), HasSubstr("unexpected character"));
}

TEST(FunctionExpression, HostileTextIsRefused) {
  EXPECT_THAT(refusal(std::string(20000, '1')), HasSubstr("20000 characters"));
  EXPECT_THAT(refusal(std::string(4000, '(') + "x" + std::string(4000, ')')), HasSubstr("nested"));
  std::string choices = "x";
  for (int i = 0; i < 1000; ++i) choices = "x?1:" + choices;
  EXPECT_THAT(refusal(choices), HasSubstr("nested"));
  for (const char* text :
       {"?",   ":", "x?", "x?1", ")",  "(",  "()",      "sin",  "sin()",    "sin(,)", "sum()", "1..2",
        "x x", "^", "--", "x:1", "1e", "&&", "x?1:2:3", "_pi_", "sin(x,x)", "5 5",    ",",     "pi=3=="})
    EXPECT_NE(refusal(text), "accepted") << text;
}

TEST(FunctionExpression, RandomTextIsRefusedOrWorks) {
  const std::vector<std::string> tokens{"x",  "1", "2.5e3", "+",  "-",   "*",    "/",      "^",    "(",
                                        ")",  "?", ":",     ",",  "sin", "sin(", "max(",   "min(", "&&",
                                        "||", "<", "==",    "!=", " ",   "pi",   "atan2(", "sum("};
  std::mt19937 random(11);
  std::uniform_int_distribution<std::size_t> pick(0, tokens.size() - 1), length(1, 14);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::size_t n = length(random); n > 0; --n) text += tokens[pick(random)];
    try {
      const Function f = Function::expression(text, "x");
      f.value(0.3);
      f.derivative(0.3);
      ++accepted;
    } catch (const InputError&) {
      continue;
    }
  }
  EXPECT_GT(accepted, 100);
}

TEST(FunctionExpression, LongSumsAndDeepButAllowedNestingWork) {
  std::string sum = "x";
  while (sum.size() < 9990) sum += "+x";
  EXPECT_NEAR(Function::expression(sum, "x").value(1), static_cast<double>((sum.size() + 1) / 2), 1e-9);
  const std::string nested = std::string(99, '(') + "x" + std::string(99, ')');
  EXPECT_EQ(Function::expression(nested, "x").value(2), 2);
}

TEST(FunctionExpression, NotFiniteValuesGoThrough) {
  const Function f = Function::expression("1/x", "x");
  EXPECT_TRUE(std::isinf(f.value(0)));
  EXPECT_TRUE(std::isnan(Function::expression("sqrt(x)", "x").value(-1)));
}

TEST(FunctionExpression, ThreadsShareIt) {
  const Function f = Function::expression("x*x + 1", "x");
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (std::size_t id = 0; id < wrong.size(); ++id)
    threads.emplace_back([&, id] {
      for (int i = 0; i < 20000; ++i) {
        const double x = static_cast<double>(id) + i;
        if (f.value(x) != x * x + 1) ++wrong[id];
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(wrong, testing::Each(0));
}

TEST(Formula, DefaultIsZero) {
  const Formula f;
  EXPECT_TRUE(f.is_zero());
  EXPECT_EQ(f.value(std::array{1.0, 2.0, 3.0}.data()), 0);
  EXPECT_EQ(f.derivatives(std::array{1.0, 2.0, 3.0}.data()), std::make_pair(0.0, 0.0));
}

TEST(Formula, MatchesItsClosedForm) {
  const Formula f = Formula::expression("1000*(l-0.5) + 10*v*abs(v)*cos(t)", {"l", "v", "t"});
  EXPECT_FALSE(f.is_zero());
  EXPECT_DOUBLE_EQ(f.value(std::array{0.7, -2.0, 0.3}.data()), 200 - 40 * std::cos(0.3));
  const auto [by_length, by_rate] = f.derivatives(std::array{0.7, -2.0, 0.3}.data());
  EXPECT_NEAR(by_length, 1000, 1e-7);
  EXPECT_NEAR(by_rate, 40 * std::cos(0.3), 1e-8);
}

TEST(Formula, MayHaveFewerVariables) {
  const Formula f = Formula::expression("l^2", {"l"});
  EXPECT_DOUBLE_EQ(f.value(std::array{3.0, 100.0, 100.0}.data()), 9);
}

/// The branch that is not taken counts for nothing: neither its value nor what it does beside x.
TEST(FunctionExpression, OnlyTheBranchTakenCounts) {
  const Function zero_ramp = Function::expression("t < 0 ? t^2/0 : 0.6*t", "t");
  EXPECT_EQ(zero_ramp.value(0), 0);
  EXPECT_NEAR(zero_ramp.derivative(0), 0.6, 1e-12);
  EXPECT_NEAR(zero_ramp.second_derivative(0), 0, 1e-9);
  EXPECT_NEAR(zero_ramp.antiderivative(2), 1.2, 1e-12);
  // At a switch: the side that is taken there.
  const Function kink =
      Function::expression("2 + (x < 1 ? 3*x : x^2 > 4 ? 7 : 5*x)*max(1, x<0 ? 2 : 1)", "x");
  EXPECT_NEAR(kink.derivative(1), 5, 1e-9);
  EXPECT_NEAR(kink.derivative(1 - 1e-12), 3, 1e-9);
  EXPECT_NEAR(kink.derivative(2), 5, 1e-9);
  EXPECT_NEAR(kink.derivative(3), 0, 1e-9);
  EXPECT_NEAR(kink.derivative(-1), 6, 1e-9);
  // A choice within a condition, and a condition of several parts.
  const Function nested = Function::expression("((x > 0 ? 1 : 0) && x < 2 ? x^3 : -x)", "x");
  EXPECT_NEAR(nested.derivative(2 - 1e-9), 12, 1e-6);
  EXPECT_NEAR(nested.derivative(2), -1, 1e-9);
  // A branch that ends where it is taken: from inside.
  EXPECT_TRUE(std::isfinite(Function::expression("x < 1 ? sqrt(1-x) : 0", "x").derivative(1 - 1e-6)));
  // In several variables.
  const Formula f = Formula::expression("l > 1 ? 0/0*v : 4*l + (v < 0 ? 1/0 : 3*v)", {"l", "v", "t"});
  EXPECT_NEAR(f.derivatives(std::array{1.0, 0.0, 0.0}.data()).first, 4, 1e-9);
  EXPECT_NEAR(f.derivatives(std::array{1.0, 0.0, 0.0}.data()).second, 3, 1e-9);
}

TEST(FunctionExpression, ManyChoicesGoTheirWay) {
  std::string text;
  for (int k = 0; k < 90; ++k) text += "(x<" + std::to_string(k) + "?0:1)+";
  const Function steps = Function::expression(text + "x", "x");
  EXPECT_EQ(steps.value(49.5), 50 + 49.5);
  EXPECT_NEAR(steps.derivative(49.5), 1, 1e-9);
}

}  // namespace
}  // namespace mimbre::function_test
