#pragma once
#include <Eigen/Core>
#include <vector>

namespace mimbre {

/// What the velocity coordinates of a system are, for formalisms that tabulate some of them over others.
struct CoordinateKinds {
  enum class Kind : char { plain, rotation, amplitude };
  std::vector<Kind> kind;     ///< by velocity coordinate; empty: the system's coordinates are of another kind
  std::vector<int> position;  ///< where it is in q; of the three of a rotation: where their quaternion is
  /// The amplitudes of a body: velocity coordinates from `first` on, and their stiffness at rest.
  struct Body {
    int first = 0;
    Eigen::MatrixXd stiffness;
    bool linear = true;  ///< the elastic forces are those of this stiffness
  };
  std::vector<Body> bodies;
  std::vector<int> drives;  ///< equations that prescribe one coordinate, with a constant Jacobian
};

}  // namespace mimbre
