#include <gtest/gtest.h>

#include <random>

#include "math/function_values.h"
#include "math/rotation.h"

/// Packs of lanes and dual numbers: their arithmetic, and functions, formulas and rotations of them.
namespace mimbre::test::scalars_test {
namespace {

using Lanes = Pack<4>;

Lanes any_pack(std::mt19937& random, double from, double to) {
  std::uniform_real_distribution<double> any(from, to);
  Lanes x;
  for (int i = 0; i < 4; ++i) x[i] = any(random);
  return x;
}

/// Lane by lane what a generic function gives for numbers.
template <class F>
void expect_lanes(const F& f, const Lanes& x, const Lanes& y) {
  const Lanes of = f(x, y);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(of[i], f(x[i], y[i])) << "lane " << i;
}

/// The derivative of a generic function along (dx, dy), by Richardson's extrapolation of differences.
template <class F>
void expect_derivative(const F& f, double x, double y, double dx, double dy, double tolerance = 1e-9) {
  const auto difference = [&](double h) {
    return (f(x + h * dx, y + h * dy) - f(x - h * dx, y - h * dy)) / (2 * h);
  };
  const double h = 2e-3, rough = difference(h), fine = difference(h / 2), finest = difference(h / 4);
  const double better = (4 * fine - rough) / 3, best = (4 * finest - fine) / 3;
  const double expected = (16 * best - better) / 15;
  const Dual of = f(Dual(x, dx), Dual(y, dy));
  EXPECT_EQ(of.value, f(x, y));
  EXPECT_NEAR(of.derivative, expected, tolerance * (1 + std::abs(expected))) << "at " << x << ", " << y;
}

const auto arithmetic = [](const auto& x, const auto& y) {
  auto z = x * y - x / (2.0 + y * y) + -y;
  z += x;
  z *= 1.5;
  z -= y;
  z /= 0.5 + x * x;
  return z;
};
const auto functions = [](const auto& x, const auto& y) {
  using std::abs, std::sqrt, mimbre::atan2, mimbre::cos, mimbre::exp, mimbre::expm1, mimbre::hypot,
      mimbre::log, mimbre::pow, mimbre::sin;
  return sqrt(1.0 + x * x) + sin(x) * cos(y) + exp(x) * expm1(y) + log(2.0 + x * y) + abs(x) + atan2(x, y) +
         hypot(x, y) + pow(2.0 + x, y) + pow(2.0 + y, 3.0);
};

TEST(Scalars, LanesAreNumbers) {
  std::mt19937 random(1);
  for (int k = 0; k < 100; ++k) {
    const Lanes x = any_pack(random, -1, 1), y = any_pack(random, -1, 1);
    expect_lanes([](const auto& a, const auto& b) { return a + b; }, x, y);
    expect_lanes([](const auto& a, const auto& b) { return a * b; }, x, y);
    expect_lanes([](const auto& a, const auto& b) { return a - b; }, x, y);
    expect_lanes([](const auto& a, const auto& b) { return a / b; }, x, y);
    expect_lanes([](const auto& a, const auto& b) { return select(a < b, a, b); }, x, y);
    expect_lanes(
        [](const auto& a, const auto&) {
          using std::round;
          return round(5.0 * a);
        },
        x, y);
    const Lanes of = arithmetic(x, y), values = functions(x, y);
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(of[i], arithmetic(x[i], y[i]), 1e-13 * (1 + std::abs(of[i])));
      EXPECT_NEAR(values[i], functions(x[i], y[i]), 1e-14 * (1 + std::abs(values[i])));
    }
  }
}

TEST(Scalars, LanesChooseForThemselves) {
  Lanes x(0);
  x[0] = -1, x[1] = 2, x[3] = -3;
  const Lanes y = choose(
      x < Lanes(0), [&] { return -x; }, [&] { return 10.0 * x; });
  EXPECT_EQ(y[0], 1);
  EXPECT_EQ(y[1], 20);
  EXPECT_EQ(y[2], 0);
  EXPECT_EQ(y[3], 3);
  EXPECT_TRUE(any(x < Lanes(0)));
  EXPECT_FALSE(all(x < Lanes(0)));
  EXPECT_TRUE(all(x < Lanes(0) || x >= Lanes(0)));
  EXPECT_FALSE(any(x < Lanes(0) && x >= Lanes(0)));
  EXPECT_FALSE(all(isfinite(Lanes(1) / x)));
}

TEST(Scalars, DerivativesOfArithmeticAndFunctions) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(0.1, 1), sign(-1, 1);
  for (int k = 0; k < 100; ++k) {
    const double x = any(random), y = any(random), dx = sign(random), dy = sign(random);
    expect_derivative(arithmetic, x, y, dx, dy, 1e-8);
    expect_derivative(functions, x, y, 0.1 * dx, 0.1 * dy);
  }
  // What does not vary has no derivative, even where the slope is infinite.
  EXPECT_EQ(sqrt(Dual(0, 0)).derivative, 0);
  EXPECT_EQ(hypot(Dual(0, 0), Dual(0, 0)).derivative, 0);
}

