#pragma once
#include <Eigen/Core>
#include <vector>

#include "compile/compiled.h"
#include "mimbre/modes.h"

/// Rotors of equal blades, and the waves that modes are in these (multiblade coordinates; Coleman, Feingold,
/// NACA Report 1351, 1958).
namespace mimbre::linear {

/// Three bodies or more that one body carries, with all that they carry, which are copies of each other,
/// turned by equal parts of a whole turn about one axis.
struct Blades {
  int hub = -1;                 ///< the body that carries them
  Vec3d axis = Vec3d::UnitZ();  ///< in the drawn position, global; it turns with the hub
  std::vector<double> angles;   ///< of each about the axis, rad, ascending from 0
  /// Of each, in the same order: its velocity coordinates, those with the same place mean the same.
  std::vector<std::vector<int>> coordinates;
};

/// In the drawn position.
std::vector<Blades> find_blades(const Compiled& model);

/// The shares of the waves in what blades do in a mode, by their mean squares along the scales: collective
/// (all together); differential (neighbours against each other, of even numbers); forward and backward, which
/// travel around the hub, as seen from it, in the sense of `turning` or against it, and their higher
/// harmonics. `turning`: the hub's angular velocity, turned back to the drawn position as the hub is; where
/// it has none about the axis, forward is about the axis.
std::vector<ModeShare> blade_waves(const Blades& blades, const Eigen::VectorXcd& motion,
                                   const std::vector<double>& scales, const Vec3d& turning);

/// The same rotors, and those with equal numbers of blades taken as one, whose blades have more coordinates.
std::vector<Blades> joined(const std::vector<Blades>& rotors);

/// Vectors of modes with one eigenvalue are any that span the same space: where blades alone move in a group
/// of such modes, or in the same way in all, they become waves. `position`: relative coordinates by states
/// (Reduced::position). Returns the numbers of the modes that have new shapes and left vectors, of any
/// length. `mixed`: whether a mode is of a group that is not separated, so that its waves have no meaning.
std::vector<std::size_t> separate_waves(const std::vector<Blades>& rotors, const Eigen::MatrixXd& position,
                                        const std::vector<double>& scales, std::vector<Mode>& modes,
                                        std::vector<char>& mixed);

}  // namespace mimbre::linear
