#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_mesh.h"

namespace mimbre::test::mesh_assembly_test {
namespace {

const Eigen::Vector3d kSize(1.1, 0.7, 0.5);

/// A box whose inner corners are moved off their places: its elements are distorted, its faces flat.
fe::SolidMesh distorted_box(ElementType type) {
  unsigned count = 0;
  return block(type, kSize, {3, 2, 2}, steel(), [&](const Eigen::Vector3d& at) {
    std::mt19937 generator(++count);
    Eigen::Vector3d moved = at;
    for (int k = 0; k < 3; ++k)
      if (at[k] > 0 && at[k] < kSize[k] * (1 - 1e-9)) moved[k] += 0.05 * (generator() / 2147483648.0 - 1);
    return moved;
  });
}

TEST(MeshAssembly, PatchTest) {
  // A linear displacement has no forces inside and the energy of its constant strain.
  Eigen::Matrix3d G;
  G << 1, 0.4, -0.3, 0.2, -0.7, 0.5, 0.6, -0.1, 0.8;
  G *= 1e-3;
  const Eigen::Matrix3d strain = 0.5 * (G + G.transpose());
  const double shear = steel().young / (2 * (1 + steel().poisson));
  const double lame = 2 * shear * steel().poisson / (1 - 2 * steel().poisson);
  const double volume = kSize.prod();
  const double energy =
      volume * (0.5 * lame * strain.trace() * strain.trace() + shear * strain.squaredNorm());
  for (ElementType type : kSolidTypes) {
    const fe::SolidMesh mesh = distorted_box(type);
    const Eigen::MatrixXd K = full(fe::assemble(mesh).stiffness);
    const Eigen::Matrix3Xd field = G * mesh.nodes;
    const Eigen::VectorXd u = field.reshaped();
    EXPECT_NEAR(0.5 * u.dot(K * u), energy, 1e-12 * energy) << type_name(type);
    const Eigen::VectorXd force = K * u;
    int inner = 0;
    for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n) {
      const Eigen::Array3d x = mesh.nodes.col(n);
      if ((x < 1e-9).any() || (x > kSize.array() - 1e-9).any()) continue;
      ++inner;
      EXPECT_LT(force.segment<3>(3 * n).norm(), 1e-11 * force.cwiseAbs().maxCoeff()) << type_name(type);
    }
    EXPECT_GT(inner, 0);
  }
}

TEST(MeshAssembly, RigidMotionsHaveTheMassAndInertiaOfTheBox) {
  const double m = steel().density * kSize.prod();
  const Eigen::Vector3d c = 0.5 * kSize;
  // ∫ r rᵀ dm about the corner
  Eigen::Matrix3d second = m * c * c.transpose();
  second.diagonal() += m / 12 * kSize.cwiseAbs2();
  for (ElementType type : kSolidTypes) {
    const fe::SolidMesh mesh = distorted_box(type);
    const Eigen::MatrixXd motions = rigid_motions(mesh.nodes);
    const Eigen::MatrixXd M = motions.transpose() * full(fe::assemble(mesh).mass) * motions;
    EXPECT_LT((M.topLeftCorner<3, 3>() - m * Eigen::Matrix3d::Identity()).norm(), 1e-12 * m);
    Eigen::Matrix3d moment;  // columns: ∫ e_k × r dm
    for (int k = 0; k < 3; ++k) moment.col(k) = m * Eigen::Vector3d::Unit(k).cross(c);
    EXPECT_LT((M.topRightCorner<3, 3>() - moment).norm(), 1e-12 * m) << type_name(type);
    const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
    EXPECT_LT((M.bottomRightCorner<3, 3>() - inertia).norm(), 1e-12 * m) << type_name(type);
  }
}

/// Two solids of different type, two shells and a beam, joined at nodes, numbered without order.
fe::SolidMesh mixed_mesh() {
  fe::SolidMesh mesh = block(ElementType::hex20, {1, 1, 1}, {1, 1, 1}, steel());
  const auto extra = mesh.nodes.cols();
  mesh.nodes.conservativeResize(3, extra + 7);
  mesh.nodes.rightCols(7) << 2, 2, 2, 2, 3, 3, 9,  //
      0, 1, 1, 0, 0.5, 0, 9,                       //
      0, 0, 1, 1, 1.5, 1, 9;
  const int n = static_cast<int>(extra);
  mesh.groups.push_back({ElementType::wedge6, "wedge", 0, 0, {1, n, 3, 5, n + 3, 7}, {501}});
  mesh.groups.push_back({ElementType::tri3, "skin", 0, 0.02, {n + 4, n + 2, n + 3}, {601}});
  mesh.groups.push_back({ElementType::quad4, "roof", 0, 0.01, {5, n + 3, n + 2, 7}, {602}});
  fe::BeamElement beam;
  beam.nodes = {n + 5, n + 4};
  beam.section = rectangle(0.05, 0.03);
  beam.material = steel();
  mesh.beams.push_back(beam);
  return mesh;
}

TEST(MeshAssembly, NodesOfShellsAndBeamsHaveSixDofsOthersThreeUnusedNone) {
  const fe::SolidMesh mesh = mixed_mesh();
  const fe::FeMatrices matrices = fe::assemble(mesh);
  std::vector<int> count(mesh.nodes.cols(), 0);
  for (const fe::Dof& dof : matrices.dofs) EXPECT_EQ(dof.direction, count[dof.node]++);
  EXPECT_TRUE(
      std::is_sorted(matrices.dofs.begin(), matrices.dofs.end(), [](const fe::Dof& a, const fe::Dof& b) {
        return std::pair(a.node, a.direction) < std::pair(b.node, b.direction);
      }));
  EXPECT_EQ(count[0], 3);
  EXPECT_EQ(count[5], 6);
  EXPECT_EQ(count[20], 3);
  for (int k : {2, 3, 4, 5}) EXPECT_EQ(count[20 + k], 6);
  EXPECT_EQ(count[26], 0);
  EXPECT_EQ(matrices.stiffness.rows(), static_cast<Eigen::Index>(matrices.dofs.size()));
  EXPECT_EQ(matrices.mass.rows(), matrices.stiffness.rows());
}

TEST(MeshAssembly, MixedMeshIsTheSumOfItsParts) {
  // Strain energy and mass of any motion: those of each part assembled alone.
  const fe::SolidMesh mesh = mixed_mesh();
  const fe::FeMatrices whole = fe::assemble(mesh);
  Eigen::MatrixXd K = full(whole.stiffness);
  Eigen::MatrixXd M = full(whole.mass);
  std::map<std::pair<int, int>, int> row;
  for (int r = 0; r < static_cast<int>(whole.dofs.size()); ++r)
    row[{whole.dofs[r].node, whole.dofs[r].direction}] = r;
  const double scale = K.cwiseAbs().maxCoeff();
  for (std::size_t part = 0; part <= mesh.groups.size(); ++part) {
    fe::SolidMesh alone = mesh;
    if (part < mesh.groups.size()) {
      alone.groups = {mesh.groups[part]};
      alone.beams.clear();
    } else {
      alone.groups.clear();
    }
    const fe::FeMatrices matrices = fe::assemble(alone);
    std::vector<int> rows;
    for (const fe::Dof& dof : matrices.dofs) rows.push_back(row.at({dof.node, dof.direction}));
    K(rows, rows) -= full(matrices.stiffness);
    M(rows, rows) -= full(matrices.mass);
  }
  EXPECT_LT(K.cwiseAbs().maxCoeff(), 1e-14 * scale);
  EXPECT_LT(M.cwiseAbs().maxCoeff(), 1e-14 * whole.mass.coeffs().cwiseAbs().maxCoeff());
}

TEST(MeshAssembly, OnlyLowerTrianglesAreStoredInOrder) {
  for (const fe::SolidMesh& mesh : {mixed_mesh(), block(ElementType::tet10, kSize, {2, 1, 1}, steel())}) {
    const fe::FeMatrices matrices = fe::assemble(mesh);
    for (const Eigen::SparseMatrix<double>* matrix : {&matrices.mass, &matrices.stiffness})
      for (int column = 0; column < matrix->cols(); ++column) {
        int before = column - 1;
        for (Eigen::SparseMatrix<double>::InnerIterator it(*matrix, column); it; ++it) {
          EXPECT_GT(it.row(), before);
          before = static_cast<int>(it.row());
        }
      }
  }
}

TEST(MeshAssembly, ResultDoesNotDependOnTheNumberOfThreads) {
  // More elements than are computed at a time.
  const fe::SolidMesh mesh = block(ElementType::tet10, kSize, {7, 6, 6}, steel());
  const fe::FeMatrices one = fe::assemble(mesh, 1);
  for (int threads : {2, 5}) {
    const fe::FeMatrices many = fe::assemble(mesh, threads);
    EXPECT_TRUE(one.stiffness.coeffs().isApprox(many.stiffness.coeffs(), 0));
    EXPECT_TRUE(one.mass.coeffs().isApprox(many.mass.coeffs(), 0));
  }
}

std::string refusal(const fe::SolidMesh& mesh) {
  try {
    fe::assemble(mesh);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MeshAssembly, SaysWhichElementOrNodeIsUnsound) {
  using testing::AllOf;
  using testing::HasSubstr;
  fe::SolidMesh mesh = block(ElementType::hex8, kSize, {2, 1, 1}, steel());
  mesh.groups[0].name = "arm";
  mesh.groups[0].labels = {70, 71};
  mesh.labels.resize(mesh.nodes.cols());
  std::iota(mesh.labels.begin(), mesh.labels.end(), 1000);
  EXPECT_EQ(refusal(mesh), "accepted");

  fe::SolidMesh bad = mesh;
  std::swap(bad.groups[0].nodes[8], bad.groups[0].nodes[12]);
  std::swap(bad.groups[0].nodes[9], bad.groups[0].nodes[13]);
  std::swap(bad.groups[0].nodes[10], bad.groups[0].nodes[14]);
  std::swap(bad.groups[0].nodes[11], bad.groups[0].nodes[15]);
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("element 71 of 'arm' (hex8)"), HasSubstr("inside out")));

