#include "integrate/sparse_jacobian.h"

#include <cmath>
#include <vector>

namespace mimbre {

namespace {

/// Of the scale of an equation: it does not depend on the coordinates.
constexpr double least_length = 1e-9;

}  // namespace

SparseJacobian sparse_jacobian(const System& system) {
  const int m = system.equations();
  const Scales& scales = system.scales();
  SparseJacobian out{linalg::SparseMatrix(m, system.velocities()), Eigen::VectorXd::Zero(m)};
  if (m == 0) return out;
  std::vector<Eigen::Triplet<double>> entries;
  for (const JacobianEntry& e : system.jacobian_entries()) {
    const double value = e.value * scales.coordinates[static_cast<std::size_t>(e.coordinate)];
    out.rows[e.equation] += value * value;
    entries.emplace_back(e.equation, e.coordinate, value);
  }
  out.J.setFromTriplets(entries.begin(), entries.end());
  for (int k = 0; k < m; ++k) {
    const double length = std::sqrt(out.rows[k]);
    out.rows[k] = length > least_length * scales.equations[static_cast<std::size_t>(k)] ? 1 / length : 0;
  }
  out.J = (out.rows.asDiagonal() * out.J).eval();
  return out;
}

}  // namespace mimbre
