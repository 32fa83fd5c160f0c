#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "mimbre/fe_reduce.h"
#include "reduction/tied_model.h"

namespace mimbre::fe {

/// Mode shapes over the dofs, and the motion of the interfaces' points in them: six rows per interface,
/// displacement and turn in body axes.
struct Shapes {
  Eigen::MatrixXd dofs, points;
  std::vector<std::string> names;
};

/// The points' rows of the interfaces' coordinates z, which are in the interfaces' axes.
Eigen::MatrixXd point_rows(const std::vector<Interface>& interfaces, const Eigen::MatrixXd& z);
/// The points' rows of rigid_shapes.
Eigen::MatrixXd rigid_points(const std::vector<Interface>& interfaces);
/// Names "kind interface.x" to "kind interface.rz" of the interfaces from number `first` on.
std::vector<std::string> motion_names(const std::string& kind, const std::vector<Interface>& interfaces,
                                      Eigen::Index first);

/// Numbers among the interfaces' coordinates of the motions that have a static mode, of the interfaces from
/// number `first` on.
std::vector<Eigen::Index> retained_motions(const std::vector<Interface>& interfaces, Eigen::Index first);
/// Static modes: unit retained motions of the interfaces from number `first` on, the others held, no other
/// forces.
Shapes static_shapes(const TiedModel& tied, const FeMatrices& matrices,
                     const std::vector<Interface>& interfaces, Eigen::Index first);
/// Shapes with all interfaces held (but where they are free), x over the tied model's internal dofs; names
/// "kind 1", "kind 2", ….
Shapes held_shapes(const TiedModel& tied, const std::vector<Interface>& interfaces, const Eigen::MatrixXd& x,
                   const std::string& kind);
Shapes join(const Shapes& a, const Shapes& b);

/// Takes the rigid motion out that moves the first interface's point; R: rigid_shapes.
void to_tangent(const std::vector<Interface>& interfaces, const Eigen::MatrixXd& R, Shapes& shapes);
/// Takes linear momentum out: the centre of mass stays where it is.
void to_centre_of_mass(const FeMatrices& matrices, const std::vector<Interface>& interfaces,
                       const Eigen::MatrixXd& R, Shapes& shapes);
/// Takes linear and angular momentum out of shapes that span the six rigid motions, and the six shapes that
/// then depend on the others.
void to_mean_axes(const FeMatrices& matrices, const std::vector<Interface>& interfaces,
                  const Eigen::MatrixXd& R, Shapes& shapes);

}  // namespace mimbre::fe
