#include "fe/elements/turning_cell.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "fe/elements/beam_element.h"
#include "math/rotation.h"

namespace mimbre::fe {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

TurningCell turning_beam(const Mesh& beams, int number) {
  const BeamElement& beam = beams.elements[static_cast<std::size_t>(number)];
  const ElementGeometry geometry = element_geometry(beams, number);
  TurningCell cell;
  cell.bar = geometry.length;
  cell.node_dofs = 6;
  cell.stiffness = element_stiffness(beam, geometry.length);
  cell.to_own = element_transformation(beam, geometry.axes);
  cell.arms.setZero(3, 2);
  cell.arms(0, 0) = -0.5 * geometry.length;
  cell.arms(0, 1) = 0.5 * geometry.length;
  cell.turn.setZero(3, 12);
  cell.turn(0, 3) = cell.turn(0, 9) = 0.5;
  cell.turn(1, 8) = -1 / geometry.length;
  cell.turn(1, 2) = 1 / geometry.length;
  cell.turn(2, 7) = 1 / geometry.length;
  cell.turn(2, 1) = -1 / geometry.length;
  return cell;
}

MatrixXd motions(const TurningCell& cell, const MatrixXd& u) {
  MatrixXd m(cell.motions_size(), u.cols());
  m.topRows<3>().noalias() = cell.turn * u;
  if (cell.bar > 0)
    for (Index end = 0; end < 2; ++end)
      m.middleRows<2>(3 + 2 * end) = u.middleRows<2>(6 * end + 4) - m.middleRows<2>(1);
  return m;
}

VectorXd second_order(const TurningCell& cell, const MatrixXd& u, const MatrixXd& m, Index a, Index b) {
  VectorXd out(cell.dofs());
  const Vector3d wa = m.col(a).head<3>(), wb = m.col(b).head<3>();
  for (Index k = 0; k < cell.arms.cols(); ++k) {
    const Index at = cell.node_dofs * k;
    const Vector3d ua = u.col(a).segment<3>(at), ub = u.col(b).segment<3>(at), r = cell.arms.col(k);
    out.segment<3>(at) =
        -0.5 * (wa.cross(ub) + wb.cross(ua)) + 0.25 * (wa.cross(wb.cross(r)) + wb.cross(wa.cross(r)));
    if (cell.node_dofs < 6) continue;
    const Vector3d ta = u.col(a).segment<3>(at + 3), tb = u.col(b).segment<3>(at + 3);
    out.segment<3>(at + 3) = -0.25 * (wa.cross(tb) + wb.cross(ta));
  }
  if (cell.bar > 0) {
    const auto first = [&](Index k) { return m.col(k).segment<2>(3); };
    const auto second = [&](Index k) { return m.col(k).segment<2>(5); };
    const double bow = cell.bar / 30 *
                       (2 * first(a).dot(first(b)) + 2 * second(a).dot(second(b)) -
                        0.5 * (first(a).dot(second(b)) + first(b).dot(second(a))));
    out[0] -= 0.5 * bow;
    out[6] += 0.5 * bow;
  }
  return out;
}

Matrix3d turning_work(const Eigen::Matrix3Xd& forces, const Eigen::Matrix3Xd& arms) {
  const Matrix3d product = forces * arms.transpose();
  return 0.5 * (product + product.transpose()) - product.trace() * Matrix3d::Identity();
}

MatrixXd work_partner(const TurningCell& cell, const VectorXd& forces, const MatrixXd& u, const MatrixXd& m) {
  // −f · (ω × u) = ω · (f × u), and of moments likewise half of it.
  MatrixXd P = MatrixXd::Zero(m.rows(), u.cols());
  Eigen::Matrix3Xd f(3, cell.arms.cols());
  for (Index k = 0; k < cell.arms.cols(); ++k) {
    const Index at = cell.node_dofs * k;
    f.col(k) = forces.segment<3>(at);
    P.topRows<3>().noalias() += skew<double>(f.col(k)) * u.middleRows<3>(at);
    if (cell.node_dofs == 6)
      P.topRows<3>().noalias() += 0.5 * skew<double>(forces.segment<3>(at + 3)) * u.middleRows<3>(at + 3);
  }
  P.topRows<3>().noalias() += 0.5 * turning_work(f, cell.arms) * m.topRows<3>();
  if (cell.bar > 0) {
    const double share = 0.5 * (forces[6] - forces[0]) * cell.bar / 30;
    P.middleRows<2>(3) = share * (2 * m.middleRows<2>(3) - 0.5 * m.middleRows<2>(5));
    P.middleRows<2>(5) = share * (2 * m.middleRows<2>(5) - 0.5 * m.middleRows<2>(3));
  }
  return P;
}

}  // namespace mimbre::fe