TEST(Scalars, FunctionsOfLanesAndTheirDerivatives) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  const std::vector<Function> all{
      Function::polynomial({1, -2, 0.5, 3}), Function::expression("sin(3*x) + x^2/(2 + x)", "x"),
      Function::table({-2, -0.9, 0.1, 2}, {1, 3, -1, 0.5}, Function::Interpolation::cubic), Function()};
  for (const Function& function : all)
    for (int k = 0; k < 20; ++k) {
      const FunctionData& f = function.data();
      const Lanes x = any_pack(random, -0.8, 0);
      const Lanes value = value_at(f, x);
      const auto [same, slope] = tangent_at(f, x);
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(value[i], f.value(x[i]));
        EXPECT_EQ(same[i], f.tangent(x[i]).first);
        EXPECT_EQ(slope[i], f.tangent(x[i]).second);
        const Dual at(x[i], any(random));
        const Jet jet = f.jet(x[i]);
        EXPECT_EQ(value_at(f, at).derivative, jet.first * at.derivative);
        EXPECT_EQ(tangent_at(f, at).second.derivative, jet.second * at.derivative);
      }
    }
}

TEST(Scalars, FormulasOfLanesAndTheirDerivatives) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1, 1);
  const Expression f("sin(x*y) + x^2*z - exp(y)*z + (x > z ? x*y*z : atan2(x, 2 + y))", {"x", "y", "z"});
  const auto generic = [&](const std::array<double, 3>& x) { return f.value(x.data()); };
  for (int k = 0; k < 100; ++k) {
    std::array<Lanes, 3> lanes;
    for (Lanes& x : lanes) x = any_pack(random, -1, 1);
    const Lanes value = value_at(f, lanes.data());
    const auto slopes = derivatives_at(f, lanes.data());
    for (int i = 0; i < 4; ++i) {
      const std::array<double, 3> x{lanes[0][i], lanes[1][i], lanes[2][i]};
      EXPECT_EQ(value[i], generic(x));
      EXPECT_EQ(slopes.first[i], f.derivatives(x.data()).first);
      EXPECT_EQ(slopes.second[i], f.derivatives(x.data()).second);
    }
    // Along a parameter that moves the variables and the rates of the variables.
    std::array<double, 3> at, by, first, first_by, second, second_by;
    for (std::size_t j = 0; j < 3; ++j) {
      at[j] = any(random), by[j] = any(random), first[j] = 100 * any(random), first_by[j] = any(random);
      second[j] = any(random), second_by[j] = any(random);
    }
    if (std::abs(at[0] - at[2]) < 0.05) continue;  // the formula jumps
    const auto parts = [&](double s) {
      std::array<double, 3> x;
      std::array<Jet, 3> jets, held, moving;  // of held ones the rates begin
      std::array<Gradient, 3> gradients;
      for (std::size_t j = 0; j < 3; ++j) {
        x[j] = at[j] + s * by[j];
        jets[j] = {x[j], first[j] + s * first_by[j], 0};
        held[j] = {x[j], s * first_by[j], second[j] + s * second_by[j]};
        moving[j] = {x[j], 0.01 * first[j] + s * first_by[j], second[j] + s * second_by[j]};
        gradients[j] = {x[j], first[j] + s * first_by[j], second[j]};
      }
      const auto [d0, d1] = f.derivatives(x.data());
      const Gradient g = f.gradient(gradients.data());
      Eigen::Vector<double, 8> all;
      all << f.value(x.data()), d0, d1, f.jet(jets.data()).first, g.by_first, g.by_second,
          f.jet(held.data()).second, f.jet(moving.data()).second;
      return all;
    };
    const auto difference = [&](double h) -> Eigen::Vector<double, 8> {
      return (parts(h) - parts(-h)) / (2 * h);
    };
    const Eigen::Vector<double, 8> expected =
        (64 * difference(2.5e-3) - 20 * difference(5e-3) + difference(1e-2)) / 45;
    std::array<Dual, 3> x;
    std::array<JetOf<Dual>, 3> jets, held, moving;
    std::array<GradientOf<Dual>, 3> gradients;
    for (std::size_t j = 0; j < 3; ++j) {
      x[j] = {at[j], by[j]};
      jets[j] = {x[j], {first[j], first_by[j]}, 0.0};
      held[j] = {x[j], {0, first_by[j]}, {second[j], second_by[j]}};
      moving[j] = {x[j], {0.01 * first[j], first_by[j]}, {second[j], second_by[j]}};
      gradients[j] = {x[j], {first[j], first_by[j]}, second[j]};
    }
    const auto [d0, d1] = derivatives_at(f, x.data());
    const GradientOf<Dual> g = gradient_at<Dual>(f, gradients.data());
    const Dual found[] = {value_at(f, x.data()),
                          d0,
                          d1,
                          jet_at<Dual>(f, jets.data()).first,
                          g.by_first,
                          g.by_second,
                          jet_at<Dual>(f, held.data()).second,
                          jet_at<Dual>(f, moving.data()).second};
    for (int j = 0; j < 8; ++j)
      EXPECT_NEAR(found[j].derivative, expected[j], 1e-9 * (1 + expected.cwiseAbs().maxCoeff())) << j;
  }
}

