#include "fe_files/bodies/stress_matrix.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <numeric>

#include "fe_files/fe_files.h"
#include "fe_files/npz_writer.h"
#include "math/once/decompositions.h"

/// Stress of models whose matrices come from other programs.
namespace mimbre::fe::stress_matrix_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::HasSubstr;

const std::string bar = data_file("calculix/beam.inp");
std::string scipy(const std::string& name) { return data_file("scipy/" + name); }

std::vector<int> all_nodes(const SolidMesh& mesh) {
  std::vector<int> nodes(static_cast<std::size_t>(mesh.nodes.cols()));
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

/// Stress at `nodes` by the displacements of `dofs`, by our own elements.
MatrixXd own_stress(const SolidMesh& mesh, const std::vector<int>& nodes, const std::vector<Dof>& dofs) {
  std::vector<SurfacePoint> points;
  for (const int node : nodes) points.push_back({node, Eigen::Vector3d::Zero()});
  const auto n = static_cast<Index>(dofs.size());
  return recover(mesh, points, dofs, MatrixXd::Identity(n, n)).stress;
}

ModelReduction clamped(const SolidMesh& mesh) {
  ModelReduction options;
  Interface root, tip;
  root.name = "root";
  tip.name = "tip";
  for (int k = 0; k < mesh.nodes.cols(); ++k) {
    if (mesh.nodes(0, k) == 0) root.nodes.push_back(k);
    if (mesh.nodes(0, k) == mesh.nodes.row(0).maxCoeff()) tip.nodes.push_back(k);
  }
  for (Interface* i : {&root, &tip}) i->point = centre_of(mesh, i->nodes);
  options.interfaces = {root, tip};
  options.dynamic_modes = 4;
  options.free_modes = 0;
  return options;
}

/// Of the static modes at amplitude 1, in which the signs of the body's modes do not matter.
MatrixXd static_stress(const ReducedBody& body) {
  return body.stress * mimbre::inverse(body.user_from_modal).leftCols(6);
}

/// The stress of the bar's matrices by the matrix of its own elements, whatever order the file's columns
/// have: that of the elements themselves.
TEST(StressMatrix, OfTheElementsIsTheirStress) {
  const SolidMesh mesh = read_inp(bar).mesh;
  const ImportedMatrices read = read_sparse_matrices(scipy("stiffness-csr.npz"), scipy("mass-csc.npz"),
                                                     scipy("nodes.csv"), scipy("dofs.csv"));
  ASSERT_EQ(read.file_dofs.size(), 36u);
  ASSERT_EQ(read.mesh.labels, mesh.labels);
  const std::vector<int> nodes = all_nodes(mesh);
  Folder folder;
  const std::string file =
      folder.write("stress.npz", npz_of(own_stress(mesh, nodes, read.file_dofs).sparseView()));
  ModelReduction options = clamped(mesh);
  options.stress = read_stress_matrix(file, "", read.mesh, read.matrices, read.file_dofs);
  EXPECT_EQ(options.stress.nodes, nodes);
  const ReducedBody body = reduce(read.mesh, read.matrices, options).body;
  EXPECT_THAT(check(body), testing::IsEmpty());
  EXPECT_EQ(body.node_labels, mesh.labels);
  EXPECT_EQ(body.nodes, read.mesh.nodes);
  EXPECT_EQ(body.strain.size(), 0);

  options.stress = {};
  const ReducedBody own = reduce(mesh, read.matrices, options).body;
  ASSERT_EQ(own.stress.rows(), body.stress.rows());  // every node is on the surface
  EXPECT_LT((own.stress - body.stress).cwiseAbs().maxCoeff(), 1e-10 * own.stress.cwiseAbs().maxCoeff());
  for (const Check& c : body.checks) {
    EXPECT_TRUE(c.passed) << c.name << ": " << c.detail;
  }
}

TEST(StressMatrix, HasTheNodesOfTheTable) {
  const ImportedMatrices read = read_calculix_matrices(bar);
  const std::vector<int> nodes{9, 0, 11};
  const MatrixXd expected = own_stress(read.mesh, nodes, read.matrices.dofs);
  Folder folder;
  std::string table = "node,what\n# comment\n";
  for (const int node : nodes)
    table += fmt::format("{}, x\n", read.mesh.labels[static_cast<std::size_t>(node)]);
  const StressMatrix stress = read_stress_matrix(folder.write("s.npz", npz_of(expected.sparseView())),
                                                 folder.write("s.csv", table), read.mesh, read.matrices, {});
  EXPECT_EQ(stress.nodes, nodes);
  EXPECT_EQ(MatrixXd(stress.matrix), expected);
  ModelReduction options = clamped(read.mesh);
  options.stress = stress;
  const ReducedBody body = reduce(read.mesh, read.matrices, options).body;
  EXPECT_EQ(body.node_labels, (std::vector<std::int64_t>{20, 1, 12}));
  EXPECT_EQ(body.stress.rows(), 18);
}

/// Lengths of 1 mm and stress in MPa, lengths of 1 inch and stress in psi; rotations are in rad everywhere.
TEST(StressMatrix, ScalesWithTheUnits) {
  SolidMesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, 1);
  mesh.labels = {1};
  FeMatrices matrices;
  matrices.dofs = {{0, 0}, {0, 4}};
  const std::string bytes = npz_of(MatrixXd::Ones(6, 2).sparseView());
  const auto read = [&](const FileUnits& units) -> MatrixXd {
    return parse_stress_matrix(bytes, "s.npz", {}, mesh, matrices, {}, units).matrix;
  };
  EXPECT_EQ(read({}), MatrixXd::Ones(6, 2));
  EXPECT_NEAR(read({1e-3, 1e3, 1})(0, 0), 1e9, 1);  // 1 MPa by 1 mm
  EXPECT_NEAR(read({1e-3, 1e3, 1})(0, 1), 1e6, 1e-3);
  EXPECT_NEAR(read({0.0254, 175.126835, 1})(5, 1), 6894.757, 1e-3);
  EXPECT_NEAR(read({0.0254, 175.126835, 1})(5, 0), 6894.757 / 0.0254, 1e-1);
  EXPECT_THROW(read({0, 1, 1}), std::invalid_argument);
}

