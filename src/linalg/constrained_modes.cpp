#include "linalg/constrained_modes.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>
#include <vector>

#include "base/random_numbers.h"
#include "linalg/constrained_solver.h"
#include "linalg/once/sparse_qr.h"
#include "math/once/decompositions.h"
#include "math/once/general_eigen.h"

namespace mimbre::linalg {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

namespace arnoldi {

constexpr int block = 3;
/// Of the eigenvalue, for residuals.
constexpr double converged = 1e-11;
/// Of the shift: λ is zero. It is a double root, which round-off splits.
constexpr double zero = 1e-5;
constexpr double same_vector = 1e-5;
/// Of the shift: slow motions are found once more, this near; slower than the other they are rigid.
constexpr double slow_shift = 1e-2, too_slow = 1e-8;
/// θ of what has no inertia.
constexpr double infinite = 1e-6;
/// Of a random vector: it lies in the space of the others.
constexpr double nothing_left = 1e-12;
/// Of stiffness and damping along slow motions: round-off.
constexpr double round_off = 1e-12;
/// Copies of equal eigenvalues are found three at a time.
constexpr int most_passes = 40;
constexpr double symmetric = 1e-10;
constexpr double repeated = 1e-9;  ///< of equations of length one, what they add to others

bool is_symmetric(const SparseMatrix& A) {
  const SparseMatrix other = A.transpose();
  return largest_entry(SparseMatrix(A - other)) <= symmetric * largest_entry(A);
}

/// How many motions have |λ|² below s: ω² of those that oscillate and the growth of those that fall apart,
/// where there is no damping (Sylvester).
class ModeCounter {
 public:
  explicit ModeCounter(const ConstrainedPencil& p)
      : p_(p), fastest_(largest_entry(p.K) / largest_entry(p.M)) {
    grows_ = fastest_ > 0 && below(-1e-12 * fastest_) > 0;
  }
  /// −1: not known.
  int operator()(double s) {
    const int all = below(s), growing = grows_ ? below(-s) : 0;
    return all < 0 || growing < 0 ? -1 : all - growing;
  }
  double fastest() const { return fastest_; }  ///< 1/s², about as large as |λ|² gets

 private:
  int below(double s) {
    solver_.set(SparseMatrix(p_.K - s * p_.M), p_.J);
    return solver_.ok() ? solver_.negative() : -1;
  }
  const ConstrainedPencil& p_;
  ConstrainedSolver solver_;
  double fastest_ = 0;
  bool grows_ = false;
};

/// s with so many |λ|² below it: at least `least`, not many more.
double limit_of(ModeCounter& counter, int least) {
  const double fastest = counter.fastest();
  double low = 0, high = 0, s = 1e-6 * fastest;
  int most = -1;
  double reached = s;  // where the largest count so far was first found
  for (int k = 0; k < 40; ++k) {
    const int count = counter(s);
    if (count >= least && count <= 3 * least + 10) return s;
    if (count > most || (count == most && s < reached)) {
      most = count;
      reached = s;
    }
    if (count < least)
      low = s;
    else
      high = s;
    if (low > 0 && high > 0) {
      if (high < 1.01 * low) return high;
      s = std::sqrt(low * high);
    } else {
      s = count < least ? 16 * s : s / 16;
    }
    // There are fewer.
    if (s > 1e3 * fastest) return reached;
    if (s < 1e-24 * fastest) break;
  }
  return high > 0 ? high : s;
}

/// (A − B)⁻¹ B of the pencil of first order, in time units of 1/σ.
class Operator {
 public:
  Operator(const ConstrainedPencil& p, double sigma)
      : n_(p.M.cols()), m_(p.J.rows()), M_(sigma * sigma * p.M), both_(M_ + SparseMatrix(sigma * p.C)) {
    solver_.set(SparseMatrix(p.K + both_), p.J);
  }
  bool ok() const { return solver_.ok(); }
  Index size() const { return 2 * n_; }

  bool apply(const Eigen::Ref<const VectorXd>& in, Eigen::Ref<VectorXd> out) {
    const VectorXd a = in.head(n_), b = in.tail(n_);
    VectorXd x, mu;
    const VectorXd right = -(M_ * b + both_ * a);
    if (!solver_.solve(right, VectorXd::Zero(m_), x, mu)) return false;
    out.head(n_) = x;
    out.tail(n_) = x + a;
    return true;
  }

