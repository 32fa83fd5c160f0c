#pragma once
#include <Eigen/Core>

#include "dynamics/scales.h"
#include "dynamics/state_transfer.h"

namespace mimbre {

/// Where the iterations of a step begin. The rule predicts an increment from the last accelerations; what
/// this was wrong by in the steps before is extrapolated, constant or linear, as far as that would have come
/// nearer in the last step. Where motion is smooth, that is a prediction of one or two orders more. Allocates
/// only when made.
class Prediction {
 public:
  explicit Prediction(int unknowns);

  /// x: the rule's own prediction for a step of that length; adds to it the error that it is expected to
  /// have.
  void begin(double step, Eigen::VectorXd& x);
  /// The prediction was replaced by x, from which nothing can be learned.
  void replace(const Eigen::VectorXd& x);
  /// How far the rule's own prediction is from x, by the mechanism's size.
  double off(const Scales& scales, const Eigen::VectorXd& x);
  /// The step ended at x.
  void learn(double step, const Scales& scales, const Eigen::VectorXd& x);
  /// The next step does not follow the last one.
  void forget() { known_ = order_ = 0; }
  void transfer(StateTransfer& transfer) { transfer(step_, known_, order_, last_, before_); }

 private:
  bool as_long(double step) const;

  double step_ = 0;  ///< s, that the errors are of
  int known_ = 0;    ///< errors of steps that follow each other, up to two
  int order_ = 0;    ///< of the extrapolation: 0: none, 1: the last error, 2: along the last two
  bool replaced_ = false;
  Eigen::VectorXd own_, last_, before_, error_, rest_;
};

}  // namespace mimbre
