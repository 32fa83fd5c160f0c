#include "support/probe.h"

#include "spec/force_law.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mimbre::test {

MatrixXd body_mass_matrix(const spec::Body& body, const Mat3d& A, const VectorXd& y) {
  if (!body.flexible) {
    const Vec3d first = A * (body.mass * body.com);
    const Mat3d arm = skew<double>(A * body.com);
    MatrixXd M(6, 6);
    M.topLeftCorner<3, 3>() = body.mass * Mat3d::Identity();
    M.topRightCorner<3, 3>() = -skew<double>(first);
    M.bottomLeftCorner<3, 3>() = skew<double>(first);
    M.bottomRightCorner<3, 3>() = A * body.inertia * A.transpose() - body.mass * arm * arm;
    return M;
  }
  const ReducedBody& f = *body.flexible;
  const int n = f.modes;
  // S'^i: row j of S̄^i + yᵀ S^ij.
  std::array<Eigen::Matrix3Xd, 3> deformed = f.S_position;
  Mat3d second = f.second_moment;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Eigen::RowVectorXd more =
          y.transpose() * f.S_modes[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      deformed[static_cast<std::size_t>(i)].row(j) += more;
      second(i, j) += f.S_position[static_cast<std::size_t>(i)].row(j).dot(y) +
                      f.S_position[static_cast<std::size_t>(j)].row(i).dot(y) + more.dot(y);
    }
  const Vec3d first = A * (f.first_moment + f.S * y);
  Eigen::Matrix3Xd coupling(3, n);  // ∫ r̄ × X dm
  for (int a = 0; a < 3; ++a) {
    const std::size_t b = static_cast<std::size_t>((a + 1) % 3), c = static_cast<std::size_t>((a + 2) % 3);
    coupling.row(a) = deformed[b].row(static_cast<int>(c)) - deformed[c].row(static_cast<int>(b));
  }
  MatrixXd M(6 + n, 6 + n);
  M.block<3, 3>(0, 0) = f.mass * Mat3d::Identity();
  M.block<3, 3>(0, 3) = -skew<double>(first);
  M.block<3, 3>(3, 3) = A * (second.trace() * Mat3d::Identity() - second) * A.transpose();
  M.block(0, 6, 3, n) = A * f.S;
  M.block(3, 6, 3, n) = A * coupling;
  M.bottomRightCorner(n, n) = f.mass_matrix;
  M.triangularView<Eigen::StrictlyLower>() = M.transpose();
  return M;
}

Probe::Probe(const Compiled& compiled, spec::Simulation::Inertia inertia)
    : m(compiled),
      system(compiled, inertia),
      n(compiled.velocities),
      equations(compiled.equations),
      zero(VectorXd::Zero(n)),
      none(VectorXd::Zero(equations)) {}

VectorXd Probe::moved(const VectorXd& q, const VectorXd& x) const {
  VectorXd out(q.size());
  system.retract(q.data(), x.data(), out.data());
  return out;
}

VectorXd Probe::unit(int k, double size) const { return size * VectorXd::Unit(n, k); }

VectorXd Probe::residual(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t) {
  return residual(q, v, a, t, none);
}

VectorXd Probe::residual(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t,
                         const VectorXd& multipliers) {
  VectorXd r(n);
  system.residual(t, q.data(), v.data(), a.data(), multipliers.data(), 0, r.data());
  return r;
}

MatrixXd Probe::matrix(const VectorXd& q, const VectorXd& v, const MatrixWeights& weights) {
  residual(q, v, zero);
  system.assemble(q.data(), weights);
  MatrixXd A(n, n);
  for (int k = 0; k < n; ++k) {
    const VectorXd e = unit(k);
    system.multiply(e.data(), A.col(k).data());
  }
  return A;
}

void Probe::kinematics(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t) {
  system.kinematics(t, q.data(), v.data(), a.data());
}

VectorXd Probe::phi(const VectorXd& q, double t) {
  kinematics(q, zero, zero, t);
  return Eigen::Map<const VectorXd>(system.phi(), equations);
}

VectorXd Probe::phi_dot(const VectorXd& q, const VectorXd& v, double t) {
  kinematics(q, v, zero, t);
  return Eigen::Map<const VectorXd>(system.phi_dot(), equations);
}

VectorXd Probe::phi_ddot(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t) {
  kinematics(q, v, a, t);
  return Eigen::Map<const VectorXd>(system.phi_ddot(), equations);
}

MatrixXd Probe::jacobian(const VectorXd& q) {
  residual(q, zero, zero);
  system.factor(q.data(), {});
  MatrixXd J(equations, n);
  for (int k = 0; k < n; ++k) {
    const VectorXd e = unit(k);
    system.jacobian_times(e.data(), J.col(k).data());
  }
  return J;
}

MatrixXd Probe::gradient(const VectorXd& q, const OfPosition& f, double h) const {
  MatrixXd G;
  for (int k = 0; k < n; ++k) {
    const auto at = [&](double x) -> VectorXd { return f(moved(q, unit(k, x))); };
    const VectorXd d = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
    if (k == 0) G.resize(d.size(), n);
    G.col(k) = d;
  }
  return G;
}