 private:
  Index n_, m_;
  SparseMatrix M_, both_;
  ConstrainedSolver solver_;
};

class Basis {
 public:
  Basis(Operator& op, int most)
      : op_(op), V_(op.size(), most + block), H_(MatrixXd::Zero(most + block, most)) {}

  /// With a basis of an invariant subspace, for which `seed` begins at other vectors.
  bool start(const MatrixXd& invariant, std::uint64_t seed) {
    size_ = static_cast<int>(invariant.cols());
    V_.leftCols(size_) = invariant;
    VectorXd image(op_.size());
    for (int c = 0; c < size_; ++c) {
      if (!op_.apply(V_.col(c), image)) return false;
      H_.col(c).head(size_) = invariant.transpose() * image;
    }
    MatrixXd W(op_.size(), block);
    for (int c = 0; c < block; ++c) {
      VectorXd x(op_.size());
      for (Index k = 0; k < x.size(); ++k)
        x[k] =
            uniform_at(seed * block + static_cast<std::uint64_t>(c) + 1, static_cast<std::uint64_t>(k)) - 0.5;
      if (!into_constraints(x)) return false;
      for (int twice = 0; twice < 2; ++twice) x -= invariant * (invariant.transpose() * x);
      W.col(c) = x;
    }
    MatrixXd unused = MatrixXd::Zero(block, block);
    add(W, W.colwise().norm(), unused);
    return true;
  }

  /// One more block.
  bool grow() {
    MatrixXd W(op_.size(), block);
    for (int c = 0; c < block; ++c)
      if (!op_.apply(V_.col(size_ + c), W.col(c))) return false;
    const Index used = size_ + block;
    const VectorXd sizes = W.colwise().norm();
    // Once more where much was taken away (Daniel, Gragg, Kaufman, Stewart 1976).
    for (int round = 0; round < 2; ++round) {
      const VectorXd before = W.colwise().norm();
      for (int c = 0; c < block; ++c) {
        const VectorXd h = V_.leftCols(used).transpose() * W.col(c);
        W.col(c).noalias() -= V_.leftCols(used) * h;
        H_.col(size_ + c).head(used) += h;
      }
      if ((W.colwise().norm().transpose().array() > 0.7 * before.array()).all()) break;
    }
    size_ = static_cast<int>(used);
    MatrixXd R = MatrixXd::Zero(block, block);
    add(W, sizes, R);
    H_.block(size_, size_ - block, block, block) = R;
    return true;
  }

  int size() const { return size_; }
  MatrixXd projected() const { return H_.topLeftCorner(size_, size_); }
  MatrixXd coupling() const { return H_.block(size_, size_ - block, block, block); }
  auto vectors() const { return V_.leftCols(size_); }

 private:
  /// Positions and velocities: one application leaves what the positions were in the velocities.
  bool into_constraints(VectorXd& x) {
    VectorXd y(x.size());
    return op_.apply(x, y) && op_.apply(y, x);
  }

  /// W = Q R; Q goes behind the vectors that are there. Columns that add nothing become random ones, or zero
  /// where there is nothing else.
  /// `sizes`: of the columns before they were at right angles to what is there.
  void add(MatrixXd& W, const VectorXd& sizes, MatrixXd& R) {
    const Index first = size_;
    for (int c = 0; c < block; ++c) {
      VectorXd w = W.col(c);
      const double before = w.norm();
      // w is at right angles to the earlier blocks; to those of its block, and to all where little is left.
      const auto project = [&](Index from, bool record) {
        const VectorXd h = V_.middleCols(from, first + c - from).transpose() * w;
        w -= V_.middleCols(from, first + c - from) * h;
        if (record)
          for (int k = 0; k < c; ++k) R(k, c) += h[first - from + k];
      };
      project(first, true);
      project(first, true);
      if (!(w.norm() > 0.1 * before)) project(0, true);
      double length = w.norm();
      R(c, c) = length;
      if (!(length > 1e-13 * sizes[c])) {
        R(c, c) = 0;
        for (Index k = 0; k < w.size(); ++k)
          w[k] = uniform_at(static_cast<std::uint64_t>(first + c) + 100, static_cast<std::uint64_t>(k)) - 0.5;
        into_constraints(w);
        const double all = w.norm();
        project(0, false);
        project(0, false);
        length = w.norm();
        if (!(length > nothing_left * all)) {
          V_.col(first + c).setZero();
          continue;
        }
      }
      V_.col(first + c) = w / length;
    }
  }