  bad = mesh;
  bad.groups[0].nodes[3] = 99;
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("element 70"), HasSubstr("99"), HasSubstr("12")));

  bad = mesh;
  bad.nodes(1, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("node 1005"), HasSubstr("finite")));

  bad = mesh;
  bad.groups[0].material = -1;
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("element 70"), HasSubstr("no material")));

  bad = mesh;
  bad.materials[0].material.poisson = 0.5;
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("material 'material'"), HasSubstr("Poisson")));

  bad = mesh;
  bad.groups[0].nodes.pop_back();
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("'arm'"), HasSubstr("multiple")));

  bad = mixed_mesh();
  bad.groups[3].thickness = 0;
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("element 602 of 'roof' (quad4)"), HasSubstr("thickness")));

  bad = mixed_mesh();
  bad.nodes.col(bad.groups[3].nodes[2]) << 1.2, 0.1, 1;  // pushed in beyond the diagonal
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("element 602"), HasSubstr("convex")));

  bad = mixed_mesh();
  bad.beams[0].nodes[1] = -1;
  EXPECT_THAT(refusal(bad), AllOf(HasSubstr("beam element 0"), HasSubstr("-1")));
}

/// Displacements under forces, all but the free dofs held.
Eigen::VectorXd solve(const fe::FeMatrices& matrices, const std::vector<int>& free,
                      const Eigen::VectorXd& force) {
  const Eigen::MatrixXd K = full(matrices.stiffness);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(K.rows());
  u(free) = Cholesky(K(free, free)).solve(force(free));
  return u;
}

