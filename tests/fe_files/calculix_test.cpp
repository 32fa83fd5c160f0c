#include "fe_files/inp/calculix.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>

#include "fe_files/fe_files.h"
#include "math/once/decompositions.h"
#include "support/dense.h"

namespace mimbre::fe::calculix_test {
namespace {

using test::full;

using testing::HasSubstr;

TEST(Calculix, MatricesOfTheJobAreThoseOfAFreeBody) {
  const ImportedMatrices read = read_calculix_matrices(data_file("calculix/beam.inp"));
  EXPECT_THAT(read.warnings, testing::IsEmpty());
  const Eigen::SparseMatrix<double>&mass = read.matrices.mass, &stiffness = read.matrices.stiffness;
  const std::vector<Dof>& dofs = read.matrices.dofs;
  ASSERT_EQ(dofs.size(), 36u);
  for (std::size_t i = 1; i < dofs.size(); ++i) EXPECT_LT(dof_key(dofs[i - 1]), dof_key(dofs[i]));
  Eigen::MatrixXd rigid = Eigen::MatrixXd::Zero(36, 6);
  for (int i = 0; i < 36; ++i) {
    const auto& [node, direction] = dofs[static_cast<std::size_t>(i)];
    rigid(i, direction) = 1;
    for (int axis = 0; axis < 3; ++axis)
      rigid(i, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(read.mesh.nodes.col(node))(direction);
  }
  EXPECT_LT((full(stiffness) * rigid).cwiseAbs().maxCoeff(), 1e-11 * full(stiffness).cwiseAbs().maxCoeff());
  const Eigen::MatrixXd M = rigid.transpose() * full(mass) * rigid;
  EXPECT_NEAR(M(0, 0), 2 * 7800, 1e-7);
  // Centre of mass at (1, ½, ½): displacement by a rotation about z, −m y.
  EXPECT_NEAR(M(0, 5), -0.5 * 2 * 7800, 1e-7);
}

TEST(Calculix, ClampedBodyHasTheFrequenciesThatCalculixFinds) {
  const ImportedMatrices read = read_calculix_matrices(data_file("calculix/beam.inp"));
  std::vector<int> free;
  for (int i = 0; i < 36; ++i)
    if (read.mesh.nodes(0, read.matrices.dofs[static_cast<std::size_t>(i)].node) > 0) free.push_back(i);
  ASSERT_EQ(free.size(), 24u);
  const Eigen::MatrixXd K = full(read.matrices.stiffness)(free, free),
                        M = full(read.matrices.mass)(free, free);
  const Eigen::VectorXd eigenvalues = symmetric_eigenvalues(K, M);
  // From the .dat file of the same job with *BOUNDARY on the nodes 1, 4, 5, 8.
  const double expected[] = {1405.283, 1405.283, 2592.706, 4410.662};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(std::sqrt(eigenvalues[i]), expected[i], 1e-3);
}

TEST(Calculix, ScalesMatricesWithTheUnits) {
  const ImportedMatrices si = read_calculix_matrices(data_file("calculix/beam.inp"));
  const ImportedMatrices mm = read_calculix_matrices(data_file("calculix/beam.inp"), {1e-3, 1e3, 1});
  EXPECT_LT((full(si.matrices.stiffness) * 1e3 - full(mm.matrices.stiffness)).norm(), 1e-3);
  EXPECT_LT((full(si.matrices.mass) * 1e3 - full(mm.matrices.mass)).norm(), 1e-6);
}

/// One node with three dofs in an order that is not ours, and its files.
struct Sample {
  Folder folder;
  std::string inp = folder.write("a.inp", "*NODE\n7,1,0,0\n3,0,0,0\n");
  std::string dof = "3.1\n3.2\n3.3\n7.1\n7.2\n7.3\n";
  std::string sti, mas;

  Sample() {
    for (int i = 1; i <= 6; ++i) {
      if (i > 3) sti += fmt(i - 3, i, -5);
      sti += fmt(i, i, 5);
      mas += fmt(i, i, i <= 3 ? 1 : 2);
    }
  }
  static std::string fmt(int row, int column, double value) {
    return std::to_string(row) + " " + std::to_string(column) + "  " + std::to_string(value) + "\n";
  }
  ImportedMatrices read() const {
    folder.write("a.dof", dof);
    folder.write("a.sti", sti);
    folder.write("a.mas", mas);
    return read_calculix_matrices(inp);
  }
  std::string complain() const {
    return complaint([&] { read(); });
  }
};

TEST(Calculix, OrdersDofsAsTheNodes) {
  const ImportedMatrices read = Sample().read();
  // Node 7 stands first in the mesh.
  EXPECT_EQ(read.matrices.dofs[0].node, 0);
  EXPECT_EQ(full(read.matrices.mass).diagonal(), (Eigen::VectorXd(6) << 2, 2, 2, 1, 1, 1).finished());
  EXPECT_EQ(full(read.matrices.stiffness)(0, 3), -5);
}

TEST(Calculix, SaysWhatIsWrong) {
  const auto with = [](auto&& change) {
    Sample sample;
    change(sample);
    return sample.complain();
  };
  EXPECT_EQ(with([](Sample&) {}), "");
  EXPECT_THAT(with([](Sample& s) { s.dof += "21.1\n"; }),
              HasSubstr("node 21 is not in the input file; CalculiX adds nodes"));
  EXPECT_THAT(with([](Sample& s) { s.dof += "7.4\n"; }), HasSubstr("direction 4 of node 7"));
  EXPECT_THAT(with([](Sample& s) { s.dof += "seven\n"; }), HasSubstr("a.dof:7:1: 'seven' is no dof"));
  EXPECT_THAT(with([](Sample& s) { s.dof += "7.3\n"; }), HasSubstr("node 7 direction 3 is there twice"));
  EXPECT_THAT(with([](Sample& s) { s.dof = ""; }), HasSubstr("has no dofs"));
  EXPECT_THAT(with([](Sample& s) { s.dof = "3.1\n3.2\n3.3\n"; }), HasSubstr("cyclically symmetric"));
  EXPECT_THAT(with([](Sample& s) { s.sti += "1 1 5\n"; }),
              HasSubstr("(node 3 direction 1; node 3 direction 1) is there twice"));
  EXPECT_THAT(with([](Sample& s) { s.sti += "0 1 5\n"; }), HasSubstr("count from 1"));
  EXPECT_THAT(with([](Sample& s) { s.sti += "1 1 inf\n"; }), HasSubstr("a finite value"));
  EXPECT_THAT(with([](Sample& s) { s.sti.resize(s.sti.rfind("3 6")); }), HasSubstr("the file is not whole"));
  EXPECT_THAT(with([](Sample& s) { s.mas = std::string("\0\1\2", 3); }), HasSubstr("zero bytes"));
  Folder folder;
  EXPECT_THAT(
      complaint([&] { read_calculix_matrices(folder.write("b.inp", "*NODE\n1,0,0,0\n")); }),
      HasSubstr("b.dof: is not there; CalculiX writes it in a step with *FREQUENCY, SOLVER=MATRIXSTORAGE"));
  EXPECT_THAT(complaint([&] { read_calculix_matrices(folder.path("b.sti")); }),
              HasSubstr("the input file (.inp) is needed"));
}

TEST(Calculix, WarnsOfConstraintsInTheMatrices) {
  Sample sample;
  sample.sti = "";
  for (int i = 1; i <= 6; ++i) sample.sti += Sample::fmt(i, i, 5);
  const ImportedMatrices read = sample.read();
  ASSERT_EQ(read.warnings.size(), 3u);
  EXPECT_THAT(read.warnings[0].message, HasSubstr("the stiffness resists a translation along x"));
}

TEST(Calculix, GeometricStiffnessIsMinusTheFile) {
  Sample sample;
  const ImportedMatrices read = sample.read();
  const std::string str = sample.folder.write("a.str", sample.sti);
  const Eigen::SparseMatrix<double> G =
      read_calculix_geometric_stiffness(str, sample.folder.path("a.dof"), read);
  EXPECT_LT((full(G) + full(read.matrices.stiffness)).norm(), 1e-12);
}

}  // namespace
}  // namespace mimbre::fe::calculix_test
