#include "fe/elements/solid_element.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"

namespace mimbre::test::solid_element_test {
namespace {

using fe::SolidMatrix;

SolidMatrix stiffness(ElementType type, const fe::NodePositions& nodes) {
  SolidMatrix K;
  fe::solid_stiffness(fe::solid_geometry(type, nodes), steel(), K);
  return K;
}

fe::NodalMatrix mass(ElementType type, const fe::NodePositions& nodes, const fe::ShapeSamples& samples) {
  fe::NodalMatrix M;
  fe::solid_mass(fe::solid_geometry(type, nodes), steel().density, samples, M);
  return M;
}

TEST(SolidElement, OnlyRigidMotionsHaveNoEnergy) {
  for (ElementType type : kSolidTypes)
    for (unsigned seed : {1u, 2u, 3u}) {
      const fe::NodePositions nodes = single_element(type, 0.06, seed);
      const Eigen::MatrixXd K = stiffness(type, nodes);
      EXPECT_EQ((K - K.transpose()).norm(), 0);
      const Eigen::VectorXd energies = symmetric_eigenvalues(K);
      const double scale = energies.maxCoeff();
      EXPECT_LT(energies.head(6).cwiseAbs().maxCoeff(), 1e-13 * scale) << type_name(type);
      // The wedge with its two points has one motion more, which two wedges together have not.
      if (type != ElementType::wedge6) {
        EXPECT_GT(energies[6], 1e-4 * scale) << type_name(type);
      }
      EXPECT_LT((K * rigid_motions(nodes)).cwiseAbs().maxCoeff(), 1e-13 * scale) << type_name(type);
    }
}

TEST(SolidElement, TwoWedgesHaveOnlyRigidMotionsWithoutEnergy) {
  const fe::SolidMesh mesh = block(ElementType::wedge6, {1, 0.8, 0.6}, {1, 1, 1}, steel());
  const Eigen::VectorXd energies = symmetric_eigenvalues(full(fe::assemble(mesh).stiffness));
  EXPECT_GT(energies[6], 1e-3 * energies.maxCoeff());
}

TEST(SolidElement, MassIsPositiveDefinite) {
  for (ElementType type : kSolidTypes) {
    const Eigen::MatrixXd M = mass(type, single_element(type, 0.06), fe::mass_samples(type));
    EXPECT_EQ((M - M.transpose()).norm(), 0);
    const Eigen::VectorXd values = symmetric_eigenvalues(M);
    EXPECT_GT(values[0], 1e-3 * values.maxCoeff()) << type_name(type);
  }
}

TEST(SolidElement, InverseOrFlatElementsAreRefused) {
  for (ElementType type : kSolidTypes) {
    fe::NodePositions nodes = single_element(type, 0);
    nodes.row(2) *= -1;
    try {
      stiffness(type, nodes);
      ADD_FAILURE() << type_name(type);
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("inside out"));
    }
    nodes.row(2).setConstant(0.3);
    try {
      mass(type, nodes, fe::mass_samples(type));
      ADD_FAILURE() << type_name(type);
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("no volume"));
    }
  }
}

TEST(SolidElement, UnsoundMaterialsAreRefused) {
  EXPECT_THROW(fe::check_elastic({0, 0.3, 1}), std::invalid_argument);
  EXPECT_THROW(fe::check_elastic({1, 0.5, 1}), std::invalid_argument);
  EXPECT_THROW(fe::check_elastic({1, -1, 1}), std::invalid_argument);
  EXPECT_THROW(fe::check_elastic({1, 0.3, -1}), std::invalid_argument);
  EXPECT_THROW(fe::check_elastic({1, std::nan(""), 1}), std::invalid_argument);
}

// What CalculiX 2.20 writes of one distorted element with *FREQUENCY, SOLVER=MATRIXSTORAGE. Of C3D15 and
// C3D20 most nodes are held, whose rows are left out. C3D8I has its incompatible modes as dofs of three nodes
// more, and an element with parallel faces.
struct Written {
  fe::NodePositions nodes;
  std::vector<int> dofs;  // 3·node + direction, of each row
  Eigen::MatrixXd stiffness, mass;
};

