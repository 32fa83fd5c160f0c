#pragma once
#include <Eigen/Core>
#include <vector>

#include "analysis/linear_core.h"

/// Linear equations of motion in minimal coordinates.
namespace mimbre::linear {

/// Which velocity coordinates are independent at a point, and how the others follow: δ = N y. Chosen by a
/// rank-revealing QR decomposition of the Jacobian along the mechanism's scales.
class Independent {
 public:
  /// Of all equations, or of those that hold between positions (`positions`): without those of velocities
  /// alone (rolling).
  /// `chosen`: the independent ones, in order; none: as is best.
  Independent(const Eigen::MatrixXd& jacobian, const Scales& scales, bool positions = false,
              const std::vector<int>& chosen = {});

  int rank() const { return static_cast<int>(dependent_.size()); }
  const std::vector<int>& coordinates() const { return independent_; }
  /// N, n × f.
  const Eigen::MatrixXd& motions() const { return motions_; }
  /// x with Φz x = b (each column) that moves dependent coordinates alone.
  Eigen::MatrixXd particular(const Eigen::MatrixXd& b) const;
  /// μ with Φzᵀ μ = b in the sense of least squares by work, the smallest.
  Eigen::VectorXd multipliers(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd multipliers(const Eigen::MatrixXd& b) const;
  /// Combinations of the equations that vary with nothing: Lᵀ Φz = 0 (m × redundant equations).
  Eigen::MatrixXd redundant() const;

 private:
  Eigen::MatrixXd scaled_, motions_;  ///< rows and columns by the scales
  Eigen::VectorXd rows_, columns_;
  std::vector<int> dependent_, independent_;
};

/// With x = (y, s, z): independent coordinates, independent velocities, the states among the parameters, and
/// inputs u (the other parameters). Equations of velocities alone (rolling) leave more coordinates than
/// velocities:
///
///     ẋ = A x + B u,    δ = position x|u,  δv = velocity x|u,  δa = acceleration x|u,  δλ = multipliers x|u
///
/// (x|u: x over u). Of the motion alone, M ÿ + C ẏ + K y = 0 with the others at rest; where there are more
/// coordinates than velocities M ṡ + C s + K y = 0.
struct Reduced {
  Eigen::MatrixXd A, B, position, velocity, acceleration, multipliers;
  Eigen::MatrixXd mass, damping, stiffness;
  int coordinates = 0, speeds = 0, states = 0, inputs = 0;  ///< of y, s, z, u
  /// Where z begins in x.
  int first_state() const { return coordinates + speeds; }
};

/// `positions` and `velocities`: what is independent of each; the same where no equation is of velocities
/// alone. `massless`: the independent coordinate that moves no mass, where there is one (the result is then
/// not filled); -1: none.
Reduced reduce(const Derivatives& d, const LinearCore::Rates& rates, const Independent& positions,
               const Independent& velocities, const Scales& scales, int& massless);

/// Accelerations and multipliers with M a + Φzᵀ λ = −r, Φ̈ = 0 of what find_mass() left. False where the
/// mass does not determine them: `massless` as above.
bool consistent_accelerations(const Derivatives& d, const Independent& independent, const Scales& scales,
                              Eigen::VectorXd& a, Eigen::VectorXd& multipliers, int& massless);

}  // namespace mimbre::linear
