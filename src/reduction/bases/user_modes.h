#pragma once
#include "mimbre/reduced_body.h"
#include "reduction/bases/shapes.h"

namespace mimbre::fe {

/// Mode shapes at all dofs that were given at some.
struct ExpandedModes {
  Eigen::MatrixXd u;       ///< dofs × modes
  Eigen::MatrixXd z;       ///< coordinates of the interfaces × modes, as of TiedModel
  Eigen::VectorXd misfit;  ///< of each: distance of the displacements given from the shape, by their norm
};

/// Of all shapes that the ties of the interfaces allow, those with the least strain energy that have the
/// given displacements (static expansion: Guyan 1965; Levine-West, Milman, Kissil 1996), which are held by
/// springs a million times as stiff as the model at their dofs: where given displacements contradict the
/// ties, the nearest shape is found. Throws std::invalid_argument for rows that do not fit the model, shapes
/// that are zero, not finite, or are too few: a rigid motion would be left undetermined.
ExpandedModes expand_user_modes(const SolidMesh& mesh, const FeMatrices& matrices,
                                const std::vector<Interface>& interfaces, const UserModes& modes);

/// The part of such modes that moves with the interfaces held, which is what they have beyond static modes.
Shapes held_user_modes(const TiedModel& tied, const FeMatrices& matrices,
                       const std::vector<Interface>& interfaces, const ExpandedModes& modes);
/// The modes without momentum, as those of a free body are.
Shapes free_user_modes(const FeMatrices& matrices, const std::vector<Interface>& interfaces,
                       const Eigen::MatrixXd& R, const ExpandedModes& modes);

/// What became of the modes; `fresh` as of independent_shapes.
Check user_modes_check(const FeMatrices& matrices, const UserModes& given, const ExpandedModes& modes,
                       const std::vector<double>& fresh);

}  // namespace mimbre::fe
