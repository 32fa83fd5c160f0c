#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <Eigen/Dense>

#include "fe_files/fe_files.h"
#include "fe_files/matrices/matrix_files.h"
#include "mimbre/fe_import.h"
#include "support/dense.h"

namespace mimbre::fe::sparse_matrices_test {
namespace {

using test::full;

using testing::HasSubstr;

std::string scipy(const std::string& name) { return data_file("scipy/" + name); }

void expect_same(const ImportedMatrices& a, const ImportedMatrices& b) {
  ASSERT_EQ(a.matrices.dofs.size(), b.matrices.dofs.size());
  EXPECT_LT((full(a.matrices.stiffness) - full(b.matrices.stiffness)).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT((full(a.matrices.mass) - full(b.matrices.mass)).cwiseAbs().maxCoeff(), 1e-10);
}

/// Files that SciPy wrote of the matrices that CalculiX wrote.
TEST(SparseMatrices, ReadsWhatScipyWrites) {
  const ImportedMatrices expected = read_calculix_matrices(data_file("calculix/beam.inp"));
  for (const char* mass : {"mass-csc.npz", "mass-coo.npz", "mass.mtx"})
    for (const char* stiffness : {"stiffness-csr.npz", "stiffness.mtx"}) {
      const ImportedMatrices read =
          read_sparse_matrices(scipy(stiffness), scipy(mass), scipy("nodes.csv"), scipy("dofs.csv"));
      EXPECT_THAT(read.warnings, testing::IsEmpty());
      expect_same(read, expected);
    }
  // The nodes may also come from a mesh, and rows without a table are three per node; here the order differs.
  const ImportedMatrices other =
      read_sparse_matrices(scipy("stiffness.mtx"), scipy("mass.mtx"), data_file("calculix/beam.inp"));
  EXPECT_EQ(other.matrices.dofs.size(), 36u);
}

/// A rod of two nodes along x in the given files.
struct Rod {
  Folder folder;
  std::string nodes = "node x y z\n5 0 0 0\n9 1 0 0\n";
  std::string head = "%%MatrixMarket matrix coordinate real symmetric\n% comment\n";
  std::string stiffness = head + "6 6 3\n1 1 5\n4 1 -5\n4 4 5\n";
  std::string mass = head + "6 6 6\n1 1 1\n2 2 1\n3 3 1\n4 4 1\n5 5 1\n6 6 1\n";
  std::string dofs;

  ImportedMatrices read() const {
    folder.write("n.csv", nodes);
    folder.write("k.mtx", stiffness);
    folder.write("m.mtx", mass);
    if (!dofs.empty()) folder.write("d.csv", dofs);
    return read_sparse_matrices(folder.path("k.mtx"), folder.path("m.mtx"), folder.path("n.csv"),
                                dofs.empty() ? "" : folder.path("d.csv"));
  }
};

std::string with(void (*change)(Rod&)) {
  Rod rod;
  change(rod);
  return complaint([&] { rod.read(); });
}

TEST(SparseMatrices, RowsAreThreeOrSixPerNode) {
  const ImportedMatrices read = Rod().read();
  EXPECT_THAT(read.mesh.labels, testing::ElementsAre(5, 9));
  EXPECT_EQ(read.matrices.dofs[3].node, 1);
  EXPECT_EQ(read.matrices.dofs[3].direction, 0);
  EXPECT_EQ(full(read.matrices.stiffness)(0, 3), -5);
}

TEST(SparseMatrices, DofTableOrdersRows) {
  Rod rod;
  // Rows: x and y, z of the second node first.
  rod.dofs = "1;9;x\n2;9;y\n3;9;3\n4;5;1\n5;5;2\n6;5;z\n";
  rod.mass = rod.head + "6 6 6\n1 1 2\n2 2 2\n3 3 2\n4 4 1\n5 5 1\n6 6 1\n";
  const ImportedMatrices read = rod.read();
  EXPECT_EQ(full(read.matrices.mass).diagonal(), (Eigen::VectorXd(6) << 1, 1, 1, 2, 2, 2).finished());
  EXPECT_EQ(full(read.matrices.stiffness)(3, 0), -5);
}

TEST(SparseMatrices, BothTrianglesMustAgree) {
  const std::string head = "%%MatrixMarket matrix coordinate real general\n";
  Rod rod;
  rod.mass.replace(0, rod.head.size(), head);
  rod.stiffness = head + "6 6 4\n1 1 5\n4 1 -5\n1 4 -5\n4 4 5\n";
  EXPECT_EQ(full(rod.read().matrices.stiffness)(0, 3), -5);
  rod.stiffness = head + "6 6 4\n1 1 5\n4 1 -5\n1 4 -6\n4 4 5\n";
  EXPECT_THAT(complaint([&] { rod.read(); }),
              HasSubstr("is not symmetric: -5 at (node 9 direction 1; node 5 direction 1) and -6"));
  rod.stiffness = head + "6 6 5\n1 1 5\n4 1 -5\n1 4 -5\n4 4 5\n2 1 3\n";
  EXPECT_THAT(complaint([&] { rod.read(); }),
              HasSubstr("(node 5 direction 2; node 5 direction 1) has no mirror image"));
  rod.stiffness = head + "6 6 3\n1 1 5\n1 4 -5\n4 4 5\n";
  EXPECT_EQ(full(rod.read().matrices.stiffness)(0, 3), -5) << "only the upper triangle";
}

TEST(SparseMatrices, ScalesRotationsWithTheUnitOfLength) {
  Folder folder;
  const std::string nodes = folder.write("n.csv", "1,0,0,0\n");
  std::string entries = "%%MatrixMarket matrix coordinate real symmetric\n6 6 6\n";
  for (int i = 1; i <= 6; ++i) entries += fmt::format("{} {} 1\n", i, i);
  const std::string path = folder.write("a.mtx", entries);
  const ImportedMatrices read = read_sparse_matrices(path, path, nodes, "", {1e-3, 1e3, 1});
  EXPECT_NEAR(read.matrices.stiffness.coeff(0, 0), 1e3, 1e-9);    // N/mm
  EXPECT_NEAR(read.matrices.stiffness.coeff(3, 3), 1e-3, 1e-15);  // N mm/rad
  EXPECT_NEAR(read.matrices.mass.coeff(3, 3), 1e-3, 1e-15);       // t mm²
}

TEST(SparseMatrices, SaysWhatIsWrong) {
  EXPECT_EQ(with([](Rod&) {}), "");
  EXPECT_THAT(with([](Rod& r) { r.nodes = "1,0,0\n"; }), HasSubstr("n.csv:1:1: '1,0,0' is no node"));
  EXPECT_THAT(with([](Rod& r) { r.nodes = "1,0,0,0\n1,1,0,0\n"; }), HasSubstr("node 1 is there already"));
  EXPECT_THAT(with([](Rod& r) { r.nodes = "1,0,0,inf\n"; }), HasSubstr("is no node"));
  EXPECT_THAT(with([](Rod& r) { r.nodes += "10 0 0 0\n"; }), HasSubstr("has 6 rows where there are 3 nodes"));
  EXPECT_THAT(with([](Rod& r) { r.dofs = "1,5,7\n"; }), HasSubstr("'1,5,7' is no dof"));
  EXPECT_THAT(with([](Rod& r) { r.dofs = "1,6,1\n"; }), HasSubstr("node 6 is not there"));
  EXPECT_THAT(with([](Rod& r) { r.dofs = "1,5,1\n3,5,2\n"; }), HasSubstr("row 2 is missing"));
  EXPECT_THAT(with([](Rod& r) { r.dofs = "1,5,1\n2,5,2\n"; }), HasSubstr("has 6 rows where '"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = "1 1 5\n"; }),
              HasSubstr("k.mtx:1:1: is no Matrix Market file"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = "%%MatrixMarket matrix array real general\n"; }),
              HasSubstr("format 'array' is not read"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = "%%MatrixMarket matrix coordinate complex general\n"; }),
              HasSubstr("field 'complex' is not read"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = r.head + "6 6 9999999999\n1 1 5\n"; }),
              HasSubstr("ends after 1 of 9999999999 entries"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = r.head + "6 6 1\n7 1 5\n"; }),
              HasSubstr("the entry (7, 1) is outside of 6 rows"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = r.head + "6 6 1\n1 1 nan\n"; }), HasSubstr("a finite value"));
  EXPECT_THAT(with([](Rod& r) { r.stiffness = r.head + "6 6 0\n"; }), HasSubstr("has no stiffness"));
}

TEST(SparseMatrices, DamagedArchivesAreRefused) {
  std::ifstream stream(scipy("stiffness-csr.npz"), std::ios::binary);
  const std::string good{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(parse_npz(good, "a.npz").rows, 36);
  EXPECT_THAT(complaint([] { parse_npz("", "a.npz"); }), HasSubstr("a.npz: is no ZIP archive"));
  for (std::size_t length = 0; length < good.size(); length += 7)
    EXPECT_NE(complaint([&] { parse_npz(good.substr(0, length), "a.npz"); }), "");
  int refused = 0;
  for (std::size_t at = 0; at < good.size(); at += 5) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x55);
    refused += !complaint([&] { parse_npz(bad, "a.npz"); }).empty();
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace mimbre::fe::sparse_matrices_test
