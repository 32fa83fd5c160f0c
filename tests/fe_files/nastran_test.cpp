#include "fe_files/nastran/nastran.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "fe_files/fe_files.h"
#include "fe_files/nastran/nastran_cards.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe::nastran_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(NastranCards, FieldsOfAllThreeForms) {
  TextFile file(
      "$ comment\n"
      "GRID          12              1.     2.5     -3.            123\n"
      "GRID*                 12                             1.0             2.5*\n"
      "*                   -3.0\n"
      "grid,12,,1.,2.5,-3.\n"
      "DMIG    KAA           12       1              12       1    1.+3\n"
      "              13       2    2.-3\n"
      "DMIG,KAA,12,1,,12,1,1.+3,,+A\n+A,13,2,2.-3\n",
      "a.bdf");
  NastranLines lines(file);
  NastranCards cards(lines);
  NastranCard card;
  ASSERT_TRUE(cards.next(card));
  EXPECT_EQ(card.name, "GRID");
  EXPECT_THAT(card.fields, ElementsAre("12", "", "1.", "2.5", "-3.", "", "123", ""));
  ASSERT_TRUE(cards.next(card));
  EXPECT_EQ(card.name, "GRID");
  EXPECT_THAT(card.fields, ElementsAre("12", "", "1.0", "2.5", "-3.0", "", "", ""));
  ASSERT_TRUE(cards.next(card));
  EXPECT_THAT(card.fields, ElementsAre("12", "", "1.", "2.5", "-3.", "", "", ""));
  for (int form = 0; form < 2; ++form) {
    ASSERT_TRUE(cards.next(card));
    EXPECT_THAT(card.fields, ElementsAre("KAA", "12", "1", "", "12", "1", "1.+3", "", "13", "2", "2.-3", "",
                                         "", "", "", ""));
  }
  EXPECT_FALSE(cards.next(card));
}

/// A rod of two nodes, its stiffness in the small, its mass in the large field, as PARAM,EXTOUT,DMIGPCH does.
struct Rod {
  Folder folder;
  std::string grids = "GRID,5,,0.,0.,0.\nGRID,9,,1.,0.,0.\n";
  std::string stiffness =
      "DMIG    KAAX           0       6       1       0                       6\n"
      "DMIG    KAAX           5       1               5       1     5.0\n"
      "               9       1    -5.0\n"
      "DMIG    KAAX           9       1               9       1     5.0\n";
  std::string mass = "DMIG    MAAX           0       6       2       0                       6\n";

  Rod() {
    for (const char* node : {"5", "9"})
      for (const char* direction : {"1", "2", "3"})
        mass += std::string("DMIG*   MAAX                           ") + node + "               " +
                direction + "\n" + "*                      " + node + "               " + direction +
                " 1.500000000D+00\n";
  }
  ImportedMatrices read() const { return read_nastran_dmig(folder.write("a.pch", grids + stiffness + mass)); }
};

std::string with(void (*change)(Rod&)) {
  Rod rod;
  change(rod);
  return complaint([&] { rod.read(); });
}

TEST(Nastran, ReadsStiffnessAndMass) {
  const ImportedMatrices read = Rod().read();
  ASSERT_EQ(read.matrices.dofs.size(), 6u);
  EXPECT_EQ(read.matrices.stiffness.coeff(3, 0), -5);
  EXPECT_EQ(read.matrices.stiffness.coeff(3, 3), 5);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(read.matrices.mass.coeff(i, i), 1.5);
  EXPECT_THAT(read.warnings, testing::IsEmpty());
}

TEST(Nastran, SquareFormsHaveBothTriangles) {
  Rod rod;
  rod.stiffness = "DMIG,K2,0,1,1\nDMIG,K2,5,1,,5,1,5.\n,9,1,-5.\nDMIG,K2,9,1,,9,1,5.\n,5,1,-5.\n";
  EXPECT_EQ(rod.read().matrices.stiffness.coeff(3, 0), -5);
  rod.stiffness = "DMIG,K2,0,9,1,,,,6\nDMIG,K2,5,1,,5,1,5.\n,9,1,-5.\nDMIG,K2,9,1,,9,1,5.\n,5,1,-6.\n";
  EXPECT_THAT(complaint([&] { rod.read(); }), HasSubstr("is not symmetric"));
  rod.stiffness = "DMIG,K2,0,9,1,,,,6\nDMIG,K2,1,,,5,1,5.\n";
  EXPECT_THAT(complaint([&] { rod.read(); }), HasSubstr("the columns of K2 are only numbered"));
}

