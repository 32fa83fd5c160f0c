#include "mimbre/modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "analysis/linear_turning.h"
#include "analysis/modal_scales.h"
#include "analysis/modes/blades.h"
#include "analysis/modes/body_shapes.h"
#include "analysis/modes/floquet.h"
#include "analysis/modes/mode_matching.h"
#include "analysis/modes/mode_shapes.h"
#include "analysis/modes/mode_shares.h"
#include "analysis/modes/sparse_modes.h"
#include "analysis/modes/zero_chains.h"
#include "base/cpu_time.h"
#include "math/elementary.h"
#include "math/once/decompositions.h"
#include "math/once/general_eigen.h"
#include "mimbre/diagnostics.h"

namespace mimbre {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

using linear::Zeros;

/// Shares of the largest entry of a matrix in units of the mechanism: less is round-off.
constexpr double nothing = 1e-9;
/// Of a stiffness before it cancels: less is the residual of the equilibrium.
constexpr double no_stiffness = 1e-8;
/// Of the largest stiffness of all coordinates that one is coupled with: where its own is less, it may have
/// it by the round-off of stiff parts, and is judged as if it were this.
constexpr double softest = 1e-5;
/// Of the largest eigenvalue: what is real or imaginary but for that is so.
constexpr double imaginary_round_off = 1e-10;
/// Of the transition over a period, by its integration.
constexpr double transition_round_off = 1e-7;

/// Scales of the states: their sizes where the motion is of the mechanism's size, and as fast as its modes.
VectorXd state_scales(const linear::Reduced& r, const std::vector<double>& coordinate_scales,
                      const std::vector<int>& independent, const std::vector<int>& moving) {
  const int y = r.coordinates, f = r.speeds;
  VectorXd scale = VectorXd::Ones(r.A.rows());
  const auto of = [&](const std::vector<int>& chosen, int k) {
    return coordinate_scales[static_cast<std::size_t>(chosen[static_cast<std::size_t>(k)])];
  };
  for (int k = 0; k < y; ++k) scale[k] = of(independent, k);
  for (int k = 0; k < f; ++k) scale[y + k] = of(moving, k);
  // A pace that makes accelerations by positions as large as velocities.
  const MatrixXd stiff =
      scale.segment(y, f).cwiseInverse().asDiagonal() * r.A.block(y, 0, f, y) * scale.head(y).asDiagonal();
  const double pace = f > 0 ? std::sqrt(stiff.cwiseAbs().maxCoeff()) : 0;
  if (pace > 0) scale.segment(y, f) *= pace;
  // States of elements and blocks by what they do.
  for (Eigen::Index k = y + f; k < scale.size(); ++k) {
    const double acts =
        f > 0
            ? (scale.segment(y, f).cwiseInverse().asDiagonal() * r.A.block(y, k, f, 1)).cwiseAbs().maxCoeff()
            : 0;
    if (acts > 0 && pace > 0) scale[k] = pace / acts;
  }
  return scale;
}

/// Of each coordinate the largest value among all that it is coupled with, itself among them.
VectorXd largest_coupled(const MatrixXd& coupling, const VectorXd& values) {
  VectorXd out = VectorXd::Constant(values.size(), -1);
  for (Eigen::Index first = 0; first < values.size(); ++first) {
    if (out[first] >= 0) continue;
    std::vector<Eigen::Index> group{first};
    out[first] = values[first];
    double largest = 0;
    for (std::size_t k = 0; k < group.size(); ++k) {
      largest = std::max(largest, values[group[k]]);
      for (Eigen::Index j = 0; j < values.size(); ++j)
        if (out[j] < 0 && (coupling(group[k], j) != 0 || coupling(j, group[k]) != 0)) {
          out[j] = values[j];
          group.push_back(j);
        }
    }
    for (const Eigen::Index k : group) out[k] = largest;
  }
  return out;
}

/// At rest in the coordinates, K y + … z = 0 and the rates of z vanish: the rank of that matrix G, along
/// scales that are sizes of stiffness before anything cancels, by the coordinates' `scales`. A vector begins
/// a chain of two (it may drift) where the left null vectors see nothing of its damping: Lᵀ [C 0; −A_zs I] X
/// singular.
Zeros zeros_of(const linear::Linearised& at, const VectorXd& scales) {
  const linear::Reduced& r = at.reduced;
  const Eigen::Index f = r.coordinates, z = r.states;
  const MatrixXd N = r.position.leftCols(f).cwiseAbs(), turn = at.derivatives.turn;
  MatrixXd G(f + z, f + z);
  // s = W y at rest.
  const MatrixXd spin = (turn * r.position.leftCols(f))(at.independent, Eigen::all);
  G.topLeftCorner(f, f) = r.stiffness;
  G.topRightCorner(f, z) = -r.mass * r.A.block(f, 2 * f, f, z);
  G.bottomLeftCorner(z, f) = r.A.block(2 * f, 0, z, f) + r.A.block(2 * f, f, z, f) * spin;
  G.bottomRightCorner(z, z) = r.A.block(2 * f, 2 * f, z, z);
  VectorXd rows = VectorXd::Ones(f + z), columns = rows;
  const MatrixXd acting = N.transpose() * at.derivatives.residual_q.cwiseAbs() * N;
  const VectorXd energies = acting.diagonal().cwiseProduct(scales.cwiseAbs2()),
                 sizes = energies.cwiseMax(softest * largest_coupled(acting + r.mass.cwiseAbs(), energies))
                             .cwiseQuotient(scales.cwiseAbs2());
  for (Eigen::Index k = 0; k < f; ++k)
    if (sizes[k] > 0) rows[k] = columns[k] = 1 / std::sqrt(sizes[k]);
  for (Eigen::Index k = f; k < f + z; ++k) {
    const double size = (rows.asDiagonal() * G.col(k)).cwiseAbs().maxCoeff();
    if (size > 0) columns[k] = 1 / size;
  }
  for (Eigen::Index k = f; k < f + z; ++k) {
    const double size = (G.row(k) * columns.asDiagonal()).cwiseAbs().maxCoeff();
    if (size > 0) rows[k] = 1 / size;
  }
  G = (rows.asDiagonal() * G * columns.asDiagonal()).eval();
  Zeros out;
  out.vectors.resize(2 * f + z, 0);
  if (G.rows() == 0) return out;
  const bool any = G.cwiseAbs().maxCoeff() > nothing;
  const MatrixXd right = any ? null_space(G, no_stiffness) : MatrixXd::Identity(f + z, f + z),
                 left = any ? null_space(G.transpose(), no_stiffness) : right;
  if (right.cols() == 0) return out;
  const MatrixXd X = columns.asDiagonal() * right, L = rows.asDiagonal() * left;
  out.vectors.resize(2 * f + z, X.cols());
  out.vectors.topRows(f) = X.topRows(f);
  out.vectors.middleRows(f, f) = spin * X.topRows(f);
  out.vectors.bottomRows(z) = X.bottomRows(z);
  MatrixXd H = MatrixXd::Zero(f + z, f + z);
  H.topLeftCorner(f, f) = r.damping;
  H.bottomLeftCorner(z, f) = -r.A.block(2 * f, f, z, f);
  H.bottomRightCorner(z, z).setIdentity();
  // Less than this share of what there was before it cancelled is round-off.
  MatrixXd sizes_of_damping = H.cwiseAbs();
  sizes_of_damping.topLeftCorner(f, f) +=
      N.transpose() * at.derivatives.residual_v.cwiseAbs() * N + at.names.speed * r.mass.cwiseAbs();
  // Null vectors are as exact as their rank: errors of them see the damping of everything else.
  const double none = nothing * (rows.asDiagonal() * sizes_of_damping * columns.asDiagonal()).maxCoeff();
  const MatrixXd size = L.cwiseAbs().transpose() * sizes_of_damping * X.cwiseAbs();
  MatrixXd seen = L.transpose() * H * X;
  for (Eigen::Index k = 0; k < seen.size(); ++k)
    if (!(std::abs(seen.data()[k]) > std::max(nothing * size.data()[k], none))) seen.data()[k] = 0;
  out.count = static_cast<int>(X.cols());
  out.count +=
      seen.isZero(0) ? static_cast<int>(X.cols()) : static_cast<int>(null_space(seen, nothing).cols());
  return out;
}

/// Motions that come back after a period: zeros of A, the transition in units of the mechanism without 1.
/// Null vectors are taken out by an orthogonal transformation until none is left: those of the rest are the
/// next ones of the chains.
Zeros staircase_zeros(const MatrixXd& A, double round_off) {
  Zeros out;
  out.vectors.resize(A.rows(), 0);
  MatrixXd rest = A;
  while (rest.rows() > 0) {
    const bool any = rest.cwiseAbs().maxCoeff() > round_off * A.cwiseAbs().maxCoeff();
    const MatrixXd free = any ? null_space(rest, round_off) : MatrixXd::Identity(rest.rows(), rest.rows());
    if (free.cols() == 0) break;
    if (out.count == 0) out.vectors = free;
    out.count += static_cast<int>(free.cols());
    if (free.cols() == rest.rows()) break;
    const MatrixXd other = null_space(free.transpose(), round_off);
    rest = (other.transpose() * rest * other).eval();
  }
  return out;
}

/// The motion's largest entry becomes 1.
void normalise_motion(VectorXcd& x, int coordinates, const VectorXd& scale) {
  const bool moves = coordinates > 0 && x.head(coordinates).norm() > 0;
  linear::normalise(x, moves ? coordinates : x.size(), scale);
}

/// Rigid motions by columns of `free`, along the scales.
std::vector<Mode> rigid_modes(const MatrixXd& free, int coordinates, const VectorXd& scale) {
  std::vector<Mode> modes;
  for (Eigen::Index k = 0; k < free.cols(); ++k) {
    Mode mode;
    mode.kind = Mode::Kind::rigid;
    mode.shape = (scale.asDiagonal() * free.col(k)).cast<std::complex<double>>();
    normalise_motion(mode.shape, coordinates, scale);
    mode.left = VectorXcd::Zero(scale.size());
    modes.push_back(std::move(mode));
  }
  return modes;
}

/// Shape and left vector of a mode by those along the scales.
void set_vectors(Mode& mode, const VectorXcd& right, const VectorXcd& left, int coordinates,
                 const VectorXd& scale) {
  mode.shape = scale.cast<std::complex<double>>().cwiseProduct(right);
  normalise_motion(mode.shape, coordinates, scale);
  VectorXcd w = scale.cwiseInverse().cast<std::complex<double>>().cwiseProduct(left);
  if (!w.allFinite()) w.setZero();
  const std::complex<double> product = w.dot(mode.shape);
  if (std::abs(product) > 0) w /= std::conj(product);
  mode.left = w;
}

/// Indices of values by their distance from `from`, without the first ones.
std::vector<Eigen::Index> order_of(const VectorXcd& values, std::complex<double> from, int left_out) {
  std::vector<Eigen::Index> order;
  for (Eigen::Index k = 0; k < values.size(); ++k) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return std::abs(values[a] - from) < std::abs(values[b] - from);
  });
  order.erase(order.begin(), order.begin() + std::min<std::ptrdiff_t>(left_out, std::ssize(order)));
  return order;
}

