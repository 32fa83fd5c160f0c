#include "math/stress.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>
#include <cmath>

namespace mimbre {

double von_mises(const Vector6& s) {
  const double xy = s[0] - s[1], yz = s[1] - s[2], zx = s[2] - s[0];
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3 * s.tail<3>().squaredNorm());
}

double stress_component(const Vector6& s, int component) {
  if (component < 6) return s[component];
  if (component == von_mises_component) return von_mises(s);
  const Eigen::Matrix3d tensor =
      (Eigen::Matrix3d() << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]).finished();
  const Eigen::Vector3d principal = eigenvalues3(tensor);
  return principal[component == 6 ? 2 : 0];
}

Vector6 tensor_strain(const Vector6& strain) {
  Vector6 tensor = strain;
  tensor.tail<3>() *= 0.5;
  return tensor;
}

double elongation(const Vector6& e, const Eigen::Vector3d& n) {
  return e.head<3>().dot(n.cwiseAbs2()) + e[3] * n.x() * n.y() + e[4] * n.y() * n.z() + e[5] * n.z() * n.x();
}

}  // namespace mimbre
