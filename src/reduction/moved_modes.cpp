#include "reduction/moved_modes.h"

#include "math/rotation.h"

namespace mimbre {

ReducedBody with_moved_modes(const ReducedBody& body, const Eigen::MatrixXd& motion) {
  using Eigen::Matrix3d, Eigen::Vector3d;
  ReducedBody out = body;
  const int n = body.modes;
  const auto t = [&](int k) { return Vector3d(motion.col(k).head<3>()); };
  const auto turn = [&](int k) { return Vector3d(motion.col(k).tail<3>()); };
  const Vector3d& moment = body.first_moment;
  const Matrix3d& P = body.second_moment;
  for (int k = 0; k < n; ++k) {
    out.S.col(k) += body.mass * t(k) + turn(k).cross(moment);
    for (int i = 0; i < 3; ++i)
      out.S_position[i].col(k) += moment[i] * t(k) + turn(k).cross(Vector3d(P.col(i)));
  }
  // ∫ x_i R_j dm of mode k's component i and the rigid motion of mode l.
  const auto mixed = [&](int k, int i, int l) -> Vector3d {
    const Vector3d spread(body.S_position[0](i, k), body.S_position[1](i, k), body.S_position[2](i, k));
    return body.S(i, k) * t(l) + turn(l).cross(spread);
  };
  for (int k = 0; k < n; ++k)
    for (int l = 0; l < n; ++l) {
      const Vector3d swung = turn(k).cross(moment), other = turn(l).cross(moment);
      Matrix3d added = body.mass * t(k) * t(l).transpose() + t(k) * other.transpose() +
                       swung * t(l).transpose() +
                       skew<double>(turn(k)) * P * skew<double>(turn(l)).transpose();
      for (int i = 0; i < 3; ++i) {
        added.row(i) += mixed(k, i, l).transpose();
        added.col(i) += mixed(l, i, k);
      }
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.S_modes[i][j](k, l) += added(i, j);
      out.mass_matrix(k, l) += added.trace();
    }
  const auto move = [&](auto&& shapes, const Vector3d& place) {
    for (int k = 0; k < n; ++k) shapes.col(k) += t(k) + turn(k).cross(place);
  };
  for (BodyFrame& frame : out.frames) {
    move(frame.X, frame.position);
    for (int k = 0; k < n; ++k) frame.X_theta.col(k) += turn(k);
  }
  for (Eigen::Index p = 0; p < body.nodes.cols(); ++p)
    move(out.node_shapes.middleRows<3>(3 * p), body.nodes.col(p));
  out.mesh_inertia.reset();
  out.eigenfrequencies.resize(0);
  return out;
}

}  // namespace mimbre
