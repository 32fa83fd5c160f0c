#include "reduction/stiffening/beside_rotation.h"

namespace mimbre {

Eigen::MatrixXd beside_rotation(const Eigen::MatrixXd& T) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(T.rows() + 3, T.cols() + 3);
  out.topLeftCorner(T.rows(), T.cols()) = T;
  out.bottomRightCorner<3, 3>().setIdentity();
  return out;
}

}  // namespace mimbre
