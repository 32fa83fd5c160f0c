#include "simulation/describe/singular_position.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "integrate/initial.h"
#include "math/once/decompositions.h"

namespace mimbre {
namespace {

constexpr int most_equations = 300;
/// Of the Jacobian's singular value that goes to 0 there, as a share of the one in the middle.
constexpr double near = 0.05;

}  // namespace

bool is_near_singular(relative::RelativeSystem& system, const State& s, int redundant) {
  const int m = system.equations(), n = system.velocities(), rank = m - redundant;
  if (rank < 2 || rank > n || m > most_equations) return false;
  const Scales& scales = system.scales();
  system.begin_step(s.q.data());
  Eigen::MatrixXd jacobian = dense_jacobian(system, s.time, s.q);
  for (int k = 0; k < m; ++k) jacobian.row(k) /= scales.equations[static_cast<std::size_t>(k)];
  for (int k = 0; k < n; ++k) jacobian.col(k) *= scales.coordinates[static_cast<std::size_t>(k)];
  const Eigen::VectorXd squares = symmetric_eigenvalues(jacobian * jacobian.transpose());
  const double least = std::sqrt(std::max(squares[m - rank], 0.0)),
               middle = std::sqrt(squares[m - rank + rank / 2]);
  return least < near * middle;
}

}  // namespace mimbre
