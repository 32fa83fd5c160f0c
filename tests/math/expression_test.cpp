#include "math/function_expression.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>
#include <thread>

/// Formulas as programs: grammar, exact derivatives, threads.
namespace mimbre::expression_test {
namespace {

using testing::HasSubstr;
using Real = long double;
using Exact = std::function<Real(Real)>;

double constant(const std::string& text) { return Expression(text, {}).value(nullptr); }
Jet at(const Expression& e, double x) {
  const Jet of{x, 1, 0};
  return e.jet(&of);
}

double value_at(const Expression& e, double x) { return e.value(&x); }

TEST(Expression, BindsAsInMathematics) {
  const std::pair<const char*, double> rows[] = {{"-2^2", -4},
                                                 {"2^-1", 0.5},
                                                 {"2^3^2", 512},
                                                 {"2^-3^2", 1.0 / 512},
                                                 {"-3*2^2", -12},
                                                 {"2-+3", -1},
                                                 {"2*-3", -6},
                                                 {"2 - 3 - 4", -5},
                                                 {"12 / 3 / 2", 2},
                                                 {"1 + 2*3 - 4/2", 5},
                                                 {"1 < 2 == 1", 1},
                                                 {"1 + 1 > 1 && 0 || 1", 1},
                                                 {"0 && 0 || 1", 1},
                                                 {"1 || 0 && 0", 1},
                                                 {"3 != 3", 0},
                                                 {"2 >= 2", 1},
                                                 {"1 ? 2 : 0 ? 3 : 4", 2},
                                                 {"0 ? 2 : 0 ? 3 : 4", 4},
                                                 {"(0 ? 1 : 2) * 3", 6},
                                                 {"-(1 ? 1 : 2)", -1},
                                                 {"(1 ? 3 : 2)^2", 9},
                                                 {"rint(2.5) + 10*rint(-2.5) + 100*rint(3.5)", 382},
                                                 {"rint(-1.5) + 10*rint(-1.4)", -12},
                                                 {"rint(0.49999999999999994)", 0},
                                                 {"rint(4503599627370497)", 4503599627370497},
                                                 {"sign(-3) + sign(0)", -1},
                                                 {"min(3, 1, 2) + 10*max(3, 1, 2)", 31},
                                                 {"sum(1, 2, 3) + 10*avg(1, 2)", 21},
                                                 {"log2(8) + log10(100)", 5},
                                                 {"5. + .5 + 1e1", 15.5},
                                                 {"\t1\n+ 2 ", 3}};
  for (const auto& [text, value] : rows) EXPECT_EQ(constant(text), value) << text;
  EXPECT_EQ(constant("log(10)"), std::log(10.0));
  EXPECT_EQ(constant("ln(_e) + cos(pi) + sin(_pi/2)"), 1);
  EXPECT_EQ(constant("atan2(1, -2)"), std::atan2(1.0, -2.0));
}

TEST(Expression, SaysWhatIsWrong) {
  const auto refusal = [](const std::string& text) {
    try {
      const Expression e(text, {"x"});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal("1 +"), HasSubstr("ends where a value is needed"));
  EXPECT_THAT(refusal("(1"), HasSubstr("a ')' is missing"));
  EXPECT_THAT(refusal("1)"), HasSubstr("the ')' at position 2 closes nothing"));
  EXPECT_THAT(refusal("2 x"), HasSubstr("an operator is missing before 'x' at position 3"));
  EXPECT_THAT(refusal("sin x"), HasSubstr("'sin' at position 1 has no '('"));
  EXPECT_THAT(refusal("sinn(x)"), HasSubstr("did you mean 'sin'"));
  EXPECT_THAT(refusal("atan2(x)"), HasSubstr("'atan2' has 1 argument; it takes 2"));
  EXPECT_THAT(refusal("min()"), HasSubstr("it takes one or more"));
  EXPECT_THAT(refusal("x, 2"), HasSubstr("several values"));
  EXPECT_THAT(refusal("x ? 1"), HasSubstr("no ':'"));
  EXPECT_THAT(refusal("x = 1"), HasSubstr("write '=='"));
  EXPECT_THAT(refusal("* 2"), HasSubstr("'*' at position 1"));
  EXPECT_THAT(refusal("1e999"), HasSubstr("too large"));
  EXPECT_THAT(refusal("y"), HasSubstr("the variables here are: x"));
  for (const char* unit : {"-", "2^", "+", "x?", "sin(", "1+("}) {
    std::string text;
    for (int k = 0; k < 3000; ++k) text += unit;
    EXPECT_THAT(refusal(text + "x"), testing::AnyOf(HasSubstr("nested deeper"), HasSubstr("characters")))
        << unit;
  }
  std::string wide = "x";
  for (int k = 0; k < 90; ++k) wide = "x+(1*(" + wide + "^x))";
  EXPECT_THAT(refusal(wide), testing::AnyOf(HasSubstr("nested"), HasSubstr("values at a time")));
}

/// f' and f'' by differences in long double: errors about 1e-14 and 1e-12 of functions that vary over 1.
Jet by_differences(const Exact& f, Real x) {
  const Real h = 2e-3L;
  const Real a = f(x - 3 * h), b = f(x - 2 * h), c = f(x - h), m = f(x), d = f(x + h), e = f(x + 2 * h),
             g = f(x + 3 * h);
  return {
      static_cast<double>(m), static_cast<double>((-a + 9 * b - 45 * c + 45 * d - 9 * e + g) / (60 * h)),
      static_cast<double>((2 * a - 27 * b + 270 * c - 490 * m + 270 * d - 27 * e + 2 * g) / (180 * h * h))};
}

void expect_near(const Jet& a, const Jet& b, double tolerance, const std::string& what) {
  const double size = 1 + std::abs(b.value) + std::abs(b.first) + std::abs(b.second);
  EXPECT_NEAR(a.value, b.value, 1e-13 * size) << what;
  EXPECT_NEAR(a.first, b.first, tolerance * size) << what;
  EXPECT_NEAR(a.second, b.second, tolerance * size) << what;
}

TEST(Expression, DerivativesOfEveryFunctionAreExact) {
  struct Row {
    const char* text;
    Exact f;
    std::vector<double> places;
  };
  const Real ln2 = std::numbers::ln2_v<Real>, ln10 = std::numbers::ln10_v<Real>;
  const Row rows[] = {
      {"sin(x)", [](Real x) { return std::sin(x); }, {-2, 0, 0.7}},
      {"cos(x)", [](Real x) { return std::cos(x); }, {-2, 0, 0.7}},
      {"tan(x)", [](Real x) { return std::tan(x); }, {-0.8, 0, 0.7}},
      {"asin(x)", [](Real x) { return std::asin(x); }, {-0.5, 0, 0.6}},
      {"acos(x)", [](Real x) { return std::acos(x); }, {-0.5, 0, 0.6}},
      {"atan(x)", [](Real x) { return std::atan(x); }, {-3, 0, 0.6}},
      {"sinh(x)", [](Real x) { return std::sinh(x); }, {-2, 0, 0.6}},
      {"cosh(x)", [](Real x) { return std::cosh(x); }, {-2, 0, 0.6}},
      {"tanh(x)", [](Real x) { return std::tanh(x); }, {-2, 0, 0.6}},
      {"asinh(x)", [](Real x) { return std::asinh(x); }, {-2, 0, 0.6}},
      {"acosh(x)", [](Real x) { return std::acosh(x); }, {1.5, 4}},
      {"atanh(x)", [](Real x) { return std::atanh(x); }, {-0.5, 0, 0.3}},
      {"log2(x)", [=](Real x) { return std::log(x) / ln2; }, {0.5, 3}},
      {"log10(x)", [=](Real x) { return std::log(x) / ln10; }, {0.5, 3}},
      {"ln(x)", [](Real x) { return std::log(x); }, {0.5, 3}},
      {"exp(x)", [](Real x) { return std::exp(x); }, {-2, 0, 2}},
      {"sqrt(x)", [](Real x) { return std::sqrt(x); }, {0.5, 3}},
      {"abs(x)", [](Real x) { return std::abs(x); }, {-2, 3}},
      {"sign(x)*x", [](Real x) { return std::abs(x); }, {-2, 3}},
      {"rint(x)", [](Real x) { return std::rint(x); }, {-2, -1.6, 3.3}},
      {"x^2", [](Real x) { return x * x; }, {-2, 0, 3}},
      {"x^3", [](Real x) { return x * x * x; }, {-2, 0, 3}},
      {"x^4", [](Real x) { return x * x * x * x; }, {-2, 0, 3}},
      {"x^5", [](Real x) { return std::pow(x, Real(5)); }, {-2, 0, 1.5}},
      {"x^1", [](Real x) { return x; }, {-2, 0, 3}},
      {"x^0", [](Real) { return Real(1); }, {-2, 0, 3}},
      {"x^-1.5", [](Real x) { return std::pow(x, Real(-1.5)); }, {0.6, 3}},
      {"2^x", [](Real x) { return std::pow(Real(2), x); }, {-2, 0, 3}},
      {"x^x", [](Real x) { return std::pow(x, x); }, {0.5, 2}},
      {"atan2(x, 2 - x^2)", [](Real x) { return std::atan2(x, 2 - x * x); }, {-3, 0, 0.6}},
      {"min(x, x^2, 3)",
       [](Real x) {
         return std::min({x, x * x, Real(3)});
       },
       {-2, 0.5, 1.5, 4}},
      {"max(x, x^2)", [](Real x) { return std::max(x, x * x); }, {-2, 0.5, 1.5}},
      {"avg(x, x^3)", [](Real x) { return (x + x * x * x) / 2; }, {-2, 0.5}},
      {"x/(1 + x^2)", [](Real x) { return x / (1 + x * x); }, {-2, 0, 0.5}},
      {"x > 1 ? x^3 : sin(x)", [](Real x) { return x > 1 ? x * x * x : std::sin(x); }, {0.5, 1.5}},
  };
  for (const Row& row : rows)
    for (const double x : row.places)
      expect_near(at(Expression(row.text, {"x"}), x), by_differences(row.f, x), 1e-11,
                  row.text + (" at " + std::to_string(x)));
}

TEST(Expression, KinksHaveTheMeanSlopeAndSteepPlacesNoneWhereNothingMoves) {
  EXPECT_EQ(at(Expression("abs(x)", {"x"}), 0).first, 0);
  EXPECT_EQ(at(Expression("max(0, x)", {"x"}), 0).first, 0.5);
  EXPECT_EQ(at(Expression("sqrt(x^2)", {"x"}), 0).first, 0);
  EXPECT_EQ(at(Expression("x^2*ln(2)", {"x"}), 0).second, 2 * std::log(2));
}

/// A random formula as text and as a function of the long number.
struct Random {
  std::string text;
  Exact f;
};
Random random_formula(std::mt19937& random, int depth) {
  const auto pick = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  if (depth == 0) {
    if (pick(2) == 0) return {"x", [](Real x) { return x; }};
    const int tenths = 1 + pick(30);
    return {std::to_string(tenths) + "/10", [=](Real) { return static_cast<Real>(tenths) / 10; }};
  }
  const Random a = random_formula(random, depth - 1), b = random_formula(random, depth - 1);
  switch (pick(9)) {
    case 0:
      return {"(" + a.text + "+(" + b.text + "))", [=](Real x) { return a.f(x) + b.f(x); }};
    case 1:
      return {"(" + a.text + "-(" + b.text + "))", [=](Real x) { return a.f(x) - b.f(x); }};
    case 2:
      return {"(" + a.text + ")*(" + b.text + ")", [=](Real x) { return a.f(x) * b.f(x); }};
    case 3:
      return {"(" + a.text + ")/(2+sin(" + b.text + "))",
              [=](Real x) { return a.f(x) / (2 + std::sin(b.f(x))); }};
    case 4:
      return {"sin(" + a.text + ")", [=](Real x) { return std::sin(a.f(x)); }};
    case 5:
      return {"exp(-(" + a.text + ")^2)", [=](Real x) { return std::exp(-a.f(x) * a.f(x)); }};
    case 6:
      return {"-atan(" + a.text + ")^3", [=](Real x) { return -std::pow(std::atan(a.f(x)), Real(3)); }};
    case 7:
      return {"(x > 7 ? " + a.text + " : " + b.text + ")", [=](Real x) { return x > 7 ? a.f(x) : b.f(x); }};
    default:
      return {"sqrt(1+(" + a.text + ")^2)^(1.2+tanh(" + b.text + "))",
              [=](Real x) { return std::pow(std::sqrt(1 + a.f(x) * a.f(x)), 1.2L + std::tanh(b.f(x))); }};
  }
}

TEST(Expression, RandomFormulasAndTheirDerivatives) {
  std::mt19937 random(7);
  int judged = 0;
  for (int k = 0; k < 400; ++k) {
    const Random r = random_formula(random, 1 + k % 4);
    const double x = 0.1 + 0.001 * static_cast<double>(random() % 2000);
    const Jet wanted = by_differences(r.f, x);
    // Where it varies too fast for differences there is nothing to compare with.
    if (!(std::abs(wanted.second) < 1e3 * (1 + std::abs(wanted.value)))) continue;
    ++judged;
    expect_near(at(Expression(r.text, {"x"}), x), wanted, 1e-8, r.text);
  }
  EXPECT_GT(judged, 350);
}

TEST(Expression, GradientsAreThoseOfOneVariableAtATime) {
  const Expression f("x^2*sin(v) + atan2(x, v)*t + max(x, v)^1.5", {"x", "v", "t"});
  const Expression by_x("x^2*sin(0.7) + atan2(x, 0.7)*3 + max(x, 0.7)^1.5", {"x"}),
      by_v("1.3^2*sin(v) + atan2(1.3, v)*3 + max(1.3, v)^1.5", {"v"});
  const Gradient g =
      f.gradient(std::array{Gradient{1.3, 1, 0}, Gradient{0.7, 0, 1}, Gradient{3.0, 0, 0}}.data());
  EXPECT_DOUBLE_EQ(g.value, f.value(std::array{1.3, 0.7, 3.0}.data()));
  EXPECT_DOUBLE_EQ(g.by_first, at(by_x, 1.3).first);
  EXPECT_DOUBLE_EQ(g.by_second, at(by_v, 0.7).first);
}

TEST(Expression, ThreadsShareIt) {
  const Expression f("sin(x)*exp(-x/3) + (x > 2 ? x^2 : sqrt(1 + x))", {"x"});
  std::vector<double> sums(8);
  std::vector<std::thread> threads;
  for (double& sum : sums)
    threads.emplace_back([&f, &sum] {
      for (int k = 0; k < 20000; ++k) sum += at(f, 1e-3 * (k % 5000)).first + value_at(f, 1e-4 * k);
    });
  for (std::thread& thread : threads) thread.join();
  for (const double sum : sums) EXPECT_EQ(sum, sums.front());
}

}  // namespace
}  // namespace mimbre::expression_test
