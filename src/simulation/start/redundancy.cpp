#include "simulation/start/redundancy.h"

#include <algorithm>
#include <cmath>

#include "linalg/once/sparse_qr.h"
#include "math/elementary.h"
#include "mimbre/reduced_body.h"

namespace mimbre {
namespace {

constexpr double redundant = 1e-9;         ///< what an equation adds to others, as a share of its length
constexpr double moves_no_frame = 1e-9;    ///< of the largest motion of a frame by the modes
constexpr double bent = 1e-4;              ///< of the forces on modes that the largest wrench has
constexpr double nearly_redundant = 1e-5;  ///< the same: an angle, or a distance over L, that nobody meant

/// The transposed Jacobian, velocity coordinates × equations, in the mechanism's own units; equations of
/// length 1.
struct ScaledJacobian {
  linalg::SparseMatrix transposed;
  Eigen::VectorXd factor;  ///< what makes forces along the scaled equations multipliers
};

ScaledJacobian scaled_jacobian(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  const Scales& scales = system.scales();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m.velocities), none = Eigen::VectorXd::Zero(m.equations);
  Eigen::VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), rest.data(), rest.data(), none.data(), 0, r.data());
  system.assemble(s.q.data(), {});
  std::vector<JacobianEntry> entries = system.jacobian_entries();
  Eigen::VectorXd squares = none;
  for (JacobianEntry& e : entries) {
    e.value *= scales.coordinates[e.coordinate] / scales.equations[e.equation];
    squares[e.equation] += e.value * e.value;
  }
  ScaledJacobian out;
  out.factor.resize(m.equations);
  // Equations in which hardly anything moves are left as short as they are.
  for (int k = 0; k < m.equations; ++k)
    out.factor[k] = 1 / (scales.equations[k] * (squares[k] > 1e-6 ? std::sqrt(squares[k]) : 1));
  std::vector<Eigen::Triplet<double>> triplets;
  for (const JacobianEntry& e : entries)
    if (e.value != 0)
      triplets.emplace_back(e.coordinate, e.equation,
                            e.value * scales.equations[e.equation] * out.factor[e.equation]);
  out.transposed.resize(m.velocities, m.equations);
  out.transposed.setFromTriplets(triplets.begin(), triplets.end());
  return out;
}

/// How large a wrench each joint of the model carries, or its drive, moments over L at the joint; behind them
/// how large one of each constraint's.
std::vector<double> borne(relative::RelativeSystem& system, const State& s,
                          const Eigen::VectorXd& multipliers) {
  const Compiled& m = system.model();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m.velocities), none = Eigen::VectorXd::Zero(m.equations);
  Eigen::VectorXd r(m.velocities);
  std::vector<Vec3d> force(m.spec().joints.size(), Vec3d::Zero()), moment = force;
  const auto add_transmitted = [&](const Eigen::VectorXd& forces, double sign) {
    system.residual(s.time, s.q.data(), rest.data(), rest.data(), forces.data(), 0, r.data());
    for (std::size_t i = 0; i < m.bodies.size(); ++i) {
      const BodyData& b = m.bodies[i];
      const Wrench<double>& w = system.workspace().transmitted[i];
      force[b.joint_spec] += sign * w.force;
      moment[b.joint_spec] +=
          sign * (w.moment - system.workspace().frames[b.inboard_frame].position.cross(w.force));
    }
  };
  add_transmitted(multipliers, 1);
  add_transmitted(none, -1);
  for (const LoopData& l : m.loops)
    for (int k = l.first_equation; k < l.first_equation + l.count; ++k)
      if (l.closure[k - l.first_equation].kind == LoopClosure::Kind::distance)
        force[l.joint_spec] += multipliers[k] * system.workspace().covector_linear[k];
      else
        moment[l.joint_spec] += multipliers[k] * system.workspace().covector_angular[k];
  std::vector<double> size;
  for (std::size_t j = 0; j < force.size(); ++j)
    size.push_back(force[j].norm() + moment[j].norm() / m.length_scale);
  for (const ConstraintData& c : m.constraints) {
    size.push_back(0);
    for (int k = 0; k < c.count; ++k)
      size.back() += std::abs(multipliers[c.first_equation + k]) / (c.is_length(k) ? 1 : m.length_scale);
  }
  return size;
}

/// Two multipliers that are in balance without load, of no rule, so that nothing cancels.
std::vector<Eigen::VectorXd> forces_that_go_round(const ScaledJacobian& jacobian,
                                                  const linalg::SparseQr& qr) {
  std::vector<Eigen::VectorXd> out;
  const auto count = static_cast<Eigen::Index>(qr.dependent().size());
  if (count == 0) return out;
  for (const double seed : {0.0, 1.0}) {
    Eigen::VectorXd shares(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const double x = mimbre::sin(12.9898 * static_cast<double>(k + 1) + 78.233 * seed) * 43758.5453;
      shares[k] = 0.5 + x - std::floor(x);
    }
    const Eigen::VectorXd forces = jacobian.factor.cwiseProduct(qr.null_vector(shares));
    if (forces.allFinite()) out.push_back(forces);
  }
  return out;
}

