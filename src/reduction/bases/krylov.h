#pragma once
#include "reduction/bases/shapes.h"

namespace mimbre::fe {

/// Vectors with the interfaces held that match, beside the static modes, the next moments of the response to
/// the interfaces' motions about ω² = `shift` (s⁻²): (K − shift M)⁻¹ M applied again and again to the static
/// modes of all interfaces (Craig, Hale 1988; Shyu, Ma, Hulbert 1997). With the static modes and the rigid
/// motions they span the Krylov space of forces at the interfaces: which interface is held in (K − shift M)⁻¹
/// makes no difference to it.
/// Blocks are made orthogonal and ordered by the energy of what they add, motions of high frequency weighing
/// less, so that the last one may be cut. At most `count` columns over the internal dofs; fewer when the
/// space is exhausted. Throws std::invalid_argument when `shift` is an eigenvalue of the held model.
Eigen::MatrixXd krylov_vectors(const SolidMesh& mesh, const TiedModel& tied, const FeMatrices& matrices,
                               const std::vector<Interface>& interfaces, double shift, int count);

}  // namespace mimbre::fe
