#include "mimbre/tyre_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fe_files/fe_files.h"
#include "tyre_files/magic_numbers.h"
#include "tyre_files/parse_tyre.h"
#include "tyre_files/tyre_data.h"

/// Tyre property files: what is read, in which units, and what is said of bad ones.
namespace mimbre::tyre_file_test {
namespace {

using namespace forces;
using test::tyre_of;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

TyreProperties parsed(const std::string& text) {
  fe::TextFile file(text, "some.tir");
  return tyre_files::parse_tyre(file);
}
std::string complaint(const std::string& text) {
  return fe::complaint([&] { parsed(text); });
}

/// The least that a tyre of version 5.2 needs.
std::string least(const std::string& more = "", const std::string& fittyp = "6") {
  return "[MODEL]\nFITTYP = " + fittyp +
         "\n[DIMENSION]\nUNLOADED_RADIUS = 0.3\n[VERTICAL]\nFNOMIN = 4000 $ load\nVERTICAL_STIFFNESS = 2E5\n"
         "[LONGITUDINAL_COEFFICIENTS]\nPCX1 = 1.6\nPDX1 = 1\nPKX1 = 20\n"
         "[LATERAL_COEFFICIENTS]\nPCY1 = 1.3\nPDY1 = 1\nPKY1 = -15\nPKY2 = 2\n" +
         more;
}

TEST(TyreFile, NumbersAreThoseOfTheFile) {
  const TyreProperties tyre = tyre_of("car_205_60R15_61.tir");
  EXPECT_EQ(tyre.version, 61);
  EXPECT_EQ(tyre.unloaded_radius, 0.3135);
  EXPECT_EQ(tyre.width, 0.205);
  EXPECT_EQ(tyre.rim_radius, 0.1905);
  EXPECT_EQ(tyre.nominal_load, 4000);
  EXPECT_EQ(tyre.pressure, 220000);
  EXPECT_EQ(tyre.nominal_pressure, 220000);
  EXPECT_EQ(tyre.side, "left");
  ASSERT_EQ(tyre.numbers.size(), static_cast<std::size_t>(magic::count));
  EXPECT_EQ(tyre.numbers[magic::version], 61);
  EXPECT_EQ(tyre.numbers[magic::pky1], -15.324);
  EXPECT_EQ(tyre.numbers[magic::qdz9], 0.00915);
  EXPECT_EQ(tyre.numbers[magic::ppz1], -0.4408);
  EXPECT_EQ(tyre.numbers[magic::bottom_stiff], 2e6);
  // √((Cz R₀/Fz₀)² − 4 QFZ2)
  EXPECT_NEAR(tyre.numbers[magic::q_fz1], std::sqrt(std::pow(209651 * 0.3135 / 4000, 2) - 4 * 15.4), 1e-12);
  EXPECT_THAT(tyre.unused, Contains("[INERTIA] MASS"));
  EXPECT_THAT(tyre.unused, Contains("[DIMENSION] ASPECT_RATIO"));
  EXPECT_THAT(tyre.unused, Not(Contains(HasSubstr("UNITS"))));
}

TEST(TyreFile, OtherUnitsBecomeSi) {
  const TyreProperties tyre = tyre_of("car_52.tir");
  EXPECT_EQ(tyre.version, 52);
  EXPECT_DOUBLE_EQ(tyre.unloaded_radius, 0.3135);
  EXPECT_DOUBLE_EQ(tyre.nominal_load, 4000);
  EXPECT_DOUBLE_EQ(tyre.numbers[magic::longvl], 16.7);
  EXPECT_DOUBLE_EQ(tyre.numbers[magic::vertical_stiffness], 209651);
  EXPECT_DOUBLE_EQ(tyre.numbers[magic::vertical_damping], 50);
  EXPECT_EQ(tyre.numbers[magic::pdx1], 1.0422);
  const TyreProperties inches =
      parsed("[UNITS]\nLENGTH = 'inch'\nFORCE='pound_force'\nPRESSURE='psi'\n" + least("IP = 30\n"));
  EXPECT_DOUBLE_EQ(inches.unloaded_radius, 0.3 * 0.0254);
  EXPECT_DOUBLE_EQ(inches.numbers[magic::vertical_stiffness], 2e5 * 4.4482216152605 / 0.0254);
  EXPECT_DOUBLE_EQ(inches.pressure, 30 * 6894.757293168361);
  EXPECT_DOUBLE_EQ(inches.nominal_pressure, inches.pressure);
}

TEST(TyreFile, WhatIsMissingIsNeutral) {
  const TyreProperties tyre = parsed(least());
  for (int i = 0; i < magic::count; ++i) {
    const std::string key(magic::rows[static_cast<std::size_t>(i)].key);
    const double value = tyre.numbers[static_cast<std::size_t>(i)];
    if (key.starts_with("L") && key != "LONGVL" && key != "LMUV" && key.size() < 6) {
      EXPECT_EQ(value, 1) << key;
    }
    if (key.starts_with("R") && key != "RIM_RADIUS") {
      EXPECT_EQ(value, 0) << key;
    }
  }
  // A pressure that is not said is the nominal one.
  EXPECT_EQ(tyre.pressure, 0);
  EXPECT_GT(tyre.numbers[magic::nompres], 0);
  EXPECT_EQ(tyre.numbers[magic::inflpres], tyre.numbers[magic::nompres]);
  EXPECT_EQ(tyre.numbers[magic::pky4], 2);
  EXPECT_EQ(tyre.numbers[magic::qsy7], 1);
  EXPECT_EQ(tyre.numbers[magic::longvl], 16.7);
  EXPECT_DOUBLE_EQ(tyre.numbers[magic::q_fz1], 2e5 * 0.3 / 4000);
}

/// In 5.2 and PAC2002 My = −R₀ Fz {…} (Fz/Fz₀)^QSY7, since 6.1 −R₀ Fz₀ {…} (Fz/Fz₀)^QSY7: a file of either
/// with the same moment has exponents that differ by one.
TEST(TyreFile, RollingResistanceFollowsTheLoadAsTheVersionSays) {
  const std::string resistance = "[ROLLING_COEFFICIENTS]\nQSY1 = 0.01\nQSY7 = ";
  const std::string stiff = "\nLONGITUDINAL_STIFFNESS=3e5\nLATERAL_STIFFNESS=1e5\n";
  for (const double exponent : {0.0, -0.15, 0.9})
    EXPECT_DOUBLE_EQ(
        parsed(least(resistance + std::to_string(exponent) + stiff)).numbers[magic::qsy7],
        parsed(least(resistance + std::to_string(exponent + 1) + stiff, "61")).numbers[magic::qsy7]);
}

TEST(TyreFile, KeysWithoutAValueAreAsIfTheyWereNotThere) {
  const TyreProperties tyre = parsed(least("[DIMENSION]\nWIDTH =\nRIM_RADIUS = $ none\n"));
  EXPECT_EQ(tyre.width, parsed(least()).width);
  EXPECT_THAT(tyre.unused, Contains("[DIMENSION] WIDTH, which has no value"));
  EXPECT_THAT(complaint("[MODEL]\nFITTYP = 6\n[VERTICAL]\nFNOMIN =\n"), HasSubstr("has no FNOMIN"));
}

TEST(TyreFile, WrittenInManyWays) {
  const TyreProperties tyre =
      parsed("$ title\n! FITTYP = 3\n" +
             least("[vertical]\nq_fz2=1.5D+01$comment = 3\nQFCX = +.1 ! more\n{a table}\n 1 2.0 -3e4\n"
                   "[MDI_HEADER]\nFILE_TYPE = 'a $ b'\nFILE_VERSION = 3.0\n"));
  EXPECT_EQ(tyre.numbers[magic::q_fz2], 15);
  EXPECT_EQ(tyre.numbers[magic::q_fcx], 0.1);
  EXPECT_TRUE(tyre.unused.empty());
  EXPECT_EQ(parsed(least("[MODEL]\r\nPROPERTY_FILE_FORMAT = 'PAC2002'\r\n")).version, 52);
  EXPECT_EQ(parsed(least("LONGITUDINAL_STIFFNESS=3e5\nLATERAL_STIFFNESS=1e5\n", "62")).version, 62);
}

TEST(TyreFile, SaysWhatIsWrong) {
  EXPECT_THAT(complaint(""), HasSubstr("some.tir: does not specify its Magic Formula"));
  EXPECT_THAT(complaint(""), HasSubstr("has no PKY2, which a tyre"));
  EXPECT_THAT(complaint(least("", "61")),
              HasSubstr("has no LATERAL_STIFFNESS, which a tyre of version 6.1 needs"));
  EXPECT_THAT(complaint(least("", "94")), HasSubstr("some.tir:2:1: FITTYP is 94, which is no Magic Formula"));
  EXPECT_THAT(complaint(least("LKY = much\n")), HasSubstr("LKY is 'much'; a finite number is needed"));
  EXPECT_THAT(complaint(least("LKY = nan\n")), HasSubstr("LKY is 'nan'; a finite number is needed"));
  EXPECT_THAT(complaint(least("LKY = 1e300\n")), HasSubstr("LKY is 1e300: too large"));
  EXPECT_THAT(complaint(least("LKY = '1'\n")), HasSubstr("LKY is '1'; a finite number is needed"));
  EXPECT_THAT(complaint(least("LFZO = 0\n")), HasSubstr("LFZO is 0; it must be above 0"));
  EXPECT_THAT(complaint(least("PDX1 = 2\n")),
              HasSubstr("PDX1 is given a second time, and otherwise; line 10 has 1"));
  EXPECT_THAT(complaint(least("RIM_RADIUS = 0.4\n")),
              HasSubstr("RIM_RADIUS 0.4 m is not below UNLOADED_RADIUS 0.3 m"));
  EXPECT_THAT(complaint(least("VERTICAL_DAMPING = -1\n")), HasSubstr("VERTICAL_DAMPING is -1"));
  EXPECT_THAT(complaint("[UNITS]\nANGLE = 'deg'\n" + least()),
              HasSubstr("some.tir:2:1: ANGLE cannot be 'deg'; known are rad"));
  EXPECT_THAT(complaint("[UNITS]\nLENGTH = 'mile'\n" + least()),
              HasSubstr("LENGTH cannot be 'mile'; known are centimeter"));
  EXPECT_THAT(complaint(least("what is this\n")), HasSubstr("'what is this' is no [SECTION]"));
  EXPECT_THAT(complaint(least("[SECTION\n")), HasSubstr("the section '[SECTION' has no closing bracket"));
  EXPECT_THAT(complaint(least("TYRESIDE = 'LEFT\n")), HasSubstr("the text of TYRESIDE has no closing '"));
  EXPECT_THAT(complaint("A = 1\n"), HasSubstr("A stands in front of the first [SECTION]"));
  EXPECT_THAT(complaint(std::string("[A]\n\0", 5)), HasSubstr("holds zero bytes"));
  std::string many = "[A]\n";
  for (int i = 0; i < 10001; ++i) many += "K = 1\n";
  EXPECT_THAT(complaint(many), HasSubstr("has more than 10000 properties"));
  EXPECT_THAT(fe::complaint([] { read_tyre_properties("/nowhere/no.tir"); }),
              HasSubstr("/nowhere/no.tir: cannot be opened"));
}

}  // namespace
}  // namespace mimbre::tyre_file_test
