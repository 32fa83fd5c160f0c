#include "analysis/modes/sparse_modes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/linear_description.h"
#include "analysis/modal_scales.h"
#include "analysis/modes/mode_shapes.h"
#include "analysis/modes/mode_shares.h"
#include "analysis/modes/sparse_core.h"
#include "integrate/sparse_statics.h"
#include "math/once/decompositions.h"
#include "math/once/general_eigen.h"
#include "mimbre/diagnostics.h"
#include "simulation/start/assembly.h"

namespace mimbre::linear {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

/// Unbalanced work, of the weight of the heaviest part moved by its scale: beyond, it is no equilibrium.
constexpr double unbalanced_share = 1e-5;

/// δ of the relative coordinates of motions in natural coordinates.
class RelativeMotions {
 public:
  RelativeMotions(natural::NaturalSystem& system, const State& natural, const State& relative)
      : system_(system), natural_(natural), relative_(relative) {}
  VectorXd of(const VectorXd& x) {
    natural_.v = x;
    system_.to_relative(natural_, relative_);
    return relative_.v;
  }
  VectorXcd of(const VectorXcd& x) {
    VectorXcd out(relative_.v.size());
    out.real() = of(VectorXd(x.real()));
    out.imag() = of(VectorXd(x.imag()));
    return out;
  }

 private:
  natural::NaturalSystem& system_;
  State natural_, relative_;
};

/// Whether the eigenvalue is that of a neighbour, too.
bool equal_values(const VectorXcd& values, Eigen::Index k) {
  const auto same = [&](Eigen::Index other) {
    return other >= 0 && other < values.size() &&
           std::abs(values[other] - values[k]) <= 1e-7 * std::abs(values[k]);
  };
  return same(k - 1) || same(k + 1);
}

/// Rows wᴴ with wᴴ z = 1 of each mode's own z = (x, λ x) and 0 of the others', as columns w: those of the
/// pencil of first order, wᵀ = (y, λ y)ᵀ [C M; M 0]. y is x where the matrices are symmetric, otherwise the
/// vector of the transposed matrices.
MatrixXcd left_vectors(const linalg::ConstrainedPencil& pencil, const linalg::ConstrainedModes& found) {
  const Eigen::Index n = pencil.M.rows(), count = found.values.size();
  linalg::ConstrainedModes transposed;
  if (!found.symmetric)
    transposed =
        linalg::lowest_modes({pencil.M.transpose(), pencil.C.transpose(), pencil.K.transpose(), pencil.J},
                             static_cast<int>(count + found.rigid.cols()));
  if (!found.symmetric && (!transposed.ok || transposed.values.size() < count))
    return MatrixXcd::Zero(2 * n, count);
  const linalg::ConstrainedModes& by = found.symmetric ? found : transposed;
  const VectorXcd lambda = by.values.head(count);
  const MatrixXcd y = by.vectors.leftCols(count), My = pencil.M.transpose().cast<std::complex<double>>() * y,
                  Cy = pencil.C.transpose().cast<std::complex<double>>() * y;
  MatrixXcd rows(count, 2 * n), z(2 * n, count);
  rows << (Cy + My * lambda.asDiagonal()).transpose(), My.transpose();
  z << found.vectors, found.vectors * found.values.asDiagonal();
  const MatrixXcd inverse = complex_inverse(rows * z);
  if (!inverse.allFinite()) return MatrixXcd::Zero(2 * n, count);
  return (inverse * rows).adjoint();
}

/// The motions found, in relative coordinates, with names and shares of energy.
LinearisedModes described(const Linearised& located, const State& relative, const SparseEquations& equations,
                          const linalg::ConstrainedModes& found, const relative::RelativeSystem& observer,
                          RelativeMotions& motions) {
  const Compiled& m = located.model->compiled();
  LinearisedModes out;
  out.sparse = true;
  out.model = located.names;
  out.model.title = m.spec().title;
  out.model.time = relative.time;
  out.model.notes.push_back("the lowest modes by sparse matrices, shifted and inverted");
  for (int k = 0; k < m.velocities; ++k) out.coordinates.push_back(coordinate_label(m, k));
  Linearised at;
  at.model = located.model;
  at.state = relative;
  ModeShares shares(at);
  const Scales scales = modal_scales(m, observer.scales());
  const VectorXd scale = Eigen::Map<const VectorXd>(scales.coordinates.data(), m.velocities);
  /// `x`: the motion along the scales, with its left vector; `stiffness`: that of it.
  const auto add = [&](Mode mode, const VectorXcd& x, const VectorXcd& left, double stiffness, bool mixed) {
    const VectorXcd natural = equations.scale.cast<std::complex<double>>().cwiseProduct(x);
    mode.motion = motions.of(natural);
    const std::complex<double> factor = normalise(mode.motion, mode.motion.size(), scale);
    mode.shape.resize(2 * natural.size());
    mode.shape << factor * natural, factor * mode.value * natural;
    mode.left =
        left.cwiseQuotient(std::conj(factor) * equations.scale.replicate(2, 1).cast<std::complex<double>>());
    shares.describe_motion(mode, 0.5 * std::norm(factor) * stiffness, mixed);
    out.modes.push_back(std::move(mode));
  };
  MatrixXd rigid(m.velocities, found.rigid.cols());
  for (Eigen::Index k = 0; k < rigid.cols(); ++k)
    rigid.col(k) =
        motions.of(VectorXd(equations.scale.cwiseProduct(found.rigid.col(k)))).cwiseQuotient(scale);
  // Simple ones of the motions found.
  const MatrixXd simple = found.rigid * least_squares(rigid, echelon(rigid));
  const VectorXcd none = VectorXcd::Zero(2 * equations.scale.size());
  for (Eigen::Index k = 0; k < rigid.cols(); ++k) {
    Mode mode;
    mode.kind = Mode::Kind::rigid;
    add(std::move(mode), simple.col(k).cast<std::complex<double>>(), none, 0, rigid.cols() > 1);
  }
  const MatrixXcd left = left_vectors(equations.pencil, found);
  for (Eigen::Index k = 0; k < found.values.size(); ++k) {
    const VectorXcd x = found.vectors.col(k), stiff = equations.pencil.K.cast<std::complex<double>>() * x;
    add(mode_of(found.values[k], 0), x, left.col(k), std::real(x.dot(stiff)), equal_values(found.values, k));
  }
  return out;
}

}  // namespace

