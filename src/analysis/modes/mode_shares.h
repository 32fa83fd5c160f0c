#pragma once
#include <Eigen/Core>
#include <vector>

#include "analysis/linear_point.h"
#include "analysis/modes/blades.h"
#include "mimbre/modes.h"

/// What a mode consists of.
namespace mimbre::linear {

class ModeShares {
 public:
  explicit ModeShares(const Linearised& at);

  /// Fills shares, whirl and text of modes whose shapes, kinds and eigenvalues are set.
  /// `mixed`: by mode, it is any vector of those of one eigenvalue, so that there are no waves of blades.
  void describe(std::vector<Mode>& modes, const std::vector<char>& mixed);
  /// The same of a mode whose motion, kind and eigenvalue are set, at rest: no matrices are needed.
  /// `stiffness_energy`: its mean energy by the whole stiffness, J.
  void describe_motion(Mode& mode, double stiffness_energy, bool mixed);

  /// Of the mechanism.
  const std::vector<Blades>& blades() const { return blades_; }
  /// Only Mode::fixed and its sense, by the shape.
  void see_from_ground(Mode& mode);

 private:
  Eigen::VectorXcd motion_of(const Mode& mode) const;
  void describe(Mode& mode, const Eigen::VectorXcd& moves, const Eigen::VectorXcd& momentum,
                double stiffness_energy, bool mixed);
  Eigen::VectorXcd momentum(const Eigen::VectorXcd& v);
  /// Rates of what elements measure at velocities v, one element after the other.
  std::vector<double> measured_rates(const Eigen::VectorXd& v);
  /// Mean kinetic energy of each body.
  Eigen::VectorXd body_energies(const Eigen::VectorXcd& v);
  void add_elastic(const Eigen::VectorXcd& motion, Mode& mode, double all);
  /// Orbits of the bodies' origins and axes about the axis: mean squares of what goes with the turning, of
  /// what goes against it, and of what is along or about the axis.
  struct Orbits {
    double forward = 0, backward = 0, axial = 0;
  };
  Orbits orbits(const Eigen::VectorXcd& motion);
  void find_whirl(const Eigen::VectorXcd& motion, Mode& mode);
  /// `energies`: of the coordinates, shares of all.
  void find_waves(const Eigen::VectorXd& energies, Mode& mode);
  std::vector<Vec3d> velocities_on_axis(const Eigen::VectorXd& v);
  std::vector<ModeShare> shares_of_states(const Mode& mode) const;
  std::string words(const Mode& mode, const Eigen::VectorXcd& shape) const;

  const Linearised& at_;
  const Compiled& m_;
  relative::RelativeSystem system_;
  Eigen::VectorXd generalised_;
  std::vector<std::vector<double>> stiffness_;  ///< of elements, at the point
  std::vector<double> still_;                   ///< measured_rates() at rest
  std::vector<Blades> blades_;
  std::vector<Vec3d>
      hub_spins_;               ///< of each of these, the angular velocity of the hub, in the drawn position
  Vec3d axis_ = Vec3d::Zero();  ///< of the fastest turning of a body, zero: none
};

/// What a velocity coordinate is in words: "revolute joint's name", "chassis along z", "mode 2 of arm".
std::string coordinate_words(const Compiled& model, int coordinate);

}  // namespace mimbre::linear