TEST(MeshAssembly, CantileverBlockDeflectsAsBeamTheorySays) {
  // Tolerances are what each type can do with two elements over the height.
  const Eigen::Vector3d size(1, 0.08, 0.1);
  const double I = size.y() * std::pow(size.z(), 3) / 12;
  const double shear = steel().young / (2 * (1 + steel().poisson));
  const double exact = 1 / (3 * steel().young * I) + 1 / (5.0 / 6 * shear * size.y() * size.z());
  const std::array<double, 8> lowest{0.3, 0.97, 0.97, 0.985, 0.3, 0.97, 0.55, 0.97};
  for (ElementType type : kSolidTypes) {
    const fe::SolidMesh mesh = block(type, size, {10, 1, 2}, steel());
    const fe::FeMatrices matrices = fe::assemble(mesh);
    std::vector<int> free;
    // Equal shares of the load on the nodes of the end: their local effect dies out within the height.
    Eigen::VectorXd force = Eigen::VectorXd::Zero(matrices.stiffness.rows());
    std::vector<int> loaded;
    for (int r = 0; r < static_cast<int>(matrices.dofs.size()); ++r) {
      const Eigen::Vector3d x = mesh.nodes.col(matrices.dofs[r].node);
      if (x.x() > 1e-9) free.push_back(r);
      if (x.x() > size.x() - 1e-9 && matrices.dofs[r].direction == 2) loaded.push_back(r);
    }
    for (int r : loaded) force[r] = 1.0 / static_cast<double>(loaded.size());
    const Eigen::VectorXd u = solve(matrices, free, force);
    double tip = 0;
    for (int r : loaded) tip += u[r] / static_cast<double>(loaded.size());
    EXPECT_LT(tip, 1.01 * exact) << type_name(type);
    EXPECT_GT(tip, lowest[static_cast<int>(type)] * exact) << type_name(type);
  }
}

TEST(MeshAssembly, SolidsThatAreThereTwiceAreNamed) {
  fe::SolidMesh mesh = block(ElementType::tet10, {1, 1, 1}, {2, 1, 1}, steel());
  auto& nodes = mesh.groups[0].nodes;
  const std::vector<int> third(nodes.begin() + 20, nodes.begin() + 30);
  nodes.insert(nodes.end(), third.begin(), third.end());
  try {
    fe::assemble(mesh);
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("has the same nodes as element 2"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace mimbre::test::mesh_assembly_test
