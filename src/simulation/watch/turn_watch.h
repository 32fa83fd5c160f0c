#pragma once
#include <string>
#include <vector>

#include "dynamics/relative/workspace.h"
#include "dynamics/state_transfer.h"

namespace mimbre {

/// Watches for turning that a law of force was not made for. A law by three angles between two frames, as a
/// bushing's, and one by an angle about an axis go on through any number of turns; but where the frames
/// tilt far away from that axis, an angle about one axis acts about another. Nothing of the motion depends
/// on it. Allocates only when made, and when asked.
class TurnWatch {
 public:
  /// rad: 60°. Up to here a component of a rotation vector is near enough to an angle.
  static constexpr double limit = 1.0471975511965976;

  explicit TurnWatch(const Compiled& model);
  void start();
  /// After an accepted step: the last forces in `work` are of this state.
  void watch(const relative::Workspace<double>& work, double time);
  void transfer(StateTransfer& transfer);
  /// One for each law that went beyond the limit.
  std::vector<std::string> warnings() const;

 private:
  struct Watched {
    int element = -1;
    double tilt = 0, time = 0;  ///< the largest one
  };
  double tilt_of(const ElementData& element, const relative::Workspace<double>& work) const;

  const Compiled& model_;
  std::vector<Watched> watched_;
};

}  // namespace mimbre
