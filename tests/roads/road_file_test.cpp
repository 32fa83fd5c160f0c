#include "mimbre/road_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fe_files/fe_files.h"
#include "roads/crg_file.h"
#include "roads/road_data.h"

/// OpenCRG files: what is read of all their formats, and what is said of bad ones.
namespace mimbre::road_file_test {
namespace {

using test::road_path;
using testing::ElementsAre;
using testing::HasSubstr;

RoadGrid parsed(const std::string& text) { return roads::parse_road_grid(text, "some.crg"); }
std::string complaint(const std::string& text) {
  return fe::complaint([&] { parsed(text); });
}

/// Of a straight road of three rows and as many sections.
std::string straight(const std::string& numbers = "LONG_SECTION_V_INCREMENT = 0.5\n",
                     const std::string& data =
                         " 0.0000000 0.0000000 0.1000000\n 0.2000000-0.1000000 0.3000000\n"
                         " 0.4000000 0.5000000 0.6000000\n") {
  return "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 2\n" + numbers +
         "$KD_Definition\n#:LRFI\nD:long section 1,m\nD:long section 2,m\nD:long section 3,m\n$$$$\n" + data;
}

TEST(RoadFile, StraightRoadOfFewLines) {
  const RoadGrid road = parsed(straight());
  EXPECT_THAT(road.x, ElementsAre(0, 2, 4));
  EXPECT_THAT(road.y, ElementsAre(0, 0, 0));
  EXPECT_THAT(road.v, ElementsAre(-0.5, 0, 0.5));
  EXPECT_THAT(road.height, ElementsAre(0, 0, 0.1, 0.2, -0.1, 0.3, 0.4, 0.5, 0.6));
  EXPECT_THAT(road.bank, ElementsAre(0, 0, 0));
  EXPECT_EQ(road.gaps, 0u);
  // By both ends, and by one of them.
  EXPECT_THAT(parsed(straight("LONG_SECTION_V_RIGHT = 1\nLONG_SECTION_V_LEFT = 2\n")).v,
              ElementsAre(1, 1.5, 2));
  EXPECT_THAT(parsed(straight("LONG_SECTION_V_LEFT = 2\nLONG_SECTION_V_INCREMENT = 1\n")).v,
              ElementsAre(0, 1, 2));
}

TEST(RoadFile, GapsTakeTheNearest) {
  const RoadGrid road = parsed(straight("LONG_SECTION_V_INCREMENT = 0.5\n",
                                        " *missing* 1.0000000 *missing*\n *missing* *missing* *missing*\n"
                                        " 0.4000000 *missing* *missing*\n 0.4000000 *missing* 0.6000000\n"));
  EXPECT_THAT(road.height, ElementsAre(1, 1, 1, 1, 1, 1, 0.4, 0.4, 0.4, 0.4, 0.4, 0.6));
  EXPECT_EQ(road.gaps, 8u);
}

/// What tests/data/roads/make_roads.py wrote.
void expect_bend(const std::string& name, double digits) {
  const RoadGrid road = read_road_grid(road_path(name));
  ASSERT_EQ(road.along(), 41u) << name;
  EXPECT_THAT(road.v, ElementsAre(-2, -1.5, -1, -0.25, 0, 0.25, 1, 1.5, 2));
  EXPECT_EQ(road.start_u, 100);
  EXPECT_EQ(road.increment, 0.5);
  EXPECT_EQ(road.gaps, 1u);
  EXPECT_TRUE(road.unused.empty());
  double x = 10, y = -5, z = 1.5;
  for (std::size_t i = 0; i < 41; ++i) {
    const double u = 0.5 * static_cast<double>(i), heading = 0.3 + 0.9 * std::sin(0.15 * u);
    if (i > 0) {
      x += 0.5 * std::cos(heading);
      y += 0.5 * std::sin(heading);
      z += 0.5 * 0.02 * std::sin(0.3 * u);
    }
    const double sum = 0.5 * digits * static_cast<double>(i + 1);
    EXPECT_NEAR(road.x[i], x, sum) << name;
    EXPECT_NEAR(road.y[i], y, sum);
    EXPECT_NEAR(road.line_height[i], z, sum);
    EXPECT_NEAR(road.bank[i], 0.04 * std::cos(0.2 * u), digits);
    for (std::size_t k = 0; k < road.v.size(); ++k) {
      const double v = i == 20 && k == 0 ? -1.5 : road.v[k];
      EXPECT_NEAR(road.height[i * 9 + k], 0.05 * std::sin(u) * std::cos(2 * v) + 0.01 * v, digits) << name;
    }
  }
}

TEST(RoadFile, AllFormatsHoldTheSameRoad) {
  expect_bend("bend.crg", 5.1e-8);
  expect_bend("bend_double.crg", 1e-15);
  expect_bend("bend_binary.crg", 1.2e-7);  // 24 binary digits
  expect_bend("bend_binary_double.crg", 1e-15);
}

/// Rows one after the other without line ends of their own, and a line that must end somewhere.
TEST(RoadFile, CompactTextAndGivenEnd) {
  const RoadGrid road = parsed(
      "$ROAD_CRG\nreference_line_increment = 1\nreference_line_start_x = 1\nreference_line_start_y = "
      "1\nreference_line_end_x = "
      "1\nreference_line_end_y = 3.002\n"
      "$KD_Definition\n#:KRFI\nD:reference line phi,rad\nD:long section at v = 1,m\nD:long section at v = "
      "-1,m\n$$$$\n"
      "**unused** 0.1000000 0.2000000 1.5707963 0.3000000 0.4000000 1.5707963 0.5000000\n 0.6000000\n");
  EXPECT_THAT(road.v, ElementsAre(-1, 1));
  EXPECT_THAT(road.height, ElementsAre(0.2, 0.1, 0.4, 0.3, 0.6, 0.5));
  EXPECT_NEAR(road.y[1], 2.001, 1e-7);
  EXPECT_NEAR(road.y[2], 3.002, 1e-12);
}

TEST(RoadFile, SaysWhatIsNotDone) {
  const RoadGrid road =
      parsed("$ROAD_CRG_MODS\nSCALE_Z_GRID = 2\nREFPOINT_U = 3\n$ROAD_CRG_OPTS\nBORDER_MODE_V = 1 ! zero\n" +
             straight("LONG_SECTION_V_INCREMENT = 0.5\nREFERENCE_LINE_SHAPE = 9\n"));
  EXPECT_THAT(road.unused, ElementsAre("$ROAD_CRG_MODS SCALE_Z_GRID", "$ROAD_CRG_MODS REFPOINT_U",
                                       "$ROAD_CRG_OPTS BORDER_MODE_V", "$ROAD_CRG reference_line_shape"));
}

TEST(RoadFile, IsSilentAboutWhatIsDoneAnyway) {
  const RoadGrid road = parsed(
      "$ROAD_CRG_MODS\nSCALE_Z_GRID = 1.0\ngrid_nan_mode = 2\n$ROAD_CRG_OPTS\nBORDER_MODE_V = 2 ! keep\n"
      "WARN_MSGS = -1\n$ROAD_CRG_MPRO\nMPRO_NAME = UTM32\n" +
      straight("LONG_SECTION_V_INCREMENT = 0.5\nREFERENCE_LINE_START_LON = 9\nREFERENCE_LINE_END_PHI = 1\n"));
  EXPECT_TRUE(road.unused.empty()) << road.unused.front();
}

TEST(RoadFile, SaysWhatIsWrong) {
  const std::string numbers = "LONG_SECTION_V_INCREMENT = 0.5\n";
  EXPECT_THAT(complaint(""), HasSubstr("some.crg: has no line $$$$"));
  EXPECT_THAT(complaint("$KD_Definition\nD:long section 1,m\n$$$$\n"),
              HasSubstr("some.crg:3:1: the block $KD_DEFINITION has no format"));
  EXPECT_THAT(complaint("$KD_Definition\n#:ABCD\n"),
              HasSubstr("some.crg:2:1: #:ABCD is no known format; LRFI"));
  EXPECT_THAT(complaint("$KD_Definition\n#:LRFI\nD:long section 1,mm\n"),
              HasSubstr("'long section 1' is in 'mm'; m is needed"));
  EXPECT_THAT(complaint("$KD_Definition\n#:LRFI\nD:long section one,m\n"),
              HasSubstr("has neither the section's number"));
  EXPECT_THAT(complaint("$ROAD_CRG_FILE\nother.crg\n"), HasSubstr("stand in another file"));
  EXPECT_THAT(complaint(straight("")), HasSubstr("need LONG_SECTION_V_INCREMENT above 0"));
  EXPECT_THAT(complaint(straight("LONG_SECTION_V_INCREMENT = wide\n")),
              HasSubstr("some.crg:3:1: long_section_v_increment is 'wide'; a number"));
  EXPECT_THAT(complaint(straight(numbers + "LONG_SECTION_V_RIGHT = 0\nLONG_SECTION_V_LEFT = 3\n")),
              HasSubstr("LONG_SECTION_V_LEFT is 3, but 3 sections 0.5 m apart end at 1"));
  EXPECT_THAT(complaint(straight(numbers, " 0.0000000 0.1000000\n")),
              HasSubstr("some.crg:10:1: the row ends with its field 2 of 3"));
  EXPECT_THAT(complaint(straight(numbers, " 0.0000000 0.1000000 0.1000000\n")),
              HasSubstr("less than two rows"));
  EXPECT_THAT(complaint(straight(numbers, " 0.0000000 0.1000000 0.1x00000\n")),
              HasSubstr("'0.1x00000' in the columns 21 to 30 is no number"));
  EXPECT_THAT(complaint(straight(numbers + "REFERENCE_LINE_END_U = 6\n")),
              HasSubstr("the data have 3 rows; 4 are needed"));
  EXPECT_THAT(complaint(straight(numbers + "REFERENCE_LINE_END_U = 3.1\n")),
              HasSubstr("which no steps of 2 m from 0 lead to"));
  EXPECT_THAT(complaint(straight(numbers + "REFERENCE_LINE_INCREMENT = 0\n")),
              HasSubstr("REFERENCE_LINE_INCREMENT must be above 0"));
  const std::string phi =
      "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 1\n"
      "$KD_Definition\n#:LRFI\nD:reference line phi,rad\nD:long section at v = 0,m\nD:long section at v = "
      "1,m\n$$$$\n";
  EXPECT_THAT(complaint(phi + "**unused** 0.0000000 0.0000000\n *missing* 0.0000000 0.0000000\n"),
              HasSubstr("the row 2 of the data has no phi"));
  EXPECT_THAT(
      complaint(
          phi +
          "**unused** 0.0000000 0.0000000\n 0.0000000 0.0000000 0.0000000\n 3.0000000 0.0000000 0.0000000\n"),
      HasSubstr("turns by more than 90 degrees"));
  EXPECT_THAT(complaint("$ROAD_CRG\nREFERENCE_LINE_END_X = 5\nREFERENCE_LINE_END_Y = 0\n" + phi +
                        "**unused** 0.0000000 0.0000000\n 0.0000000 0.0000000 0.0000000\n"),
              HasSubstr("points 1 and 2 are 5 m apart, not 1 m"));
  EXPECT_THAT(complaint(phi + "**unused** *missing* *missing*\n 0.0000000 *missing* *missing*\n"),
              HasSubstr("less than two rows"));
  EXPECT_THAT(fe::complaint([] { read_road_grid("/nowhere/no.crg"); }),
              HasSubstr("/nowhere/no.crg: cannot be opened"));
}

}  // namespace
}  // namespace mimbre::road_file_test