/// Rotations far and near, of lanes that are both.
TEST(Scalars, RotationsOfLanesAndTheirDerivatives) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int k = 0; k < 200; ++k) {
    std::array<Vec3<double>, 4> each;
    Vec3<Lanes> theta;
    for (int i = 0; i < 4; ++i) {
      const double size = std::array{1.0, 0.2, 1e-5, 0.0}[static_cast<std::size_t>((i + k) % 4)];
      each[static_cast<std::size_t>(i)] = size * Vec3<double>(any(random), any(random), any(random));
      for (int c = 0; c < 3; ++c) theta[c][i] = each[static_cast<std::size_t>(i)][c];
    }
    const Mat3<Lanes> R = rotation_exp<Lanes>(theta), J = left_jacobian<Lanes>(theta);
    const Vec3<Lanes> back = quaternion_log<Lanes>(quaternion_of(R));
    for (int i = 0; i < 4; ++i) {
      const Vec3<double>& x = each[static_cast<std::size_t>(i)];
      const Mat3<double> one = rotation_exp<double>(x), jacobian = left_jacobian<double>(x);
      for (int c = 0; c < 9; ++c) {
        EXPECT_NEAR(R(c)[i], one(c), 1e-15);
        EXPECT_NEAR(J(c)[i], jacobian(c), 1e-15);
      }
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[c][i], x[c], 1e-15);
      // exp and log are inverse in their derivatives too, and d exp = (J dx)~ exp.
      const Vec3<double> by(any(random), any(random), any(random));
      Vec3<Dual> dual;
      for (int c = 0; c < 3; ++c) dual[c] = {x[c], by[c]};
      const Mat3<Dual> turned = rotation_exp<Dual>(dual);
      const Mat3<double> rate = skew<double>(jacobian * by) * one;
      for (int c = 0; c < 9; ++c) EXPECT_NEAR(turned(c).derivative, rate(c), 1e-14);
      const Vec3<Dual> of = quaternion_log<Dual>(quaternion_of(turned));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(of[c].derivative, by[c], 1e-9);
    }
  }
}

}  // namespace
}  // namespace mimbre::test::scalars_test