ComplexPairs pairs_of(const MatrixXd& A) {
  ComplexPairs pairs = general_eigen(A);
  if (!pairs.ok) throw std::runtime_error("the eigenvalues were not found: the iteration did not converge");
  return pairs;
}

/// `zero_count`: LinearisedModes::zeros.
std::vector<Mode> eigen_modes(const linear::Linearised& at, const Scales& scales, const VectorXd& scale,
                              int& zero_count) {
  const linear::Reduced& r = at.reduced;
  zero_count = 0;
  if (r.A.rows() == 0) return {};
  const MatrixXd A = scale.cwiseInverse().asDiagonal() * r.A * scale.asDiagonal();
  // On wheels the path goes by the heading, too.
  const bool rolls = r.coordinates != r.speeds || at.trimmed;
  const VectorXd sizes =
      Eigen::Map<const VectorXd>(scales.coordinates.data(), std::ssize(scales.coordinates));
  const Zeros zeros =
      rolls ? linear::zero_chains(r, sizes(at.independent), sizes(at.moving), scales.acceleration)
            : zeros_of(at, sizes(at.independent));
  zero_count = zeros.count;
  std::vector<Mode> modes =
      rigid_modes(linear::echelon(scale.cwiseInverse().asDiagonal() * zeros.vectors), r.coordinates, scale);
  const ComplexPairs pairs = pairs_of(A);
  const MatrixXcd left = left_vectors(pairs);
  const std::vector<Eigen::Index> order = order_of(pairs.values, 0, zeros.count);
  const double largest = order.empty() ? 0 : std::abs(pairs.values[order.back()]);
  for (const Eigen::Index k : order) {
    const std::complex<double> value = pairs.values[k];
    if (value.imag() < 0) continue;
    const auto add = [&](std::complex<double> of, const VectorXcd& x, const VectorXcd& w) {
      Mode mode = linear::mode_of(of, imaginary_round_off * largest);
      set_vectors(mode, x, w, r.coordinates, scale);
      modes.push_back(std::move(mode));
    };
    const VectorXcd x = pairs.vectors.col(k), w = left.row(k).adjoint();
    if (value.imag() > 0 && linear::is_nearly_real(value)) {
      add(value.real(), x.real(), w.real());
      add(value.real(), x.imag(), w.imag());
    } else {
      add(value, x, w);
    }
  }
  return modes;
}

