#include "fe_files/bodies/frame_force_stiffness.h"

#include <Eigen/Core>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fe_files/bodies/cross_integrals.h"
#include "math/once/decompositions.h"

// With s the body's loads of inertia, f_l the forces on the modes by a unit of load l, F the forces and
// torques on the frames and P the frames' displacements by the amplitudes, a body at rest in its frame has
//   K y = Σ s_l f_l + Pᵀ F.
// A boundary load b y is the work of that on the deformation z with K z = bᵀ (a static mode):
//   b y = zᵀ K y = Σ s_l zᵀ f_l + (P z)ᵀ F,
// which shares its matrix out among the loads of inertia and the forces.

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int kInertiaCount = GeometricStiffness::boundary;
constexpr int kEntries[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};

/// f_l: modes × 12.
MatrixXd inertia_forces(const ReducedBody& body) {
  MatrixXd forces(body.modes, kInertiaCount);
  for (int m = 0; m < body.modes; ++m)
    forces.row(m).segment<6>(GeometricStiffness::angular_velocity) = -centrifugal(position_integral(body, m));
  forces.middleCols<3>(GeometricStiffness::acceleration) = -body.S.transpose();
  forces.middleCols<3>(GeometricStiffness::angular_acceleration) = -angular_coupling(body).transpose();
  return forces;
}

MatrixXd frame_motions(const ReducedBody& body) {
  MatrixXd P(6 * static_cast<Index>(body.frames.size()), body.modes);
  for (std::size_t i = 0; i < body.frames.size(); ++i) {
    P.middleRows<3>(6 * static_cast<Index>(i)) = body.frames[i].X;
    P.middleRows<3>(6 * static_cast<Index>(i) + 3) = body.frames[i].X_theta;
  }
  return P;
}

void add(MatrixXd& sum, double factor, const MatrixXd& matrix) {
  if (factor == 0) return;
  if (sum.size() == 0)
    sum = factor * matrix;
  else
    sum += factor * matrix;
}

using Inertia = std::array<MatrixXd, kInertiaCount>;

double largest(const MatrixXd& matrix) { return matrix.size() > 0 ? matrix.cwiseAbs().maxCoeff() : 0; }

/// Takes out of `after` what is only the round-off of sums with `before`: against the largest of its kind.
void clean(const Inertia& before, Inertia& after) {
  constexpr double digits = 1e-9;
  for (const auto& [first, count] : {std::pair{0, 6}, {6, 3}, {9, 3}}) {
    double most = 0;
    for (int c = first; c < first + count; ++c)
      for (const Inertia* matrices : {&before, static_cast<const Inertia*>(&after)})
        most = std::max(most, largest((*matrices)[static_cast<std::size_t>(c)]));
    for (int c = first; c < first + count; ++c)
      if (MatrixXd& matrix = after[static_cast<std::size_t>(c)]; largest(matrix) <= digits * most)
        matrix.resize(0, 0);
  }
}

}  // namespace

bool FrameForceStiffness::any() const {
  const auto there = [](const MatrixXd& matrix) { return matrix.size() > 0; };
  return std::any_of(inertia.begin(), inertia.end(), there) ||
         std::any_of(forces.begin(), forces.end(), there);
}

Eigen::Matrix<double, 1, 6> centrifugal(const Eigen::Matrix3d& A) {
  Eigen::Matrix<double, 1, 6> result;
  for (int c = 0; c < 6; ++c) {
    const int a = kEntries[c][0], b = kEntries[c][1];
    result(c) = a == b ? A(a, a) - A.trace() : A(a, b) + A(b, a);
  }
  return result;
}

