#pragma once
#include <Eigen/Core>
#include <vector>

#include "analysis/linear_point.h"
#include "mimbre/modes.h"

/// What a mode consists of.
namespace mimbre::linear {

class ModeShares {
 public:
  explicit ModeShares(const Linearised& at);

  /// Fills shares, whirl and text of a mode whose shape, kind and eigenvalue are set.
  void describe(Mode& mode);

 private:
  /// Velocities of bodies (origin and angular, global) and rates of what elements measure at velocities v.
  struct Rates {
    std::vector<Vec3d> velocity, spin;
    std::vector<std::vector<double>> measured;
  };
  Rates rates(const Eigen::VectorXd& v);
  /// Mean kinetic energy of each body.
  Eigen::VectorXd body_energies(const Eigen::VectorXcd& v);
  void add_elastic(const Eigen::VectorXcd& motion, Mode& mode, double all);
  double whirl(const Eigen::VectorXcd& motion);
  std::string words(const Mode& mode, const Eigen::VectorXcd& shape) const;

  const Linearised& at_;
  const Compiled& m_;
  relative::RelativeSystem system_;
  Eigen::VectorXd generalised_;
  std::vector<std::vector<double>> stiffness_;  ///< of elements, at the point
  Vec3d axis_ = Vec3d::Zero();                  ///< of the fastest turning of a body, zero: none
  std::vector<Vec3d> still_;                    ///< velocities without v
};

/// What a velocity coordinate is in words: "revolute joint's name", "chassis along z", "mode 2 of arm".
std::string coordinate_words(const Compiled& model, int coordinate);

}  // namespace mimbre::linear
