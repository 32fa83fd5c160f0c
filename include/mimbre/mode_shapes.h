#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/channels.h"

/// How modes of a mechanism move its bodies, for pictures.
namespace mimbre {

/// A mode by body. With the phase φ a body is displaced by Re(x e^{iφ}); `BodyShapes` has the complex x,
/// which belongs to Mode::motion. The ground has a column of zeros where it is drawn
/// (MechanismShapes::header).
struct BodyShapes {
  Eigen::Matrix3Xcd displacement;  ///< 3 × bodies, m: of their origins, global axes
  Eigen::Matrix3Xcd turn;          ///< 3 × bodies, rad: about global axes
  /// Amplitudes of the deformation shapes of all bodies, one body after another, as in ResultsRow::modes.
  Eigen::VectorXcd amplitudes;
  double reach = 0;         ///< m, largest displacement of a point that is drawn, at any phase
  double largest_turn = 0;  ///< rad, of a body, at any phase
};

/// A mechanism as it is drawn at the point where its modes were found, and how they move it.
struct MechanismShapes {
  ResultsHeader header;  ///< bodies, roads, frames and elements as those of a run; no channels
  ResultsRow at;         ///< poses and amplitudes at the point
  double size = 0;       ///< diagonal of the box around everything that is drawn, m; 0: one point
  /// Where the whole mechanism turns (LinearisedModes::turning): the axis, in the sense of the rotation, and
  /// a point of it, global.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX(), place = Eigen::Vector3d::Zero();
  std::vector<BodyShapes> modes;
};

/// The factor by which a mode is well seen: its largest displacement is the share `share` of the size, and no
/// body turns by more than 6 rad times the share. 0 where nothing that is drawn moves.
double drawing_factor(const MechanismShapes& shapes, int mode, double share = 0.1);

/// The mechanism moved by factor · Re(x e^{iφ}), in rad. Each body moves along the screw of its displacement
/// and its turn (the exponential map), so that it stays rigid and turns about its hinge wherever its origin
/// is; of the first order in the factor that is the mode.
ResultsRow moved_by_mode(const MechanismShapes& shapes, int mode, double factor, double phase);

}  // namespace mimbre
