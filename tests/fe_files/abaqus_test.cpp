#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fe_files/fe_files.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe::abaqus_test {
namespace {

using testing::HasSubstr;

struct Rod {
  Folder folder;
  std::string stiffness = "5,1, 5,1, 4.0e+00\n9,1, 5,1, -4.0e+00\n9,1, 9,1, 4.0e+00\n";
  std::string mass;

  Rod() {
    for (const char* node : {"9", "5"})
      for (const char* dof : {"1", "2", "3"})
        mass += std::string(node) + "," + dof + "," + node + "," + dof + ",1.5\n";
  }
  ImportedMatrices read() const {
    return read_abaqus_matrices(folder.write("a_STIF1.mtx", stiffness), folder.write("a_MASS1.mtx", mass),
                                folder.write("n.inp", "*NODE\n9,1,0,0\n5,0,0,0\n"));
  }
};

TEST(Abaqus, ReadsMatrixInputLines) {
  const ImportedMatrices read = Rod().read();
  ASSERT_EQ(read.matrices.dofs.size(), 6u);
  EXPECT_EQ(read.matrices.dofs[0].node, 0);
  EXPECT_EQ(read.matrices.stiffness.coeff(3, 0), -4);
  EXPECT_EQ(read.matrices.mass.coeff(5, 5), 1.5);
  EXPECT_THAT(read.warnings, testing::IsEmpty());
}

TEST(Abaqus, ReadsCoordinateLines) {
  Rod rod;
  rod.stiffness = "1 1 4.0\n4 1 -4.0\n4 4 4.0\n";
  rod.mass = "1 1 1\n2 2 1\n3 3 1\n4 4 1\n5 5 1\n6 6 1\n";
  const ImportedMatrices read = rod.read();
  EXPECT_EQ(read.matrices.stiffness.coeff(3, 0), -4);
  rod.mass = Rod().mass;
  EXPECT_THAT(complaint([&] { rod.read(); }), HasSubstr("is not of the same form"));
}

TEST(Abaqus, SaysWhatIsWrong) {
  const auto with = [](const std::string& stiffness) {
    Rod rod;
    rod.stiffness = stiffness;
    return complaint([&] { rod.read(); });
  };
  EXPECT_THAT(with(""), HasSubstr("has no entries"));
  EXPECT_THAT(with("6,1,6,1,1\n"), HasSubstr("a_STIF1.mtx:1:1: node 6 is not there"));
  EXPECT_THAT(with("-1,1,-1,1,1\n"), HasSubstr("node -1 is internal to an element"));
  EXPECT_THAT(with("5,11,5,11,1\n"), HasSubstr("dof 11 of node 5"));
  EXPECT_THAT(with("5,1,5,1,\n"), HasSubstr("no finite value"));
  EXPECT_THAT(with("5,1,5,1,1\n5,1,5,1,1\n"), HasSubstr("is there twice"));
  EXPECT_THAT(with("5,1,5,1,1\nfive\n"), HasSubstr("a_STIF1.mtx:2:1: 'five' is no entry"));
}

}  // namespace
}  // namespace mimbre::fe::abaqus_test
