#include "analysis/modes/sparse_core.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "analysis/linear_element.h"
#include "base/random_numbers.h"
#include "dynamics/modal_scale.h"
#include "dynamics/natural/column_groups.h"
#include "dynamics/natural/joint_positions.h"
#include "dynamics/natural/residual.h"
#include "integrate/sparse_jacobian.h"
#include "linalg/colouring.h"
#include "math/dual.h"

namespace mimbre::linear {

using Eigen::VectorXd;
using linalg::SparseMatrix;

namespace {

/// Of the largest entry of a product: entries elsewhere than in the pattern.
constexpr double stray = 1e-9;

/// The residual in natural coordinates over dual numbers.
class NaturalCore {
 public:
  NaturalCore(const natural::NaturalSystem& system, const State& s, const VectorXd& u, const VectorXd& z)
      : m_(system.model()),
        l_(system.layout()),
        time_(s.time),
        work_(m_, l_),
        numbers_(m_.numbers.begin(), m_.numbers.end()),
        held_(u.begin(), u.end()),
        states_(z.begin(), z.end()),
        q_(s.q.begin(), s.q.end()),
        moved_(q_.size()),
        v_(static_cast<std::size_t>(l_.unknowns), Dual(0)),
        a_(v_),
        r_(v_),
        mu_(s.multipliers.begin(), s.multipliers.end()) {
    if (m_.signals.clock >= 0) held_[static_cast<std::size_t>(m_.signals.clock)] = Dual(s.time);
    work_.signals.enter(held_.data(), states_.data(), 0);
    work_.signals.moves = false;
    work_.signals.numbers = numbers_.data();
    for (std::size_t f = 0; f < m_.frames.size(); ++f)
      if (m_.frames[f].body < 0) work_.frames[f] = natural::ground_frame<Dual>(m_.frames[f], l_.origin);
  }

  enum class By { positions, velocities, accelerations };

  /// Derivative of r along x.
  void along(By by, const VectorXd& x, VectorXd& y) {
    std::copy(q_.begin(), q_.end(), moved_.begin());
    for (int k = 0; k < l_.unknowns; ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (by == By::positions) moved_[i].derivative = x[k];
      v_[i] = Dual(0, by == By::velocities ? x[k] : 0);
      a_[i] = Dual(0, by == By::accelerations ? x[k] : 0);
    }
    natural::joint_positions<Dual>(m_, l_, work_, moved_.data());
    natural::kinematics<Dual>(m_, l_, work_, moved_.data(), v_.data(), a_.data());
    fix_signals(m_.signals, time_, work_.signals);
    natural::constraints<Dual>(m_, l_, work_, moved_.data());
    natural::residual<Dual>(m_, l_, work_, moved_.data(), mu_.data(), r_.data());
    for (int k = 0; k < l_.unknowns; ++k) y[k] = r_[static_cast<std::size_t>(k)].derivative;
  }

  VectorXd residual() const {
    VectorXd out(l_.unknowns);
    for (int k = 0; k < l_.unknowns; ++k) out[k] = r_[static_cast<std::size_t>(k)].value;
    return out;
  }

 private:
  const Compiled& m_;
  const natural::Layout& l_;
  double time_;
  natural::Workspace<Dual> work_;
  std::vector<Dual> numbers_, held_, states_, q_, moved_, v_, a_, r_, mu_;
};

}  // namespace

std::string not_sparse(const Compiled& m) {
  for (const ElementData& e : m.elements)
    if (needs_linear_element(e)) return "force elements with states or laws of the user";
  for (const ConstraintData& c : m.constraints)
    if (c.rates > 0) return "constraints on velocities";
  if (!m.signals.blocks.empty() || !m.signals.integrals.empty()) return "signals with states";
  return {};
}

SparseEquations sparse_equations(const natural::NaturalSystem& system, const State& s, const VectorXd& u,
                                 const VectorXd& z, double at_play) {
  const natural::Layout& l = system.layout();
  const int n = l.unknowns;
  const linalg::ColumnColours colours(n, natural::column_groups(l));
  SparseEquations out;
  out.scale = Eigen::Map<const VectorXd>(system.scales().coordinates.data(), n);
  const Compiled& m = system.model();
  for (std::size_t b = 0; b < l.bodies.size(); ++b)
    for (int k = 0; k < m.bodies[b].modes; ++k)
      out.scale[l.bodies[b].q + k] = scale_by_modal_mass(m, m.bodies[b], k);
  NaturalCore core(system, s, u, z);
  using By = NaturalCore::By;
  VectorXd x(n);
  const auto matrix = [&](By by) {
    const auto product = [&](const VectorXd& in, VectorXd& y) {
      x = out.scale.cwiseProduct(in);
      core.along(by, x, y);
      y = out.scale.cwiseProduct(y);
    };
    const SparseMatrix A = colours.assemble(product);
    VectorXd probe(n), y(n);
    for (int k = 0; k < n; ++k) probe[k] = uniform_at(7, static_cast<std::uint64_t>(k)) - 0.5;
    product(probe, y);
    const VectorXd size = A.cwiseAbs() * probe.cwiseAbs();
    const VectorXd off = y - A * probe;
    if (!(off.cwiseAbs().maxCoeff() <= stray * std::max(size.maxCoeff(), y.cwiseAbs().maxCoeff())))
      throw std::runtime_error("a force acts elsewhere than between what it measures");
    return SparseMatrix(A.pruned());
  };
  out.pencil.K = matrix(By::positions);
  const VectorXd r = out.scale.cwiseProduct(core.residual());
  out.pencil.C = matrix(By::velocities);
  out.pencil.M = matrix(By::accelerations);
  const double inertia = out.pencil.M.diagonal().cwiseAbs().maxCoeff(),
               play = std::max(inertia * system.scales().acceleration, at_play);
  const double work = r.cwiseAbs().maxCoeff();
  out.unbalanced = work == 0 ? 0 : play > 0 ? work / play : 1;
  // The Jacobian as of the last matrix_values() of the system, at the same position.
  const VectorXd given = Eigen::Map<const VectorXd>(system.scales().coordinates.data(), n);
  SparseMatrix J = sparse_jacobian(system).J * out.scale.cwiseQuotient(given).asDiagonal();
  VectorXd lengths = VectorXd::Zero(J.rows());
  for (int c = 0; c < J.outerSize(); ++c)
    for (SparseMatrix::InnerIterator entry(J, c); entry; ++entry)
      lengths[entry.row()] += entry.value() * entry.value();
  for (double& length : lengths) length = length > 0 ? 1 / std::sqrt(length) : 0;
  out.pencil.J = lengths.asDiagonal() * J;
  return out;
}

}  // namespace mimbre::linear
