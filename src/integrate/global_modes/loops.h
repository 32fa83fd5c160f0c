#pragma once
#include <stdexcept>
#include <string>
#include <vector>

#include "dynamics/coordinate_kinds.h"
#include "dynamics/system.h"

/// Which coordinates the constraints of a system join.
namespace mimbre::global_modes {

/// A mechanism that has no global modes, and the coordinate or the equation where that shows.
struct NoGlobalModes : std::runtime_error {
  NoGlobalModes(const std::string& why, int coordinate_at, int equation_at = -1)
      : std::runtime_error(why), coordinate(coordinate_at), equation(equation_at) {}
  int coordinate, equation;  ///< −1: none
};

/// Coordinates that equations join, directly or by way of others.
struct Loop {
  std::vector<int> rigid, amplitudes;  ///< velocity coordinates
  std::vector<int> equations;
  int prescribed = -1;  ///< one of them that a drive moves
};

/// A coordinate that an equation of its own moves: a drive, or a joint that is held.
struct Prescribed {
  int coordinate = 0, equation = 0;
  double factor = 1;  ///< ∂Φ/∂(coordinate)
};

struct LoopsAndDrives {
  std::vector<Loop> loops;
  std::vector<Prescribed> prescribed;
};

/// After an evaluation of the system's matrix. Throws NoGlobalModes.
LoopsAndDrives find_loops(const System& system, const CoordinateKinds& kinds);

}  // namespace mimbre::global_modes