/// Of coefficients that repeat: by multipliers over a period. Rigid motions have the multiplier 1.
std::vector<Mode> floquet_modes(const linear::Linearised& at, const VectorXd& scale,
                                const linear::Transition& transition) {
  const int coordinates = at.reduced.coordinates;
  const MatrixXd& over = transition.over_period;
  Zeros zeros = staircase_zeros(over - MatrixXd::Identity(over.rows(), over.cols()), transition_round_off);
  // At a critical speed motions come back after a period, too, that are not rigid.
  const MatrixXd A = scale.cwiseInverse().asDiagonal() * at.reduced.A * scale.asDiagonal();
  if (zeros.count > 0 && (A * zeros.vectors).norm() > 1e-6 * A.norm() * zeros.vectors.norm())
    zeros = {0, MatrixXd(over.rows(), 0)};
  std::vector<Mode> modes = rigid_modes(linear::echelon(zeros.vectors), coordinates, scale);
  for (Mode& mode : modes) mode.multiplier = 1;
  const ComplexPairs pairs = pairs_of(over);
  const MatrixXcd left = left_vectors(pairs);
  const std::size_t rigid = modes.size();
  for (const Eigen::Index k : order_of(pairs.values, 1, zeros.count)) {
    const std::complex<double> multiplier = pairs.values[k];
    if (multiplier.imag() < 0) continue;
    VectorXcd right = pairs.vectors.col(k), w = left.row(k).adjoint().col(0);
    std::complex<double> value = linear::exponent_of(transition, multiplier, right);
    Mode mode;
    if (value.imag() < 0) {
      value = std::conj(value);
      right = right.conjugate().eval();
      w = w.conjugate().eval();
    }
    mode = linear::mode_of(value, transition_round_off / transition.period);
    const double turned = value.imag() * transition.period;
    mode.multiplier = mimbre::exp(value.real() * transition.period) *
                      std::complex<double>(mimbre::cos(turned), mimbre::sin(turned));
    set_vectors(mode, right, w, coordinates, scale);
    modes.push_back(std::move(mode));
  }
  std::stable_sort(modes.begin() + static_cast<std::ptrdiff_t>(rigid), modes.end(),
                   [](const Mode& a, const Mode& b) { return std::abs(a.value) < std::abs(b.value); });
  return modes;
}