TEST(Nastran, GridsMayStandInSystemsAndInAnotherFile) {
  Rod rod;
  // System 2: at (1, 0, 0) of system 1, its z along the z of system 1, its x along y; system 1: at (0, 0, 3).
  const std::string bulk =
      "SOL 103\nCEND\n  DISPLACEMENT = ALL\nBEGIN BULK\n"
      "CORD2R,1,,0.,0.,3.,0.,0.,4.\n,1.,0.,3.\nCORD2R,2,1,1.,0.,0.,1.,0.,1.\n,1.,1.,0.\n"
      "GRID,5,2,2.,0.,0.,1\nGRID,9,,1.,0.,0.\nENDDATA\n";
  const std::string punch = rod.folder.write("a.pch", rod.stiffness + rod.mass);
  const ImportedMatrices read = read_nastran_dmig(punch, rod.folder.write("a.bdf", bulk));
  EXPECT_LT((read.mesh.nodes.col(0) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-15);
}

TEST(Nastran, DisplacementsMayBeInTurnedSystems) {
  Rod rod;
  // Node 9 at (1, 0, 0): its directions are out of, round and along the axis z, at 90° from x: y, −x, z of
  // the cylindrical system about (1, −1, 0).
  rod.grids = "CORD2C,7,,1.,-1.,0.,1.,-1.,1.\n,2.,-1.,0.\nGRID,5,,0.,0.,0.\nGRID,9,,1.,0.,0.,7\n";
  const ImportedMatrices read = rod.read();
  // Direction 1 of node 9 is body y.
  EXPECT_NEAR(read.matrices.stiffness.coeff(4, 0), -5, 1e-15);
  EXPECT_NEAR(read.matrices.stiffness.coeff(4, 4), 5, 1e-15);
  EXPECT_NEAR(read.matrices.stiffness.coeff(3, 3), 0, 1e-15);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(read.matrices.mass.coeff(i, i), 1.5, 1e-15);
}

TEST(Nastran, SaysWhatIsWrong) {
  EXPECT_EQ(with([](Rod&) {}), "");
  EXPECT_THAT(with([](Rod& r) { r.grids = ""; }), HasSubstr("has no GRID cards; give the bulk-data file"));
  EXPECT_THAT(with([](Rod& r) { r.grids += "GRID,5,,0.,.5,0.\n"; }),
              HasSubstr("a.pch:3:1: GRID 5: is there already"));
  EXPECT_THAT(with([](Rod& r) { r.grids = "GRID,5,7,0.,0.,0.\n"; }),
              HasSubstr("coordinate system 7 is not there"));
  EXPECT_THAT(with([](Rod& r) { r.grids = "CORD2R,7,8\nCORD2R,8,7\nGRID,5,7\n"; }), HasSubstr("in a circle"));
  EXPECT_THAT(with([](Rod& r) { r.grids = "CORD2R,7,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\nGRID,5,7\n"; }),
              HasSubstr("are on a line"));
  EXPECT_THAT(with([](Rod& r) {
                r.grids = "CORD2R,7,,0.,0.,0.,1.,0.,0.\n,0.,1.,0.\nGRID,5,,0.,0.,0.,7\nGRID,9,,1.,0.,0.\n";
                r.mass = "DMIG,MAAX,0,6,1\nDMIG,MAAX,5,1,,5,1,1.\nDMIG,MAAX,9,1,,9,1,1.\n";
              }),
              HasSubstr("node 5 has its displacements in a turned system (CD) and not all three"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = ""; }),
              HasSubstr("has 0 DMIG matrices whose names begin with K"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = "DMIG,KAAX,0,6,3\n"; }),
              HasSubstr("type 3 of the matrix KAAX"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness += "DMIG,KAAX,5,0,,5,1,1.\n"; }),
              HasSubstr("5 is a scalar point"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness += "DMIG,KAAX,6,1,,5,1,1.\n"; }),
              HasSubstr("node 6 has no GRID card"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness += "DMIG,KAAX,5,2,,5,2,1.x\n"; }),
              HasSubstr("'1.x' is no finite value"));
  EXPECT_THAT(with([](Rod& r) { r.mass = "DMIG,MAAX,5,1,,5,1,1.\nDMIG,MAAX,0,6,1\n"; }),
              HasSubstr("a column of MAAX stands before its head"));
}

}  // namespace
}  // namespace mimbre::fe::nastran_test