  Operator& op_;
  MatrixXd V_, H_;
  int size_ = 0;
};

/// The symmetric part of A where its skew part does not act along the motions with J x = 0: torques are
/// derivatives of a potential along these alone.
SparseMatrix symmetric_along_motions(const SparseMatrix& A, ConstrainedSolver& projector, Index equations) {
  if (is_symmetric(A)) return A;
  const SparseMatrix other = A.transpose(), skew = 0.5 * (A - other), sum = 0.5 * (A + other);
  std::vector<VectorXd> motions;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    VectorXd f(A.cols()), x, mu;
    for (Index k = 0; k < f.size(); ++k) f[k] = uniform_at(seed + 31, static_cast<std::uint64_t>(k)) - 0.5;
    if (!projector.solve(f, VectorXd::Zero(equations), x, mu)) return A;
    motions.push_back(x);
  }
  for (const VectorXd& x : motions)
    for (const VectorXd& y : motions)
      if (std::abs(x.dot(skew * y)) > symmetric * x.cwiseAbs().dot(sum.cwiseAbs() * y.cwiseAbs())) return A;
  return sum;
}

/// Motions of n coordinates that the equations leave; an upper bound where `count` is less.
Index motions_with(const SparseMatrix& J, Index n, int count) {
  if (J.rows() == 0 || count < n - J.rows()) return n;
  return n - SparseQr(SparseMatrix(J.transpose()), repeated).rank();
}

struct Ritz {
  std::complex<double> value;  ///< λ/σ
  Index column = 0;
  double residual = 0;  ///< of its θ
  bool is_zero() const { return std::abs(value) < zero; }
  bool has_converged() const { return residual <= (is_zero() ? 1e-7 : converged); }
};

/// The modes of least |λ|, of conjugate pairs both, with the vectors of the basis that they are made of.
struct RitzPairs {
  std::vector<Ritz> list;  ///< ascending
  ComplexPairs pairs;
  int sufficient = 0;  ///< so many of the list make `count` modes; 0: they have not converged
};

/// Grows the basis until `count` modes have converged, or all `eigenvalues` of the motions. What comes behind
/// these has no inertia: round-off splits its θ = 0.
bool iterate(Basis& basis, int count, Index eigenvalues, int first_check, int most, RitzPairs& out) {
  for (int check = std::min(most, first_check);; check = std::min(most, check + check / 4 + block)) {
    while (basis.size() < check && basis.size() + block <= most)
      if (!basis.grow()) return false;
    out.pairs = general_eigen(basis.projected());
    if (!out.pairs.ok) return false;
    const MatrixXd coupling = basis.coupling();
    out.list.clear();
    for (Index k = 0; k < out.pairs.values.size(); ++k) {
      const std::complex<double> theta = out.pairs.values[k];
      if (!(std::abs(theta) > infinite)) continue;
      Ritz r{1. + 1. / theta, k, 0};
      r.residual = (coupling * out.pairs.vectors.col(k).tail(block)).norm() / std::abs(theta);
      out.list.push_back(r);
    }
    std::stable_sort(out.list.begin(), out.list.end(),
                     [](const Ritz& a, const Ritz& b) { return std::abs(a.value) < std::abs(b.value); });
    int have = 0, zeros = 0;
    out.sufficient = 0;
    bool all = true;
    for (const Ritz& r : out.list) {
      if (out.sufficient == eigenvalues) return true;
      all = all && r.has_converged();
      if (!all) break;
      ++out.sufficient;
      if (r.is_zero())
        ++zeros;
      else if (r.value.imag() >= 0)
        ++have;
      if (have + (zeros + 1) / 2 > count) return true;
    }
    if (all && (!out.list.empty() || coupling.isZero(0))) return true;
    if (basis.size() + block > most) return false;
  }
}

/// Real and imaginary parts of the first vectors of the list, made orthonormal.
MatrixXd invariant_subspace(const Basis& basis, const RitzPairs& found) {
  MatrixXd Q(basis.vectors().rows(), 0);
  for (int k = 0; k < found.sufficient; ++k) {
    const Ritz& r = found.list[static_cast<std::size_t>(k)];
    if (r.value.imag() < 0) continue;
    const VectorXcd y = found.pairs.vectors.col(r.column);
    for (const VectorXd& part : {VectorXd(y.real()), VectorXd(y.imag())}) {
      VectorXd w = basis.vectors() * part;
      const double before = w.norm();
      for (int twice = 0; twice < 2; ++twice) w -= Q * (Q.transpose() * w);
      if (!(w.norm() > same_vector * before)) continue;
      Q.conservativeResize(Eigen::NoChange, Q.cols() + 1);
      Q.col(Q.cols() - 1) = w / w.norm();
    }
  }
  return Q;
}

/// Motions that found modes of |λ| < limit are: of pairs of growing and decaying ones each counts one.
int motions_below(const RitzPairs& found, double limit, int rigid) {
  int count = rigid;
  for (const Ritz& r : found.list) {
    const bool real = std::abs(r.value.imag()) <= 1e-10 * std::abs(r.value);
    if (r.is_zero() || !(std::abs(r.value) < limit) || !r.has_converged()) continue;
    count += real ? (r.value.real() > 0 ? 1 : 0) : (r.value.imag() > 0 ? 1 : 0);
  }
  return count;
}

/// Motions with λ that is hardly seen beside σ, orthonormal.
MatrixXd slow_motions(const Basis& basis, const RitzPairs& found, Index n) {
  MatrixXd still(n, 0);
  const auto V = basis.vectors().topRows(n);
  for (const Ritz& r : found.list) {
    if (!r.is_zero() || !r.has_converged()) continue;
    const VectorXcd y = found.pairs.vectors.col(r.column);
    for (const VectorXd& part : {VectorXd(V * y.real()), VectorXd(V * y.imag())}) {
      VectorXd w = part;
      const double before = w.norm();
      if (!(before > 0)) continue;
      for (int twice = 0; twice < 2; ++twice) w -= still * (still.transpose() * w);
      if (!(w.norm() > same_vector * before)) continue;
      still.conservativeResize(Eigen::NoChange, still.cols() + 1);
      still.col(still.cols() - 1) = w / w.norm();
    }
  }
  return still;
}

/// Slow motions without what is in them of faster ones, to round-off: stiff parts of rigid motions have no
/// share in them, and what the iteration leaves there, times their stiffness, would hold them.
MatrixXd purified(const ConstrainedPencil& p, const MatrixXd& S, double sigma) {
  if (S.cols() == 0) return S;
  Operator op(p, slow_shift * sigma);
  if (!op.ok()) return S;
  const Index n = S.rows();
  MatrixXd out = S;
  for (int round = 0; round < 4; ++round) {
    for (Index k = 0; k < out.cols(); ++k) {
      VectorXd x = VectorXd::Zero(2 * n), y(2 * n);
      x.head(n) = out.col(k);
      if (!op.apply(x, y)) return S;
      VectorXd w = y.head(n);
      const double before = w.norm();
      for (int twice = 0; twice < 2; ++twice) w -= out.leftCols(k) * (out.leftCols(k).transpose() * w);
      if (!(w.norm() > same_vector * before)) return S;
      out.col(k) = w / w.norm();
    }
  }
  return out;
}

/// Which of slow motions are rigid and which only slow, by stiffness and damping along them.
struct SlowModes {
  MatrixXd rigid;
  std::vector<std::complex<double>> values;  ///< of the others, Im λ ≥ 0
  std::vector<VectorXcd> vectors;
};
SlowModes part_slow(const ConstrainedPencil& p, const MatrixXd& S, double sigma) {
  SlowModes out;
  const Index k = S.cols();
  const MatrixXd M = S.transpose() * (p.M * S);
  const double inertia = k > 0 ? M.cwiseAbs().maxCoeff() : 0, slowest = too_slow * sigma;
  const auto along = [&](const SparseMatrix& A, double least) {
    MatrixXd of = S.transpose() * (A * S);
    const MatrixXd size = S.cwiseAbs().transpose() * (A.cwiseAbs() * S.cwiseAbs());
    for (Index i = 0; i < of.size(); ++i)
      if (!(std::abs(of(i)) > std::max(round_off * size.maxCoeff(), least))) of(i) = 0;
    return of;
  };
  const MatrixXd K = along(p.K, slowest * slowest * inertia), C = along(p.C, slowest * inertia);
  out.rigid = S;
  if (k == 0 || (K.isZero(0) && C.isZero(0))) return out;
  const Cholesky mass(M);
  if (!mass.ok()) return out;
  // Chains λ² = 0 of what neither stiffness nor damping holds, λ = 0 of what damping alone does.
  const MatrixXd still = K.isZero(0) ? MatrixXd(MatrixXd::Identity(k, k)) : null_space(K, 1e-9);
  MatrixXd held = still.transpose() * C * still;
  const double damping = C.cwiseAbs().maxCoeff();
  for (double& c : held.reshaped())
    if (!(std::abs(c) > 1e-9 * damping)) c = 0;
  const Index drifting = still.cols() == 0 ? 0
                         : held.isZero(0)  ? still.cols()
                                           : null_space(held, 1e-9).cols();
  MatrixXd A = MatrixXd::Zero(2 * k, 2 * k);
  A.topRightCorner(k, k).setIdentity();
  A.bottomLeftCorner(k, k) = -mass.solve(K);
  A.bottomRightCorner(k, k) = -mass.solve(C);
  const ComplexPairs pairs = general_eigen(A);
  if (!pairs.ok) return out;
  out.rigid = S * still;
  std::vector<Index> order;
  for (Index i = 0; i < pairs.values.size(); ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return std::abs(pairs.values[a]) < std::abs(pairs.values[b]); });
  for (std::size_t i = static_cast<std::size_t>(still.cols() + drifting); i < order.size(); ++i) {
    const std::complex<double> value = pairs.values[order[i]];
    if (value.imag() < 0 || !(std::abs(value) < 10 * zero * sigma)) continue;
    VectorXcd x(S.rows());
    x.real() = S * pairs.vectors.col(order[i]).head(k).real();
    x.imag() = S * pairs.vectors.col(order[i]).head(k).imag();
    out.values.push_back(value);
    out.vectors.push_back(x / x.norm());
  }
  return out;
}