std::string path(const std::string& name, const std::string& suffix) {
  return std::string(MIMBRE_SOURCE_DIR) + "/tests/data/calculix/elements/" + name + suffix;
}

Eigen::MatrixXd read_matrix(const std::string& name, const std::string& suffix, std::size_t size) {
  const auto n = static_cast<Eigen::Index>(size);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  std::ifstream file(path(name, suffix));
  int row = 0, column = 0;
  double value = 0;
  while (file >> row >> column >> value) matrix(row - 1, column - 1) = matrix(column - 1, row - 1) = value;
  return matrix;
}

Written read(const std::string& name, ElementType type) {
  Written written;
  std::ifstream input(path(name, ".inp"));
  std::string line;
  std::getline(input, line);
  written.nodes.resize(3, fe::node_count(type));
  for (Eigen::Index n = 0; n < written.nodes.cols(); ++n) {
    std::getline(input, line);
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream values(line);
    int label = 0;
    values >> label >> written.nodes(0, n) >> written.nodes(1, n) >> written.nodes(2, n);
  }
  std::ifstream dofs(path(name, ".dof"));
  int node = 0, direction = 0;
  char dot = 0;
  while (dofs >> node >> dot >> direction) written.dofs.push_back(3 * (node - 1) + direction - 1);
  written.stiffness = read_matrix(name, ".sti", written.dofs.size());
  written.mass = read_matrix(name, ".mas", written.dofs.size());
  return written;
}

double difference(const Eigen::MatrixXd& ours, const Eigen::MatrixXd& theirs) {
  return (ours - theirs).cwiseAbs().maxCoeff() / theirs.cwiseAbs().maxCoeff();
}

struct Named {
  const char* name;
  ElementType type;
};

TEST(SolidElement, AgreesWithCalculixEntryByEntry) {
  for (const auto& [name, type] :
       {Named{"C3D4", ElementType::tet4}, Named{"C3D10", ElementType::tet10},
        Named{"C3D8", ElementType::hex8}, Named{"C3D20", ElementType::hex20},
        Named{"C3D6", ElementType::wedge6}, Named{"C3D15", ElementType::wedge15}}) {
    const Written written = read(name, type);
    ASSERT_FALSE(written.dofs.empty());
    SolidMatrix K;
    fe::function_stiffness(fe::solid_geometry(type, written.nodes), steel(), K);
    EXPECT_LT(difference(K(written.dofs, written.dofs), written.stiffness), 1e-13) << name;

    // Its mass uses the rule of the stiffness.
    const fe::NodalMatrix nodal = mass(type, written.nodes, fe::stiffness_samples(type));
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(K.rows(), K.cols());
    for (Eigen::Index a = 0; a < nodal.rows(); ++a)
      for (Eigen::Index b = 0; b < nodal.rows(); ++b)
        M.block<3, 3>(3 * a, 3 * b) = nodal(a, b) * Eigen::Matrix3d::Identity();
    EXPECT_LT(difference(M(written.dofs, written.dofs), written.mass), 1e-13) << name;
  }
}

TEST(SolidElement, BrickWithParallelFacesIsTheIncompatibleOneOfCalculix) {
  const Written written = read("C3D8I", ElementType::hex8);
  ASSERT_EQ(written.dofs.size(), 33);
  const Eigen::MatrixXd& all = written.stiffness;
  const Eigen::MatrixXd condensed =
      all.topLeftCorner(24, 24) -
      all.topRightCorner(24, 9) *
          PivotedCholesky(all.bottomRightCorner(9, 9)).solve(all.bottomLeftCorner(9, 24));
  EXPECT_LT(difference(stiffness(ElementType::hex8, written.nodes), condensed), 1e-13);
}

}  // namespace
}  // namespace mimbre::test::solid_element_test
