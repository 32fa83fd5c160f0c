#include "reduction/file/mirror.h"

#include <stdexcept>
#include <utility>

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// How the components of each kind of quantity change their signs.
struct Mirror {
  Vector3d vector;         ///< displacements, forces, accelerations
  Vector3d pseudo_vector;  ///< rotations, angular velocities and accelerations

  explicit Mirror(const Vector3d& signs) : vector(signs), pseudo_vector(signs.prod() * signs) {}
  bool turns_over() const { return vector.prod() < 0; }
  double tensor(Eigen::Index i, Eigen::Index j) const { return vector[i] * vector[j]; }
  /// Of the components xx yy zz xy yz zx.
  VectorXd six() const {
    VectorXd s(6);
    s << 1, 1, 1, tensor(0, 1), tensor(1, 2), tensor(2, 0);
    return s;
  }
  /// Of a node's degrees of freedom.
  VectorXd dofs(int per_node) const {
    VectorXd s(per_node);
    s.head<3>() = vector;
    if (per_node > 3) s.tail<3>() = pseudo_vector;
    return s;
  }
};

/// Multiplies the rows by the signs, again and again until the last one.
template <class Matrix>
void sign_rows(Matrix& matrix, const VectorXd& signs) {
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) matrix.row(r) *= signs[r % signs.size()];
}

/// S, S̄^i and S^ij, of a body or of its second order. What the twist of beams adds to S̄^i turns about as the
/// rest: ε_kij a_k (aᵀ θ) has the signs of det(M) m_k = m_i m_j.
template <class Integrals>
void mirror_integrals(Integrals& integrals, const Mirror& m) {
  sign_rows(integrals.S, m.vector);
  for (Eigen::Index i = 0; i < 3; ++i) {
    auto& position = integrals.S_position[static_cast<std::size_t>(i)];
    sign_rows(position, m.vector[i] * m.vector);
    for (Eigen::Index j = 0; j < 3; ++j)
      integrals.S_modes[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] *= m.tensor(i, j);
  }
}

void mirror_mesh(MeshInertia& mesh, const Mirror& m) {
  const VectorXd signs = m.dofs(mesh.dofs_per_node);
  const auto sign = [&](Eigen::Index dof) { return signs[dof % signs.size()]; };
  for (Eigen::Index column = 0; column < mesh.mass.outerSize(); ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator it(mesh.mass, column); it; ++it)
      it.valueRef() *= sign(it.row()) * sign(it.col());
  sign_rows(mesh.shapes, signs);
}

/// A place's displacement is a vector, its rotation and that of the body are pseudo-vectors.
void mirror_stretching(Stretching& stretching, const Mirror& m) {
  const VectorXd signs = m.dofs(6);
  VectorXd places(stretching.places.cols());
  for (Eigen::Index k = 0; k < places.size(); ++k) places[k] = signs[k % 6];
  stretching.places *= places.asDiagonal();
  stretching.stiffness = (places.asDiagonal() * stretching.stiffness * places.asDiagonal()).eval();
  for (MatrixXd& form : stretching.forms) {
    form.bottomRows<3>() = (m.pseudo_vector.asDiagonal() * form.bottomRows<3>()).eval();
    form.rightCols<3>() = (form.rightCols<3>() * m.pseudo_vector.asDiagonal()).eval();
  }
}

/// Of a load's number (GeometricStiffness). Forces at the boundary belong to amplitudes and stay.
double load_sign(int load, const Mirror& m) {
  using Loads = GeometricStiffness;
  constexpr int products[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
  if (load < Loads::acceleration) {
    const auto& [i, j] = products[load - Loads::angular_velocity];
    return m.tensor(i, j);
  }
  if (load < Loads::angular_acceleration) return m.vector[load - Loads::acceleration];
  if (load < Loads::boundary) return m.pseudo_vector[load - Loads::angular_acceleration];
  return 1;
}

}  // namespace

ReducedBody mirrored(const ReducedBody& body, const Vector3d& signs) {
  if (body.ancf && body.ancf->kind == AncfKind::thick)
    throw std::invalid_argument("a thick beam by absolute nodal coordinates is mirrored as a mesh");
  const Mirror m(signs);
  ReducedBody image = body;
  image.first_moment = m.vector.cwiseProduct(body.first_moment);
  image.second_moment = m.vector.asDiagonal() * body.second_moment * m.vector.asDiagonal();
  mirror_integrals(image, m);

  for (BodyFrame& frame : image.frames) {
    frame.position = m.vector.cwiseProduct(frame.position).eval();
    frame.rotation = (m.vector.asDiagonal() * frame.rotation * m.vector.asDiagonal()).eval();
    sign_rows(frame.X, m.vector);
    // Absolute nodal coordinates may have changes of slope there, which are vectors.
    const bool slopes = body.ancf && body.ancf->kind != AncfKind::thick;
    sign_rows(frame.X_theta, slopes ? m.vector : m.pseudo_vector);
  }

  sign_rows(image.nodes, m.vector);
  sign_rows(image.node_shapes, m.vector);
  if (m.turns_over())
    for (auto& triangle : image.triangles) std::swap(triangle[1], triangle[2]);
  sign_rows(image.stress, m.six());
  sign_rows(image.strain, m.six());

  if (image.second_order) {
    SecondOrder& second = *image.second_order;
    mirror_integrals(second, m);
    for (Eigen::Matrix3Xd& X : second.frame_shapes) sign_rows(X, m.vector);
    sign_rows(second.node_shapes, m.vector);
    if (body.mesh_inertia) sign_rows(second.mesh_shapes, m.dofs(body.mesh_inertia->dofs_per_node));
  }
  if (image.geometric)
    for (std::size_t k = 0; k < image.geometric->loads.size(); ++k)
      image.geometric->stiffness[k] *= load_sign(image.geometric->loads[k], m);
  if (image.stretching) mirror_stretching(*image.stretching, m);
  if (image.ancf) {
    image.ancf->along = m.vector.cwiseProduct(body.ancf->along);
    // A pseudo-vector: across = normal × along is mirrored as vectors are, and amplitudes keep their meaning.
    image.ancf->normal = m.pseudo_vector.cwiseProduct(body.ancf->normal);
  }
  image.sections.reset();  // whose axes would be left-handed
  if (image.mesh_inertia) mirror_mesh(*image.mesh_inertia, m);
  return image;
}

}  // namespace mimbre