/// The root of x's Rayleigh quotient that is nearest to λ, exact to the second order of the error of x where
/// the matrices are symmetric.
std::complex<double> refined(const ConstrainedPencil& p, const VectorXcd& x, std::complex<double> value) {
  const auto square = [&](const SparseMatrix& A) {
    const VectorXcd ax = A.cast<std::complex<double>>() * x;
    return (x.transpose() * ax)(0, 0);
  };
  const std::complex<double> a = square(p.M), b = square(p.C), c = square(p.K),
                             root = std::sqrt(b * b - 4. * a * c);
  // Of equal eigenvalues x may be a complex mixture whose square vanishes.
  if (!(std::abs(a) > 0.05 * std::abs(x.dot(p.M.cast<std::complex<double>>() * x)))) return value;
  const std::complex<double> one = (-b + root) / (2. * a), two = (-b - root) / (2. * a);
  const std::complex<double> better = std::abs(one - value) < std::abs(two - value) ? one : two;
  return std::abs(better - value) < 1e-5 * std::abs(value) ? better : value;
}

/// What the passes of the iteration have found.
struct Found {
  std::optional<Basis> basis;
  RitzPairs pairs;
  MatrixXd slow;
};

/// |λ/σ| of the last of the first `count` modes.
double last_of(const Found& found, int count) {
  double last = zero;
  auto modes = static_cast<int>(found.slow.cols());
  for (int k = 0; k < found.pairs.sufficient && modes < count; ++k) {
    const Ritz& r = found.pairs.list[static_cast<std::size_t>(k)];
    if (r.is_zero() || r.value.imag() < 0) continue;
    last = std::abs(r.value);
    ++modes;
  }
  return last;
}

