#include "support/brush.h"

#include <gtest/gtest.h>

#include <random>

/// The brush tyre against a row of bristles, one by one.
namespace mimbre::brush_test {
namespace {

using namespace forces;

struct Sum {
  double Fx = 0, Fy = 0, Mz = 0;
};

/// Bristles from the leading edge on: each is drawn along by the road and lets go where its force is more
/// than friction under the pressure of its place. What slides pulls against the direction that it slides in,
/// which is found by bisection of how far it slides.
Sum bristles(const BrushInput<double>& in, int count) {
  Sum sum;
  const double cx = in.Cx / (2 * in.a * in.a), cy = in.Cy / (2 * in.a * in.a), dx = 2 * in.a / count;
  double ux = 0, uy = 0;  // deflections, m
  for (int k = 0; k < count; ++k) {
    const double x = in.a - (k + 0.5) * dx;
    const double most = in.mu * 0.75 * in.Fz / in.a * (1 - x * x / (in.a * in.a));  // N/m
    ux += in.sigma_x * (k == 0 ? 0.5 : 1) * dx;
    uy += in.sigma_y * (k == 0 ? 0.5 : 1) * dx;
    double fx = cx * ux, fy = cy * uy;
    if (std::hypot(fx, fy) > most) {
      // u = trial − γ f/|f| with |f| = most.
      const auto force_after = [&](double slid) {
        return std::hypot(cx * ux / (1 + slid * cx / most), cy * uy / (1 + slid * cy / most));
      };
      double low = 0, high = 1;
      while (force_after(high) > most) high *= 2;
      for (int i = 0; i < 60; ++i) (force_after((low + high) / 2) > most ? low : high) = (low + high) / 2;
      ux /= 1 + high * cx / most;
      uy /= 1 + high * cy / most;
      fx = cx * ux;
      fy = cy * uy;
    }
    sum.Fx += fx * dx;
    sum.Fy += fy * dx;
    sum.Mz += x * fy * dx;
  }
  return sum;
}

TEST(Brush, IsTheSumOfItsBristles) {
  for (const double sx : {-0.4, -0.05, 0.0, 0.02})
    for (const double sy : {-0.3, -0.06, 0.0, 0.03, 0.1}) {
      const BrushInput<double> in{
          .Fz = 3000, .sigma_x = sx, .sigma_y = sy, .Cx = 8e4, .Cy = 8e4, .mu = 0.9, .a = 0.06};
      const BrushOutput<double> out = brush(in);
      const Sum sum = bristles(in, 4000);
      EXPECT_NEAR(out.Fx, sum.Fx, 1e-5 * 2700) << sx << " " << sy;
      EXPECT_NEAR(out.Fy, sum.Fy, 1e-5 * 2700) << sx << " " << sy;
      EXPECT_NEAR(out.Mz, sum.Mz, 1e-5 * 2700 * 0.06) << sx << " " << sy;
    }
}

/// Bristles that are stiffer along than across turn while they begin to slide, which the closed form leaves
/// out.
TEST(Brush, IsNearlyTheSumOfUnequalBristles) {
  double worst = 0;
  for (const double sx : {-0.3, -0.1, -0.03, 0.02, 0.1})
    for (const double sy : {-0.3, -0.06, 0.03, 0.1}) {
      const BrushInput<double> in{
          .Fz = 3000, .sigma_x = sx, .sigma_y = sy, .Cx = 1e5, .Cy = 8e4, .mu = 0.9, .a = 0.06};
      const BrushOutput<double> out = brush(in);
      const Sum sum = bristles(in, 4000);
      worst = std::max({worst, std::abs(out.Fx - sum.Fx) / 2700, std::abs(out.Fy - sum.Fy) / 2700});
    }
  EXPECT_LT(worst, 0.03);
  RecordProperty("worst_by_grip", std::to_string(worst));
}

/// Where it turns to full sliding: |s| = 3 μ Fz; then friction against the slip and no moment.
TEST(Brush, SlidesWhereItMust) {
  const double C = 8e4, grip = 0.9 * 3000, full = 3 * grip / C;
  const auto at = [&](double size) {
    return brush(BrushInput<double>{
        .Fz = 3000, .sigma_x = 0.6 * size, .sigma_y = -0.8 * size, .Cx = C, .Cy = C, .mu = 0.9, .a = 0.06});
  };
  EXPECT_LT(std::hypot(at(0.99 * full).Fx, at(0.99 * full).Fy), grip);
  for (const double size : {full, 2 * full, 100.0}) {
    EXPECT_NEAR(at(size).Fx, 0.6 * grip, 1e-9);
    EXPECT_NEAR(at(size).Fy, -0.8 * grip, 1e-9);
    EXPECT_NEAR(at(size).Mz, 0, 1e-9);
  }
  // The trail is a third of the half length where the tyre hardly slips: the deflection grows linearly.
  EXPECT_NEAR(-at(1e-9).Mz / at(1e-9).Fy, 0.02, 1e-9);
  EXPECT_GT(at(0.2 * full).Mz, 0);
}

TEST(Brush, TangentsAreTheDerivatives) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  for (int k = 0; k < 100; ++k) {
    BrushInput<Dual> in{.Fz = 3000,
                        .sigma_x = uniform(random),
                        .sigma_y = uniform(random),
                        .Cx = 9e4,
                        .Cy = 7e4,
                        .mu = 0.8,
                        .a = 0.05};
    if (k == 0) in.sigma_x = in.sigma_y = 0;
    in.sigma_x.derivative = 1;
    const BrushOutput<Dual> x = brush(in);
    in.sigma_x.derivative = 0;
    in.sigma_y.derivative = 1;
    const BrushOutput<Dual> y = brush(in);
    EXPECT_NEAR(x.xx.value, x.Fx.derivative, 1e-6);
    EXPECT_NEAR(x.yx.value, x.Fy.derivative, 1e-6);
    EXPECT_NEAR(y.xy.value, y.Fx.derivative, 1e-6);
    EXPECT_NEAR(y.yy.value, y.Fy.derivative, 1e-6);
  }
}

TEST(Brush, DoesNothingWithoutLoadOrGrip) {
  for (const double Fz : {-10.0, 0.0, 1000.0}) {
    const BrushOutput<double> out = brush(BrushInput<double>{
        .Fz = Fz, .sigma_x = 0.1, .sigma_y = 0, .Cx = 8e4, .Cy = 8e4, .mu = Fz > 0 ? 0.0 : 1.0, .a = 0.06});
    for (const double value : {out.Fx, out.Fy, out.Mz, out.xx, out.yy}) EXPECT_EQ(value, 0);
  }
}

TEST(Brush, LanesAreTyresOfTheirOwn) {
  BrushInput<Pack<2>> in{
      .Fz = 3000.0, .sigma_x = 0.02, .sigma_y = 0.05, .Cx = 8e4, .Cy = 8e4, .mu = 0.9, .a = 0.06};
  in.sigma_y[1] = 5;  // slides
  const BrushOutput<Pack<2>> out = brush(in);
  for (int lane = 0; lane < 2; ++lane) {
    const BrushOutput<double> alone = brush(BrushInput<double>{.Fz = 3000,
                                                               .sigma_x = 0.02,
                                                               .sigma_y = in.sigma_y[lane],
                                                               .Cx = 8e4,
                                                               .Cy = 8e4,
                                                               .mu = 0.9,
                                                               .a = 0.06});
    EXPECT_EQ(out.Fx[lane], alone.Fx);
    EXPECT_EQ(out.Mz[lane], alone.Mz);
    EXPECT_EQ(out.yy[lane], alone.yy);
  }
}

}  // namespace
}  // namespace mimbre::brush_test
