#include <vector>

#include "fe/elements/beam_element.h"
#include "mimbre/fe.h"

namespace mimbre::fe {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

void scatter(Triplets& triplets, const Matrix12& matrix, const std::array<int, 2>& nodes) {
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i)
      triplets.emplace_back(6 * nodes[i / 6] + i % 6, 6 * nodes[j / 6] + j % 6, matrix(i, j));
}

/// Tᵀ A T, symmetric to the last bit.
Matrix12 transformed(const Matrix12& matrix, const Matrix12& transformation) {
  const Matrix12 product = transformation.transpose() * matrix * transformation;
  return 0.5 * (product + product.transpose());
}

}  // namespace

Matrices assemble(const Mesh& mesh, MassMatrix mass_matrix) {
  Triplets mass;
  Triplets stiffness;
  mass.reserve(144 * mesh.elements.size());
  stiffness.reserve(144 * mesh.elements.size());
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamElement& beam = mesh.elements[e];
    const ElementGeometry geometry = element_geometry(mesh, e);
    const Matrix12 transformation = element_transformation(beam, geometry.axes);
    scatter(mass, transformed(element_mass(beam, geometry.length, mass_matrix), transformation), beam.nodes);
    scatter(stiffness, transformed(element_stiffness(beam, geometry.length), transformation), beam.nodes);
  }
  const Eigen::Index dofs = 6 * mesh.nodes.cols();
  Matrices matrices{Eigen::SparseMatrix<double>(dofs, dofs), Eigen::SparseMatrix<double>(dofs, dofs)};
  matrices.mass.setFromTriplets(mass.begin(), mass.end());
  matrices.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  return matrices;
}

}  // namespace mimbre::fe