/// A block finds three copies of an eigenvalue; further ones are found by other blocks, at right angles to
/// what was found, until the count of the motions agrees (where it is known: `counter`) or a pass adds none.
bool find_all(Operator& op, double sigma, int count, Index eigenvalues, ModeCounter* counter, Found& out) {
  const Index n = op.size() / 2;
  MatrixXd invariant(op.size(), 0);
  int before = -1;
  for (std::uint64_t pass = 0; pass < most_passes; ++pass) {
    const auto kept = static_cast<int>(invariant.cols());
    const int room = static_cast<int>(std::min<Index>(12 * count + 120, op.size())) / block * block;
    out.basis.emplace(op, kept + std::max(block, room));
    if (!out.basis->start(invariant, pass) ||
        !iterate(*out.basis, count, eigenvalues, kept + 2 * count + 3 * block, kept + std::max(block, room),
                 out.pairs))
      return false;
    out.slow = slow_motions(*out.basis, out.pairs, n);
    const double inside = (1 - 1e-6) * last_of(out, count);
    const int have = motions_below(out.pairs, inside, static_cast<int>(out.slow.cols()));
    if (have == before || (counter && (*counter)(std::pow(inside * sigma, 2)) == have)) return true;
    before = have;
    invariant = invariant_subspace(*out.basis, out.pairs);
  }
  return true;
}