std::optional<LinearisedModes> sparse_modes(const Linearised& located, int most, std::string& why) {
  const Compiled& m = located.model->compiled();
  why = m.velocities == 0 ? "nothing can move" : not_sparse(m);
  if (!why.empty()) return {};
  State relative = located.state;
  if (relative.v.size() > 0 && relative.v.cwiseAbs().maxCoeff() > 0) {
    why = "the mechanism moves at the point";
    return {};
  }
  relative.a.setZero(m.velocities);
  std::optional<natural::NaturalSystem> system;
  try {
    system.emplace(m);
  } catch (const InputError& error) {
    why = error.what();
    return {};
  }
  relative::RelativeSystem observer(m);
  observer.enter_rest(relative.u.data(), relative.z.data());
  State natural = natural_state(*system, observer, relative);
  natural.v.setZero();
  natural.a.setZero();
  system->enter_rest(relative.u.data(), relative.z.data());
  find_sparse_multipliers(*system, natural);
  SparseEquations equations;
  try {
    equations =
        sparse_equations(*system, natural, relative.u, relative.z, work_of_forces(m, observer, relative));
  } catch (const std::runtime_error& error) {
    why = error.what();
    return {};
  }
  if (equations.unbalanced > unbalanced_share) {
    why = "the point is no equilibrium";
    return {};
  }
  const linalg::ConstrainedModes found = linalg::lowest_modes(equations.pencil, most);
  if (!found.ok) {
    why = "the iteration did not converge";
    return {};
  }
  RelativeMotions motions(*system, natural, relative);
  return described(located, relative, equations, found, observer, motions);
}

}  // namespace mimbre::linear
