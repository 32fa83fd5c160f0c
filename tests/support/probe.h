#pragma once
#include <functional>

#include "support/dense.h"
#include "support/random_mechanism.h"

/// The relative formulation as plain functions of positions, velocities and accelerations, and what the tests
/// hold against it: energies and mass matrices from the bodies' data, in global axes.
namespace mimbre::test {

/// Mass matrix of one body, (6 + modes) square, for velocity of the origin and angular velocity in global
/// axes and modal rates; Lugrís 2008, 3.51–3.71, written with plain loops.
MatrixXd body_mass_matrix(const spec::Body& body, const Mat3d& A, const VectorXd& y);

class Probe {
 public:
  using OfPosition = std::function<VectorXd(const VectorXd& q)>;
  using OfMotion = std::function<VectorXd(const VectorXd& q, const VectorXd& v, double s)>;

  explicit Probe(const Compiled& compiled,
                 spec::Simulation::Inertia inertia = spec::Simulation::Inertia::integrals);

  VectorXd moved(const VectorXd& q, const VectorXd& x) const;
  VectorXd unit(int k, double size = 1) const;

  VectorXd residual(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t = 0);
  VectorXd residual(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t,
                    const VectorXd& multipliers);
  /// The assembled matrix at q with velocities v.
  MatrixXd matrix(const VectorXd& q, const VectorXd& v, const MatrixWeights& weights);
  void kinematics(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t = 0);
  VectorXd phi(const VectorXd& q, double t = 0);
  VectorXd phi_dot(const VectorXd& q, const VectorXd& v, double t = 0);
  VectorXd phi_ddot(const VectorXd& q, const VectorXd& v, const VectorXd& a, double t = 0);
  /// Φz as the system gives it.
  MatrixXd jacobian(const VectorXd& q);
  /// Gradient with respect to increments by central differences of a function of q.
  MatrixXd gradient(const VectorXd& q, const OfPosition& f, double h = 1e-5) const;
  /// d/ds at 0 of f(q(s), v(s), s) along the motion with velocities v and accelerations a.
  VectorXd rate(const VectorXd& q, const VectorXd& v, const VectorXd& a, const OfMotion& f,
                double h = 1e-4) const;

  VectorXd modes(int body, const VectorXd& x, bool velocity) const;
  /// Velocities of all bodies (origin, angular, modal rates; global axes, one below the other) per unit of v.
  MatrixXd body_velocities(const VectorXd& q);
  /// Σ Rᵀ M̄ R from the bodies' own matrices.
  MatrixXd projected_mass(const VectorXd& q);
  double kinetic(const VectorXd& q, const VectorXd& v);
  /// ∂T/∂v, exact because T is quadratic.
  VectorXd momentum(const VectorXd& q, const VectorXd& v);
  /// Gravity, elastic bodies, elastic laws of springs and joint springs, tyres.
  double potential(const VectorXd& q);
  /// After kinematics().
  double spring_length(const ElementData& s) const;

  const Compiled& m;
  relative::RelativeSystem system;
  int n, equations;
  VectorXd zero, none;
};

}  // namespace mimbre::test