/// By the frequencies that the ground sees, which are those that people know. `mixed`: in the order of the
/// modes.
void sort_as_seen(linear::ModeShares& shares, std::vector<Mode>& modes, std::vector<char>& mixed) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    shares.see_from_ground(modes[k]);
    order.emplace_back(modes[k].kind == Mode::Kind::rigid ? 0 : std::abs(modes[k].seen()), k);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Mode> sorted;
  std::vector<char> sorted_mixed;
  for (const auto& [frequency, k] : order) {
    sorted.push_back(std::move(modes[k]));
    sorted_mixed.push_back(mixed[k]);
  }
  modes = std::move(sorted);
  mixed = std::move(sorted_mixed);
}

/// Whether the coefficients vary along the steady motion of the point, but for other axes.
bool varies(const linear::Linearised& at) { return at.names.varies > 0 && at.axes.empty(); }

}  // namespace

LinearisedModes find_modes(std::shared_ptr<const Model> model, const ModesOptions& options) {
  const double start = thread_cpu_seconds();
  linear::Linearised located = linear::locate(std::move(model), options.linear);
  const int most = options.most;
  if (const bool asked = options.solver == ModesSolver::sparse;
      asked || (options.solver == ModesSolver::automatic && most > 0 &&
                located.model->compiled().velocities >= linear::least_sparse)) {
    if (most <= 0)
      throw InputError(Mark{located.model->spec().file, 0, 0},
                       "the sparse solver finds the lowest modes: give their number (--most)");
    std::string why;
    if (std::optional<LinearisedModes> sparse = linear::sparse_modes(located, most, why)) {
      if (options.shapes) sparse->shapes = linear::body_shapes(located, sparse->modes);
      sparse->cpu_seconds = thread_cpu_seconds() - start;
      return std::move(*sparse);
    }
    if (asked) throw std::runtime_error("the sparse solver cannot find these modes: " + why);
    located.names.notes.push_back("the modes are those of dense matrices: " + why);
  }
  linear::Linearised at = linear::linearise_located(std::move(located));
  if (!at.axes.empty()) linear::put_in_axes(at.axes, at);
  const Compiled& m = at.model->compiled();
  LinearisedModes out;
  out.model = at.names;
  out.model.A = at.reduced.A;
  out.model.B = at.reduced.B;
  out.model.mass = at.reduced.mass;
  out.model.damping = at.reduced.damping;
  out.model.stiffness = at.reduced.stiffness;
  for (int k = 0; k < m.velocities; ++k) out.coordinates.push_back(linear::coordinate_label(m, k));
  const relative::RelativeSystem system(m);
  const Scales scales = linear::modal_scales(m, system.scales());
  const VectorXd scale = state_scales(at.reduced, scales.coordinates, at.independent, at.moving);
  std::string why;
  const std::optional<linear::Transition> transition =
      varies(at) ? linear::find_transition(m, system, at, scale, why) : std::nullopt;
  out.modes = transition ? floquet_modes(at, scale, *transition) : eigen_modes(at, scales, scale, out.zeros);
  if (transition) {
    out.period = transition->period;
    std::erase_if(out.model.warnings, [](const std::string& w) { return w.starts_with(linear::varying); });
    out.model.notes.push_back(fmt::format(
        "the coefficients vary along the motion and repeat after {:.6g} s: modes are x = e^λt p(t) with p of "
        "that period (Floquet); their frequencies are seen with multiples of {:.6g} rad/s added, too",
        out.period, 2 * std::numbers::pi / out.period));
  } else if (!why.empty()) {
    out.model.notes.push_back("there are no multipliers of a period: " + why);
  }
  linear::ModeShares shares(at);
  // Before some are left out, which may be of a group.
  std::vector<char> mixed;
  for (const std::size_t k : linear::separate_waves(linear::joined(shares.blades()),
                                                    at.reduced.position.leftCols(at.reduced.A.cols()),
                                                    scales.coordinates, out.modes, mixed))
    set_vectors(out.modes[k], VectorXcd(out.modes[k].shape.cwiseQuotient(scale.cast<std::complex<double>>())),
                VectorXcd(out.modes[k].left.cwiseProduct(scale.cast<std::complex<double>>())),
                at.reduced.coordinates, scale);
  if (at.turning > 0) sort_as_seen(shares, out.modes, mixed);
  if (options.most > 0 && std::ssize(out.modes) > options.most)
    out.modes.resize(static_cast<std::size_t>(options.most));
  shares.describe(out.modes, mixed);
  out.turning = at.turning;
  if (options.shapes) out.shapes = linear::body_shapes(at, out.modes);
  out.cpu_seconds = thread_cpu_seconds() - start;
  return out;
}

}  // namespace mimbre
