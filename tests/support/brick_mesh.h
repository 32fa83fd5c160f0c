#pragma once
#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "mimbre/model.h"
#include "mimbre/reduced_body.h"
#include "support/random_mechanism.h"

/// A mesh of eight-node bricks (isoparametric, trilinear) with random modes, and its integrals by Gauss
/// quadrature of the elements.
namespace mimbre::test {

struct BrickMesh {
  Eigen::Matrix3Xd nodes;
  std::vector<std::array<int, 8>> bricks;
  double density = 1;
};

/// x × y × z bricks in a box about a random place, turned, every node moved a little.
BrickMesh random_bricks(Random& random, int x, int y, int z);

/// At a Gauss point: the brick's nodes, its shape functions, the mass.
using AtPoint = std::function<void(const std::array<int, 8>&, const Eigen::Matrix<double, 8, 1>&, double)>;
/// Calls at() at the Gauss points of all bricks; `points` per direction (3 or 4).
void integrate(const BrickMesh& mesh, int points, const AtPoint& at);

/// Consistent mass, nodes × nodes.
Eigen::SparseMatrix<double> nodal_mass(const BrickMesh& mesh);

Eigen::SparseMatrix<double> translational_mass(const Eigen::SparseMatrix<double>& nodal);

/// A body of these bricks with random modes and stiffness, shape integrals by quadrature of the elements.
ReducedBody random_brick_body(Random& random, const BrickMesh& mesh, int modes);

/// The body alone, floating.
std::shared_ptr<const Model> floating_model(const ReducedBody& body);

}  // namespace mimbre::test