/// The first `count`: rigid ones, then slow ones, then the others.
ConstrainedModes first_modes(const ConstrainedPencil& p, const Found& found, double sigma, int count,
                             bool is_symmetric_pencil) {
  ConstrainedModes out;
  const Index n = p.M.cols();
  const SlowModes slow = part_slow(p, purified(p, found.slow, sigma), sigma);
  out.rigid = slow.rigid.leftCols(std::min<Index>(slow.rigid.cols(), count));
  std::vector<std::complex<double>> values;
  std::vector<VectorXcd> vectors;
  const auto add = [&](std::complex<double> value, const VectorXcd& x) {
    if (std::ssize(values) + out.rigid.cols() >= count) return;
    values.push_back(value);
    vectors.push_back(x);
  };
  for (std::size_t k = 0; k < slow.values.size(); ++k) add(slow.values[k], slow.vectors[k]);
  const auto V = found.basis->vectors().topRows(n);
  for (int k = 0; k < found.pairs.sufficient; ++k) {
    const Ritz& r = found.pairs.list[static_cast<std::size_t>(k)];
    if (r.is_zero() || std::ssize(values) + out.rigid.cols() >= count) continue;
    const bool real = std::abs(r.value.imag()) <= 1e-10 * std::abs(r.value);
    if (!real && r.value.imag() < 0) continue;
    const VectorXcd y = found.pairs.pairs.vectors.col(r.column);
    VectorXcd x(n);
    x.real() = V * y.real();
    x.imag() = V * y.imag();
    if (!(x.norm() > 0)) continue;
    x /= x.norm();
    std::complex<double> value = sigma * r.value;
    if (is_symmetric_pencil) value = refined(p, x, value);
    add(real ? value.real() : value, x);
  }
  out.values.resize(std::ssize(values));
  out.vectors.resize(n, std::ssize(values));
  for (std::size_t k = 0; k < values.size(); ++k) {
    out.values[static_cast<Index>(k)] = values[k];
    out.vectors.col(static_cast<Index>(k)) = vectors[k];
  }
  out.ok = true;
  return out;
}

}  // namespace arnoldi

}  // namespace

ConstrainedModes lowest_modes(const ConstrainedPencil& given, int count) {
  using namespace arnoldi;
  const Index n = given.M.cols();
  if (n == 0 || count <= 0) return {};
  ConstrainedPencil p = given;
  ConstrainedSolver projector;
  SparseMatrix unit(n, n);
  unit.setIdentity();
  projector.set(unit, p.J);
  for (SparseMatrix* A : {&p.K, &p.C, &p.M}) *A = symmetric_along_motions(*A, projector, p.J.rows());
  if (!(largest_entry(p.M) > 0)) return {};
  ModeCounter counter(p);
  const double sigma = counter.fastest() > 0 ? 0.5 * std::sqrt(limit_of(counter, count)) : 1;
  Operator op(p, sigma);
  if (!op.ok()) return {};
  const bool symmetric_pencil = is_symmetric(p.M) && is_symmetric(p.C) && is_symmetric(p.K);
  Found found;
  const Index eigenvalues = 2 * motions_with(p.J, n, count);
  if (eigenvalues == 0) {
    ConstrainedModes none;
    none.vectors.resize(n, 0);
    none.rigid.resize(n, 0);
    none.ok = true;
    return none;
  }
  if (!find_all(op, sigma, count, eigenvalues, symmetric_pencil ? &counter : nullptr, found)) return {};
  ConstrainedModes modes = first_modes(p, found, sigma, count, symmetric_pencil);
  modes.symmetric = symmetric_pencil;
  return modes;
}

}  // namespace mimbre::linalg
