#pragma once
#include <Eigen/Core>
#include <vector>

#include "math/stress.h"
#include "mimbre/channels.h"

namespace mimbre {

/// Where von Mises stress is largest in a run.
struct HotSpot {
  int node = 0;  ///< of the drawing's points
  double von_mises = 0;
  double time = 0;  ///< s
  Vector6 stress = Vector6::Zero();
};

struct StressHistory {
  Eigen::VectorXd envelope;    ///< largest von Mises stress of each point, Pa
  std::vector<HotSpot> spots;  ///< descending, apart from each other by `apart`
};

/// Of a body with stress. `amplitudes`: instants × modes of the body. At most `most` spots, each the largest
/// of what lies within `apart` (m) around it.
StressHistory stress_history(const BodyDrawing& body, const Eigen::VectorXd& time,
                             const Eigen::Ref<const Eigen::MatrixXd>& amplitudes, int most, double apart);

}  // namespace mimbre