TEST(StressMatrix, SaysWhatIsWrong) {
  const ImportedMatrices read = read_calculix_matrices(bar);
  Folder folder;
  const auto with = [&](const MatrixXd& matrix, const std::string& table) {
    const std::string nodes = table.empty() ? "" : folder.write("s.csv", table);
    const std::string file = folder.write("s.npz", npz_of(matrix.sparseView()));
    return complaint([&] { read_stress_matrix(file, nodes, read.mesh, read.matrices, {}); });
  };
  EXPECT_EQ(with(MatrixXd::Ones(72, 36), ""), "");
  EXPECT_THAT(with(MatrixXd::Ones(66, 36), ""), HasSubstr("has 66 rows where the model's 12 nodes need 72"));
  EXPECT_THAT(with(MatrixXd::Ones(72, 36), "1\n2\n"),
              HasSubstr("has 72 rows where the table's 2 nodes need 12"));
  EXPECT_THAT(with(MatrixXd::Ones(72, 35), ""), HasSubstr("has 35 columns where the model has 36 dofs"));
  EXPECT_THAT(with(MatrixXd::Ones(6, 36), "node\n77\n"), HasSubstr("s.csv:2:1: node 77 is not there"));
  EXPECT_THAT(with(MatrixXd::Ones(6, 36), "1\n1\n"), HasSubstr("node 1 is there twice"));
  EXPECT_THAT(with(MatrixXd::Ones(6, 36), "1\none\n"), HasSubstr("'one' is no label"));
  EXPECT_THAT(with(MatrixXd::Ones(6, 36), "node\n"), HasSubstr("has no nodes"));
  MatrixXd bad = MatrixXd::Ones(72, 36);
  bad(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(with(bad, ""), HasSubstr("has entries that are not finite"));
  EXPECT_THAT(complaint([&] { read_stress_matrix("s.mtx", "", read.mesh, read.matrices, {}); }),
              HasSubstr("is no sparse matrix by its name"));
  EXPECT_THAT(complaint([&] { read_stress_matrix("none.npz", "", read.mesh, read.matrices, {}); }),
              HasSubstr("cannot be opened"));
  const std::string good = npz_of(MatrixXd::Ones(72, 36).sparseView());
  for (const std::size_t length : {good.size() - 1, good.size() / 2, std::size_t{100}}) {
    const std::string part = folder.write("t.npz", good.substr(0, length));
    EXPECT_NE(complaint([&] { read_stress_matrix(part, "", read.mesh, read.matrices, {}); }), "");
  }
}

TEST(StressMatrix, MustFitToTheModel) {
  const ImportedMatrices read = read_calculix_matrices(bar);
  ModelReduction options = clamped(read.mesh);
  options.stress.nodes = {0, 0};
  options.stress.matrix = Eigen::SparseMatrix<double>(12, 36);
  EXPECT_THROW(reduce(read.mesh, read.matrices, options), std::invalid_argument);
  options.stress.nodes = {0};
  EXPECT_THROW(reduce(read.mesh, read.matrices, options), std::invalid_argument);
  // Columns in another order: rigid motions stress, and the certificate says so.
  const std::vector<int> nodes = all_nodes(read.mesh);
  const MatrixXd stress = own_stress(read.mesh, nodes, read.matrices.dofs);
  options.stress = {MatrixXd(stress.rowwise().reverse()).sparseView(), nodes};
  const ReducedBody body = reduce(read.mesh, read.matrices, options).body;
  const auto line = std::find_if(body.checks.begin(), body.checks.end(),
                                 [](const Check& c) { return c.name == "stress matrix"; });
  ASSERT_NE(line, body.checks.end());
  EXPECT_FALSE(line->passed) << line->detail;
}

/// CalculiX's matrices and a mesh with its material: stress comes from our own elements. Their stiffness is
/// that of CalculiX for these types, so the static deflection by a force at a corner has the same stress with
/// our matrices.
TEST(StressOfImports, ComesFromTheElementsBesideTheMatrices) {
  for (const char* type : {"C3D4", "C3D10"}) {
    const std::string file = data_file(std::string("calculix/elements/") + type + ".inp");
    const ImportedMatrices read = read_calculix_matrices(file);
    const SolidMesh mesh = read_inp(file).mesh;
    ModelReduction options;
    options.interfaces.resize(1);
    options.interfaces[0].name = "root";
    options.interfaces[0].nodes =
        mesh.nodes.cols() == 4 ? std::vector<int>{0, 2, 3} : std::vector<int>{0, 2, 3, 6, 7, 9};
    options.interfaces[0].point = centre_of(mesh, options.interfaces[0].nodes);
    options.loads = {{"push", {1}, Eigen::Vector3d(1, 2, 3)}};
    options.dynamic_modes = 0;
    options.free_modes = 0;
    const ReducedBody theirs = reduce(read.mesh, read.matrices, options).body,
                      ours = reduce(mesh, assemble(mesh), options).body;
    ASSERT_EQ(theirs.modes, 1);
    ASSERT_EQ(theirs.stress.rows(), 6 * 4);  // the corners
    EXPECT_EQ(theirs.node_labels, ours.node_labels);
    // The mass, by which modes are scaled, may differ.
    const Eigen::VectorXd a = theirs.stress.col(0).normalized(), b = ours.stress.col(0).normalized();
    EXPECT_LT(std::min((a - b).norm(), (a + b).norm()), 1e-9) << type;
  }
}

/// Bricks differ: those of CalculiX are stiff in bending, ours have incompatible modes, so the nodes in the
/// middle of two of them move otherwise when the tip does. Twist they share.
TEST(StressOfImports, DiffersAsTheElementsDo) {
  const ImportedMatrices read = read_calculix_matrices(bar);
  const SolidMesh mesh = read_inp(bar).mesh;
  const ModelReduction options = clamped(mesh);
  const ReducedBody theirs = reduce(read.mesh, read.matrices, options).body,
                    ours = reduce(mesh, assemble(mesh), options).body;
  ASSERT_EQ(theirs.stress.rows(), 6 * 12);
  const MatrixXd a = static_stress(theirs), b = static_stress(ours);  // the tip moves, turns
  for (Index c = 0; c < 6; ++c)
    EXPECT_LT((a.col(c) - b.col(c)).norm(), (c == 3 ? 1e-9 : 0.25) * b.col(c).norm())
        << theirs.mode_names[static_cast<std::size_t>(c)];
}

}  // namespace
}  // namespace mimbre::fe::stress_matrix_test
