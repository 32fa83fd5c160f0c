#include "forces/magic_formula.h"

#include <gtest/gtest.h>

#include <random>

#include "tyre_files/tyre_data.h"

/// The Magic Formula against other implementations of it, its own limits and symmetries.
namespace mimbre::magic_formula_test {
namespace {

using namespace forces;
using test::table_of;
using test::tyre_of;

MagicInput<double> input_of(const std::map<std::string, double>& row) {
  return {.Fz = row.at("Fz"),
          .kappa = row.at("kappa"),
          .alpha = row.at("alpha"),
          .gamma = row.at("gamma"),
          .dpi = row.at("dpi"),
          .Vx = row.at("Vx")};
}

/// Largest difference of each output from the table's, by the size that it has there on average.
void expect_as_in_table(const std::string& name, double tolerance) {
  const TyreProperties tyre = tyre_of(name + ".tir");
  const auto rows = table_of(name + ".csv");
  ASSERT_GE(rows.size(), 300u);
  const std::vector<std::pair<std::string, double MagicOutput<double>::*>> outputs{
      {"Fx", &MagicOutput<double>::Fx},
      {"Fy", &MagicOutput<double>::Fy},
      {"Mx", &MagicOutput<double>::Mx},
      {"My", &MagicOutput<double>::My},
      {"Mz", &MagicOutput<double>::Mz},
      {"trail", &MagicOutput<double>::trail},
      {"sigma_kappa", &MagicOutput<double>::sigma_kappa},
      {"sigma_alpha", &MagicOutput<double>::sigma_alpha}};
  for (const auto& [column, output] : outputs) {
    double mean = 0, worst = 0;
    for (const auto& row : rows) mean += std::abs(row.at(column)) / static_cast<double>(rows.size());
    for (const auto& row : rows) {
      const MagicOutput<double> out = magic_formula(tyre.numbers.data(), input_of(row));
      const double want = row.at(column);
      worst = std::max(worst, std::abs(out.*output - want) / std::max(std::abs(want), mean));
    }
    EXPECT_LT(worst, tolerance) << column;
    std::printf("%s %s: largest relative difference %.1e\n", name.c_str(), column.c_str(), worst);
  }
}

/// 300 points of combined slip, inclination, load, pressure and speed each, to the digits of the tables.
TEST(MagicFormula, IsThatOfAnotherImplementation) {
  expect_as_in_table("car_205_60R15_61", 1e-6);
  expect_as_in_table("every_term_61", 1e-6);
}

TEST(MagicFormula, Version52IsThatOfItsHandbook) { expect_as_in_table("car_52", 1e-6); }

TEST(MagicFormula, ShearsTheWayItsAxesSay) {
  const TyreProperties tyre = tyre_of("car_205_60R15_61.tir");
  const auto at = [&](double kappa, double alpha, double gamma, double Vx = 20) {
    return magic_formula(
        tyre.numbers.data(),
        MagicInput<double>{.Fz = 4000, .kappa = kappa, .alpha = alpha, .gamma = gamma, .Vx = Vx});
  };
  EXPECT_GT(at(0.05, 0, 0).Fx, 3000);    // drives
  EXPECT_LT(at(-0.05, 0, 0).Fx, -3000);  // brakes
  // Goes to the left: is pushed to the right behind the centre, and so turned to the left, into the motion.
  EXPECT_LT(at(0, 0.05, 0).Fy, -2000);
  EXPECT_GT(at(0, 0.05, 0).Mz, 30);
  EXPECT_GT(at(0, 0.05, 0).trail, 0.015);
  EXPECT_LT(at(0, 0.05, 0, -20).Mz, -30);  // backwards the trail is before the centre
  EXPECT_LT(at(0, 0, 0.1).Fy, at(0, 0, 0).Fy - 300);
  EXPECT_LT(at(0, 0, 0).My, -5);
  EXPECT_GT(at(0, 0, 0, -20).My, 5);
}

/// By dual numbers; of a tyre without ply steer and conicity, whose slip is none at 0.
TEST(MagicFormula, SlipStiffnessIsTheSlopeAtNoSlip) {
  TyreProperties tyre = tyre_of("car_205_60R15_61.tir");
  for (const auto scale : {magic::lhx, magic::lvx, magic::lhy, magic::lvy, magic::lvyka})
    tyre.numbers[static_cast<std::size_t>(scale)] = 0;
  tyre.numbers[magic::rhx1] = tyre.numbers[magic::rhy1] = tyre.numbers[magic::rhy2] = 0;
  const std::vector<Dual> numbers(tyre.numbers.begin(), tyre.numbers.end());
  for (const double load : {500.0, 4000.0, 8000.0}) {
    MagicInput<Dual> in{.Fz = load, .kappa = 0, .alpha = 0, .gamma = 0, .dpi = 0.1, .Vx = 20};
    in.kappa.derivative = 1;
    const MagicOutput<Dual> x = magic_formula(numbers.data(), in);
    EXPECT_NEAR(x.Fx.derivative, x.Kx.value, 1e-8 * x.Kx.value);
    in.kappa.derivative = 0;
    in.alpha.derivative = 1;
    const MagicOutput<Dual> y = magic_formula(numbers.data(), in);
    EXPECT_NEAR(y.Fy.derivative, y.Ky.value, -1e-8 * y.Ky.value);
    EXPECT_LT(y.Ky.value, 0);
  }
}

/// What differs between left and right in the formulas goes with these numbers.
TEST(MagicFormula, MirrorsATyreWithoutSides) {
  using namespace magic;
  TyreProperties tyre = tyre_of("every_term_61.tir");
  for (const Number number : {phx1, phx2, pvx1, pvx2, phy1, phy2, pvy1, pvy2, pey3, rhx1, rby3,  rvy1,
                              rvy2, qbz4, qdz3, qdz6, qdz7, qez4, qhz1, qhz2, ssz1, qsx1, qdz10, qdz11})
    tyre.numbers[static_cast<std::size_t>(number)] = 0;
  const MagicInput<double> in{.Fz = 5000, .kappa = -0.04, .alpha = 0.07, .gamma = 0.05, .dpi = 0.1, .Vx = 12};
  MagicInput<double> mirrored = in;
  mirrored.alpha *= -1;
  mirrored.gamma *= -1;
  const auto a = magic_formula(tyre.numbers.data(), in), b = magic_formula(tyre.numbers.data(), mirrored);
  EXPECT_NEAR(b.Fx, a.Fx, 1e-9);
  EXPECT_NEAR(b.Fy, -a.Fy, 1e-9);
  EXPECT_NEAR(b.Mx, -a.Mx, 1e-9);
  EXPECT_NEAR(b.My, a.My, 1e-9);
  EXPECT_NEAR(b.Mz, -a.Mz, 1e-9);
}

/// A tyre that does not know its front from its back has, driven backwards, what its mirror image behind it
/// has: forces along and moments across and upwards change their signs. What knows it goes with these
/// numbers.
TEST(MagicFormula, RunsBackwardsAsItsMirrorImage) {
  using namespace magic;
  TyreProperties tyre = tyre_of("every_term_61.tir");
  for (const Number number : {phx1, phx2, pvx1, pvx2, pex4, rhy1, rhy2, qsy2, rvy1, rvy2, rvy3})
    tyre.numbers[static_cast<std::size_t>(number)] = 0;
  for (const double speed : {0.05, 2.0, 20.0}) {
    const MagicInput<double> in{
        .Fz = 5000, .kappa = -0.04, .alpha = 0.07, .gamma = 0.05, .dpi = 0.1, .Vx = speed};
    MagicInput<double> back = in;
    back.kappa *= -1;
    back.Vx *= -1;
    const auto a = magic_formula(tyre.numbers.data(), in), b = magic_formula(tyre.numbers.data(), back);
    EXPECT_NEAR(b.Fx, -a.Fx, 1e-9);
    EXPECT_NEAR(b.Fy, a.Fy, 1e-9);
    EXPECT_NEAR(b.Mx, a.Mx, 1e-9);
    EXPECT_NEAR(b.My, -a.My, 1e-9);
    EXPECT_NEAR(b.Mz, -a.Mz, 1e-9);
  }
}

/// From a fiftieth of the speed of the measurement on, moments do not depend on the speed where the file does
/// not say so.
TEST(MagicFormula, NothingFadesFromHalfAMetreASecondOn) {
  using namespace magic;
  TyreProperties tyre = tyre_of("car_205_60R15_61.tir");
  for (const Number number : {qsy3, qsy4, lmuv}) tyre.numbers[static_cast<std::size_t>(number)] = 0;
  const auto at = [&](double Vx) {
    return magic_formula(
        tyre.numbers.data(),
        MagicInput<double>{.Fz = 4000, .kappa = 0.01, .alpha = 0.03, .gamma = 0.02, .Vx = Vx});
  };
  const auto fast = at(20), slow = at(0.5);
  EXPECT_EQ(slow.My, fast.My);
  EXPECT_EQ(slow.Mz, fast.Mz);
  EXPECT_LT(std::abs(at(0.05).My), 0.5 * std::abs(fast.My));
}

/// Loads that no file was measured at: five times the nominal one counts, and friction is never below 0.
TEST(MagicFormula, FarBeyondItsLoadForcesGoWithTheLoad) {
  for (const char* file : {"car_205_60R15_61.tir", "every_term_61.tir", "car_52.tir"}) {
    const TyreProperties tyre = tyre_of(file);
    const double most = magic::most_load * tyre.numbers[magic::lfzo] * tyre.nominal_load;
    const auto at = [&](double load, double gamma) {
      return magic_formula(
          tyre.numbers.data(),
          MagicInput<double>{.Fz = load, .kappa = -0.3, .alpha = 0.2, .gamma = gamma, .Vx = 10});
    };
    const MagicOutput<double> a = at(most, 0.02), b = at(1000 * most, 0.02);
    for (const auto value : {&MagicOutput<double>::Fx, &MagicOutput<double>::Fy, &MagicOutput<double>::Mx,
                             &MagicOutput<double>::My, &MagicOutput<double>::Mz})
      EXPECT_NEAR(b.*value, 1000 * a.*value, 1e-9 * std::abs(1000 * a.*value)) << file;
    EXPECT_LT(a.Fx, 0) << file;  // brakes
    EXPECT_LE(at(4000, 1.2).Fx, 0.05 * 4000) << file;
  }
}

TEST(MagicFormula, FrictionOfTheRoadScalesThePeak) {
  const TyreProperties tyre = tyre_of("car_205_60R15_61.tir");
  const auto peak = [&](double lmu) {
    double most = 0;
    for (int k = 0; k <= 2000; ++k) {
      const MagicInput<double> in{
          .Fz = 4000, .kappa = k * 5e-4, .alpha = 0, .gamma = 0, .Vx = 20, .lmu = lmu};
      most = std::max(most, magic_formula(tyre.numbers.data(), in).Fx);
    }
    return most;
  };
  EXPECT_NEAR(peak(1), 1.0422 * 4000, 1);
  EXPECT_NEAR(peak(0.3) / peak(1), 0.3, 1e-4);
  EXPECT_EQ(peak(0), 0);
}

TEST(MagicFormula, IsFiniteEverywhereAndNothingWithoutLoad) {
  for (const char* name : {"car_205_60R15_61.tir", "every_term_61.tir", "car_52.tir"}) {
    const TyreProperties tyre = tyre_of(name);
    const std::vector<Dual> numbers(tyre.numbers.begin(), tyre.numbers.end());
    for (const double Fz : {-100.0, 0.0, 1e-9, 1.0, 4000.0, 4e4})
      for (const double kappa : {-100.0, -1.0, 0.0, 1e-12, 1.0, 100.0})
        for (const double alpha : {-1.5707, -0.3, 0.0, 0.3, 1.5707963267948966})
          for (const double Vx : {-30.0, 0.0, 1e-9, 30.0})
            for (const double lmu : {0.0, 1.0}) {
              const auto in = MagicInput<Dual>{
                  Dual(Fz, 1), Dual(kappa, 2), Dual(alpha, 1), Dual(-0.05, 1), Dual(0.1, 1), Dual(Vx, 1),
                  lmu};
              const MagicOutput<Dual> out = magic_formula(numbers.data(), in);
              for (const Dual& value :
                   {out.Fx, out.Fy, out.Mx, out.My, out.Mz, out.trail, out.sigma_alpha, out.sigma_kappa}) {
                EXPECT_TRUE(isfinite(value)) << name << " Fz " << Fz << " kappa " << kappa << " alpha "
                                             << alpha << " Vx " << Vx << " lmu " << lmu;
              }
              for (const Dual& value : {out.Fx, out.Fy, out.Mx, out.My, out.Mz}) {
                if (Fz <= 0) {
                  EXPECT_EQ(value.value, 0) << name << " " << Fz;
                }
              }
            }
  }
}

/// Lanes of a pack are tyres of their own, of different versions even.
TEST(MagicFormula, LanesAreTyresOfTheirOwn) {
  const TyreProperties tyres[]{tyre_of("every_term_61.tir"), tyre_of("car_52.tir")};
  std::vector<Pack<2>> numbers(magic::count);
  for (std::size_t i = 0; i < magic::count; ++i)
    for (int lane = 0; lane < 2; ++lane) numbers[i][lane] = tyres[lane].numbers[i];
  const MagicInput<double> in{.Fz = 5000, .kappa = -0.04, .alpha = 0.07, .gamma = 0.05, .dpi = 0.1, .Vx = 12};
  const MagicOutput<Pack<2>> out = magic_formula(
      numbers.data(), MagicInput<Pack<2>>{in.Fz, in.kappa, in.alpha, in.gamma, in.dpi, in.Vx, in.lmu});
  for (int lane = 0; lane < 2; ++lane) {
    const MagicOutput<double> alone = magic_formula(tyres[lane].numbers.data(), in);
    EXPECT_EQ(out.Fx[lane], alone.Fx);
    EXPECT_EQ(out.Fy[lane], alone.Fy);
    EXPECT_EQ(out.Mz[lane], alone.Mz);
    EXPECT_EQ(out.sigma_alpha[lane], alone.sigma_alpha);
  }
}

TEST(MagicVertical, CarriesTheLoadOfAnotherImplementation) {
  for (const std::string name : {"car_205_60R15_61", "every_term_61"}) {
    const TyreProperties tyre = tyre_of(name + ".tir");
    const double* n = tyre.numbers.data();
    for (const auto& row : table_of(name + ".csv")) {
      const double omega = row.at("omega"), grown = magic_free_radius(n, omega) - tyre.unloaded_radius;
      const MagicVertical<double> z =
          magic_vertical(n, MagicVerticalInput<double>{.deflection = row.at("deflection") - grown,
                                                       .rate = 0,
                                                       .omega = omega,
                                                       .dpi = row.at("dpi"),
                                                       .Fx = row.at("Fx"),
                                                       .Fy = row.at("Fy")});
      EXPECT_NEAR(z.force, row.at("Fz"), 1e-6 * row.at("Fz"));
      EXPECT_NEAR(magic_rolling_radius(n, row.at("Fz"), omega, row.at("dpi")), row.at("rolling_radius"),
                  1e-8);
    }
  }
}

TEST(MagicVertical, HasTheStiffnessOfTheFileAtTheNominalLoad) {
  const TyreProperties tyre = tyre_of("car_205_60R15_61.tir");
  const double* n = tyre.numbers.data();
  // Where Fz = Fz₀: Q_FZ1 x + Q_FZ2 x² = 1.
  const double q1 = n[magic::q_fz1], q2 = n[magic::q_fz2], R = tyre.unloaded_radius;
  const double x = (std::sqrt(q1 * q1 + 4 * q2) - q1) / (2 * q2);
  const double deflection = x * R + R - magic_free_radius(n, 0.0);
  const auto z = magic_vertical(n, MagicVerticalInput<double>{.deflection = deflection, .rate = 0});
  EXPECT_NEAR(z.force, 4000, 1e-6);
  EXPECT_NEAR(z.stiffness, 209651, 1e-4);
  EXPECT_NEAR(magic_vertical(n, MagicVerticalInput<double>{.deflection = deflection, .rate = 2}).force, 4100,
              1e-6);
}

TEST(MagicVertical, DerivativesAreThoseOfDifferencesAndItNeverPulls) {
  const TyreProperties tyre = tyre_of("every_term_61.tir");
  const double* n = tyre.numbers.data();
  const auto at = [&](double deflection, double rate) {
    return magic_vertical(n, MagicVerticalInput<double>{.deflection = deflection,
                                                        .rate = rate,
                                                        .omega = 50,
                                                        .gamma = 0.05,
                                                        .dpi = 0.1,
                                                        .Fx = 500,
                                                        .Fy = -900});
  };
  // The last is pressed flat: the rim is 0.1165 m away.
  for (const double deflection : {0.005, 0.03, 0.13}) {
    const double h = 1e-7;
    EXPECT_NEAR((at(deflection + h, 1).force - at(deflection - h, 1).force) / (2 * h),
                at(deflection, 1).stiffness, 1e-6 * at(deflection, 1).stiffness);
    EXPECT_NEAR(at(deflection, 3).force - at(deflection, 2).force, at(deflection, 2).damping, 1e-8);
  }
  EXPECT_GT(at(0.13, 0).force, at(0.11, 0).force + 0.01 * 2e6);
  EXPECT_EQ(at(-0.02, 10).force, 0);
  EXPECT_EQ(at(0.002, -1000).force, 0);
  EXPECT_EQ(at(0.002, -1000).damping, 0);
}

}  // namespace
}  // namespace mimbre::magic_formula_test