FrameForceStiffness by_frame_forces(const ReducedBody& body) {
  FrameForceStiffness out;
  out.forces.resize(6 * body.frames.size());
  if (!body.geometric) return out;
  const GeometricStiffness& g = *body.geometric;
  for (std::size_t l = 0; l < g.loads.size(); ++l)
    if (g.loads[l] < kInertiaCount) out.inertia[static_cast<std::size_t>(g.loads[l])] = g.stiffness[l];
  if (g.boundary_loads.rows() == 0) return out;
  const Cholesky K(body.stiffness);
  if (!K.ok())
    throw std::invalid_argument(
        "the geometric stiffness by forces of static modes cannot be given by forces at frames: the "
        "stiffness "
        "is not positive definite");
  const MatrixXd z = K.solve(g.boundary_loads.transpose());
  const MatrixXd from_inertia = inertia_forces(body).transpose() * z, from_frames = frame_motions(body) * z;
  for (Index i = 0; i < from_frames.rows(); ++i)
    // Those of a frame that moves are there even where they are zero: they show which frames count.
    if (!from_frames.middleRows<6>(6 * (i / 6)).isZero(0))
      out.forces[static_cast<std::size_t>(i)] = MatrixXd::Zero(body.modes, body.modes);
  for (std::size_t l = 0; l < g.loads.size(); ++l) {
    const Index row = g.loads[l] - kInertiaCount;
    if (row < 0) continue;
    for (Index c = 0; c < kInertiaCount; ++c)
      add(out.inertia[static_cast<std::size_t>(c)], from_inertia(c, row), g.stiffness[l]);
    for (Index i = 0; i < from_frames.rows(); ++i)
      add(out.forces[static_cast<std::size_t>(i)], from_frames(i, row), g.stiffness[l]);
  }
  clean(out.inertia, out.inertia);
  return out;
}

std::string take_frame_forces(const FrameForceStiffness& given, ReducedBody& body) {
  body.geometric.reset();
  if (!given.any()) return {};
  const Index n = body.modes;
  Inertia inertia = given.inertia;
  std::vector<MatrixXd> boundary;
  MatrixXd loads(0, n);
  std::string left_out;
  std::vector<Index> rows, taken;
  const MatrixXd motions = frame_motions(body);
  for (Index i = 0; i < motions.rows() && i < static_cast<Index>(given.forces.size()); ++i)
    if (given.forces[static_cast<std::size_t>(i)].size() > 0 && !motions.row(i).isZero(0)) rows.push_back(i);
  const Cholesky K(body.stiffness);
  if (!rows.empty() && !K.ok()) {
    left_out =
        "the stiffening by forces at nodes is left out: the stiffness is not positive definite, so "
        "amplitudes do not determine the forces";
  } else if (!rows.empty()) {
    // F with P K⁻¹ Pᵀ F = P y and, where frames depend on each other, the least forces that do it, measured
    // by what each deflects: with K = L Lᵀ and rows of length 1 in A = S P L⁻ᵀ it is S A⁺ᵀ Lᵀ y.
    MatrixXd A = K.solve_lower(motions(rows, Eigen::all).transpose()).transpose();
    const Eigen::VectorXd S = A.rowwise().norm().cwiseInverse();
    A = S.asDiagonal() * A;
    const MatrixXd F = S.asDiagonal() * (pseudo_inverse(A, 1e-7).transpose() * K.lower().transpose());
    const MatrixXd from_inertia = inertia_forces(body).transpose() * K.solve(F.transpose());
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const MatrixXd& stiffness = given.forces[static_cast<std::size_t>(rows[r])];
      if (stiffness.isZero(0)) continue;
      for (Index c = 0; c < kInertiaCount; ++c)
        add(inertia[static_cast<std::size_t>(c)], -from_inertia(c, static_cast<Index>(r)), stiffness);
      boundary.push_back(stiffness);
      taken.push_back(static_cast<Index>(r));
    }
    loads = F(taken, Eigen::all);
    if (loads.rows() > n) {  // no more than the amplitudes are needed
      std::vector<MatrixXd> of_amplitudes(static_cast<std::size_t>(n), MatrixXd::Zero(n, n));
      for (Index m = 0; m < n; ++m)
        for (Index r = 0; r < loads.rows(); ++r)
          of_amplitudes[static_cast<std::size_t>(m)] += loads(r, m) * boundary[static_cast<std::size_t>(r)];
      boundary = std::move(of_amplitudes);
      loads = MatrixXd::Identity(n, n);
    }
  }
  clean(given.inertia, inertia);
  GeometricStiffness g;
  const auto take = [&](Index number, const MatrixXd& matrix) {
    g.loads.push_back(static_cast<int>(number));
    g.stiffness.push_back(0.5 * (matrix + matrix.transpose()));
  };
  for (Index c = 0; c < kInertiaCount; ++c)
    if (const MatrixXd& matrix = inertia[static_cast<std::size_t>(c)]; matrix.size() > 0) take(c, matrix);
  for (std::size_t r = 0; r < boundary.size(); ++r) take(kInertiaCount + static_cast<Index>(r), boundary[r]);
  g.boundary_loads = std::move(loads);
  if (!g.loads.empty()) body.geometric = std::move(g);
  return left_out;
}

}  // namespace mimbre::fe