VectorXd Probe::rate(const VectorXd& q, const VectorXd& v, const VectorXd& a, const OfMotion& f,
                     double h) const {
  const auto at = [&](double s) -> VectorXd {
    return f(moved(q, s * v + 0.5 * s * s * a), VectorXd(v + s * a), s);
  };
  return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
}

VectorXd Probe::modes(int body, const VectorXd& x, bool velocity) const {
  const BodyData& b = m.bodies[static_cast<std::size_t>(body)];
  return velocity ? VectorXd(x.segment(b.v + b.joint_velocities, b.modes))
                  : VectorXd(x.segment(b.q + b.joint_positions, b.modes));
}

MatrixXd Probe::body_velocities(const VectorXd& q) {
  int rows = 0;
  for (const BodyData& b : m.bodies) rows += 6 + b.modes;
  MatrixXd R(rows, n);
  for (int k = 0; k < n; ++k) {
    const VectorXd v = unit(k);
    kinematics(q, v, zero);
    int at = 0;
    for (int i = 0; i < static_cast<int>(m.bodies.size()); ++i) {
      const auto& motion = system.workspace().bodies[static_cast<std::size_t>(i)];
      const int width = m.bodies[static_cast<std::size_t>(i)].modes;
      R.block<3, 1>(at, k) = motion.velocity;
      R.block<3, 1>(at + 3, k) = motion.omega;
      R.block(at + 6, k, width, 1) = modes(i, v, true);
      at += 6 + width;
    }
  }
  return R;
}

MatrixXd Probe::projected_mass(const VectorXd& q) {
  const MatrixXd R = body_velocities(q);
  MatrixXd M = MatrixXd::Zero(n, n);
  int at = 0;
  for (int i = 0; i < static_cast<int>(m.bodies.size()); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const MatrixXd body = body_mass_matrix(m.spec().bodies[static_cast<std::size_t>(m.bodies[index].spec)],
                                           system.workspace().bodies[index].rotation, modes(i, q, false));
    M += R.middleRows(at, body.rows()).transpose() * body * R.middleRows(at, body.rows());
    at += static_cast<int>(body.rows());
  }
  return M;
}

double Probe::kinetic(const VectorXd& q, const VectorXd& v) {
  kinematics(q, v, zero);
  double energy = 0;
  for (int i = 0; i < static_cast<int>(m.bodies.size()); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const auto& motion = system.workspace().bodies[index];
    VectorXd u(6 + m.bodies[index].modes);
    u << motion.velocity, motion.omega, modes(i, v, true);
    energy += 0.5 * u.dot(body_mass_matrix(m.spec().bodies[static_cast<std::size_t>(m.bodies[index].spec)],
                                           motion.rotation, modes(i, q, false)) *
                          u);
  }
  return energy;
}

VectorXd Probe::momentum(const VectorXd& q, const VectorXd& v) {
  VectorXd p(n);
  for (int k = 0; k < n; ++k) p[k] = 0.5 * (kinetic(q, v + unit(k)) - kinetic(q, v - unit(k)));
  return p;
}

double Probe::potential(const VectorXd& q) {
  kinematics(q, zero, zero);
  const auto& w = system.workspace();
  double energy = 0;
  for (int i = 0; i < static_cast<int>(m.bodies.size()); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const spec::Body& body = m.spec().bodies[static_cast<std::size_t>(m.bodies[index].spec)];
    double mass = body.mass;
    Vec3d first = body.mass * body.com;
    if (body.flexible) {
      const VectorXd y = modes(i, q, false);
      mass = body.flexible->mass;
      first = body.flexible->first_moment + body.flexible->S * y;
      energy += 0.5 * y.dot(body.flexible->stiffness * y);
    }
    energy -= m.gravity.dot(mass * (w.bodies[index].position + w.origin) + w.bodies[index].rotation * first);
  }
  for (const ElementData& e : m.elements) {
    if (e.law == find_law("spring")) {
      const FunctionData& elastic = m.functions[static_cast<std::size_t>(e.functions)];
      energy += elastic.antiderivative(e.measure == Measure::distance ? spring_length(e) : q[e.q]);
    }
    if (e.law != find_law("tyre")) continue;
    const spec::Tyre& t = m.spec().tyres[static_cast<std::size_t>(e.spec)];
    const Vec3d wheel = w.frames[static_cast<std::size_t>(e.frame_b)].position + w.origin;
    const double penetration =
        t.radius - (wheel[2] - m.roads[static_cast<std::size_t>(e.road)].height.value(wheel[0]));
    if (penetration > 0) energy += 0.5 * t.stiffness * penetration * penetration;
  }
  return energy;
}

double Probe::spring_length(const ElementData& s) const {
  const auto& frames = system.workspace().frames;
  return (frames[static_cast<std::size_t>(s.frame_b)].position -
          frames[static_cast<std::size_t>(s.frame_a)].position)
      .norm();
}

}  // namespace mimbre::test