/// Joints, then constraints, that carry more than `negligible` of the largest wrench where forces go round
/// that no load asks for.
std::vector<bool> concerned(relative::RelativeSystem& system, const State& s, const ScaledJacobian& jacobian,
                            const linalg::SparseQr& qr, double negligible) {
  const Compiled& m = system.model();
  std::vector<bool> marked(m.spec().joints.size() + m.constraints.size(), false);
  for (const Eigen::VectorXd& forces : forces_that_go_round(jacobian, qr)) {
    const std::vector<double> size = borne(system, s, forces);
    const double largest = *std::max_element(size.begin(), size.end());
    for (std::size_t j = 0; j < size.size(); ++j)
      if (size[j] > negligible * largest) marked[j] = true;
  }
  return marked;
}

/// Whether forces on the modes are more than round-off of what a wrench of this size does to them.
bool bends(const BodyData& b, const ReducedBody& body, double wrench, double length,
           const Eigen::VectorXd& forces) {
  Eigen::VectorXd by_unit = Eigen::VectorXd::Zero(b.modes);
  for (int k = 0; k < b.modes; ++k)
    for (const BodyFrame& frame : body.frames)
      by_unit[k] = std::max(by_unit[k], frame.X.col(k).norm() + length * frame.X_theta.col(k).norm());
  // Modes that move no frame do so by round-off.
  const double moved = moves_no_frame * by_unit.maxCoeff();
  for (int k = 0; k < b.modes; ++k)
    if (std::abs(forces[b.v + b.joint_velocities + k]) > bent * wrench * std::max(by_unit[k], moved))
      return true;
  return false;
}

}  // namespace

std::vector<int> bodies_of_open_bending(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  std::vector<int> out;
  const auto is_one = [](const BodyData& b) { return b.elastodynamic && b.modes > 0; };
  if (m.equations == 0 || std::none_of(m.bodies.begin(), m.bodies.end(), is_one)) return out;
  const ScaledJacobian jacobian = scaled_jacobian(system, s);
  const linalg::SparseQr qr(jacobian.transposed, nearly_redundant);
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m.velocities), none = Eigen::VectorXd::Zero(m.equations);
  for (const Eigen::VectorXd& forces : forces_that_go_round(jacobian, qr)) {
    const std::vector<double> size = borne(system, s, forces);
    const double largest = *std::max_element(size.begin(), size.end());
    Eigen::VectorXd with(m.velocities), without(m.velocities);
    system.residual(s.time, s.q.data(), rest.data(), rest.data(), forces.data(), 0, with.data());
    system.residual(s.time, s.q.data(), rest.data(), rest.data(), none.data(), 0, without.data());
    for (const BodyData& b : m.bodies) {
      if (!is_one(b) || std::find(out.begin(), out.end(), b.spec) != out.end()) continue;
      const spec::Body& body = m.spec().bodies[static_cast<std::size_t>(b.spec)];
      if (bends(b, *body.flexible, largest, m.length_scale, with - without)) out.push_back(b.spec);
    }
  }
  return out;
}

Redundancy find_redundancy(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  Redundancy out;
  if (m.equations == 0) return out;
  const ScaledJacobian jacobian = scaled_jacobian(system, s);
  const linalg::SparseQr sharp(jacobian.transposed, redundant);
  out.equations = m.equations - sharp.rank();
  const std::vector<bool> surely = concerned(system, s, jacobian, sharp, 1e-6);
  std::vector<bool> nearly(surely.size(), false);
  if (sharp.least_pivot() <= nearly_redundant) {
    const linalg::SparseQr loose(jacobian.transposed, nearly_redundant);
    out.nearly = sharp.rank() - loose.rank();
    nearly = concerned(system, s, jacobian, loose, 1e-3);
  }
  const std::size_t joints = m.spec().joints.size();
  for (std::size_t j = 0; j < joints; ++j) {
    if (surely[j]) out.joints.push_back(m.spec().joints[j].name);
    if (nearly[j]) out.nearly_joints.push_back(m.spec().joints[j].name);
  }
  for (std::size_t k = 0; k < m.constraints.size(); ++k) {
    const std::string& name = m.spec().constraints[m.constraints[k].spec].name;
    if (surely[joints + k]) out.constraints.push_back(name);
    if (nearly[joints + k]) out.nearly_constraints.push_back(name);
  }
  return out;
}

}  // namespace mimbre
