#include "linalg/constrained_modes.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "base/random_numbers.h"
#include "linalg/constrained_solver.h"
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
/// θ of what has no inertia.
constexpr double infinite = 1e-6;
constexpr double symmetric = 1e-10;

double largest(const SparseMatrix& A) {
  double most = 0;
  for (Index k = 0; k < A.nonZeros(); ++k) most = std::max(most, std::abs(A.valuePtr()[k]));
  return most;
}

bool is_symmetric(const SparseMatrix& A) {
  const SparseMatrix other = A.transpose();
  return largest(SparseMatrix(A - other)) <= symmetric * largest(A);
}

/// s with so many ω² below it: at least `least`, not many more.
double limit_of(const ConstrainedPencil& p, int least) {
  const double mass = largest(p.M), stiffness = largest(p.K);
  if (!(mass > 0) || !(stiffness > 0)) return 1;
  const double fastest = stiffness / mass;
  double low = 0, high = 0, s = 1e-6 * fastest;
  int most = -1;
  double reached = s;  // where the largest count so far was first found
  ConstrainedSolver counter;
  for (int k = 0; k < 40; ++k) {
    counter.set(SparseMatrix(p.K - s * p.M), p.J);
    const int count = counter.ok() ? counter.negative() : 0;
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

  bool start() {
    MatrixXd W(op_.size(), block);
    for (int c = 0; c < block; ++c) {
      VectorXd x(op_.size());
      for (Index k = 0; k < x.size(); ++k)
        x[k] = uniform_at(static_cast<std::uint64_t>(c) + 1, static_cast<std::uint64_t>(k)) - 0.5;
      // Into the space of the constraints.
      VectorXd y(x.size());
      if (!op_.apply(x, y) || !op_.apply(y, x)) return false;
      W.col(c) = x;
    }
    MatrixXd unused = MatrixXd::Zero(block, block);
    add(W, unused);
    return true;
  }

  /// One more block.
  bool grow() {
    MatrixXd W(op_.size(), block);
    for (int c = 0; c < block; ++c)
      if (!op_.apply(V_.col(size_ + c), W.col(c))) return false;
    const Index used = size_ + block;
    for (int twice = 0; twice < 2; ++twice) {
      const MatrixXd h = V_.leftCols(used).transpose() * W;
      W.noalias() -= V_.leftCols(used) * h;
      H_.block(0, size_, used, block) += h;
    }
    size_ = static_cast<int>(used);
    MatrixXd R = MatrixXd::Zero(block, block);
    add(W, R);
    H_.block(size_, size_ - block, block, block) = R;
    return true;
  }

  int size() const { return size_; }
  MatrixXd projected() const { return H_.topLeftCorner(size_, size_); }
  MatrixXd coupling() const { return H_.block(size_, size_ - block, block, block); }
  auto vectors() const { return V_.leftCols(size_); }

 private:
  /// W = Q R; Q goes behind the vectors that are there. Columns that add nothing become random ones.
  void add(MatrixXd& W, MatrixXd& R) {
    const Index first = size_ == 0 ? 0 : size_;
    for (int c = 0; c < block; ++c) {
      VectorXd w = W.col(c);
      const double before = w.norm();
      // Of what is there already, w is free; within the block, and of all where little is left.
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
      if (!(length > 1e-13 * before)) {
        R(c, c) = 0;
        for (Index k = 0; k < w.size(); ++k)
          w[k] = uniform_at(static_cast<std::uint64_t>(first + c) + 100, static_cast<std::uint64_t>(k)) - 0.5;
        VectorXd y(w.size());
        if (op_.apply(w, y)) w = y;
        project(0, false);
        project(0, false);
        length = w.norm();
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

struct Ritz {
  std::complex<double> value;  ///< λ/σ
  Index column = 0;
  double residual = 0;  ///< of its θ
};

}  // namespace arnoldi

}  // namespace

ConstrainedModes lowest_modes(const ConstrainedPencil& given, int count) {
  using namespace arnoldi;
  ConstrainedModes out;
  const Index n = given.M.cols();
  if (n == 0 || count <= 0) return out;
  ConstrainedPencil p = given;
  ConstrainedSolver projector;
  SparseMatrix unit(n, n);
  unit.setIdentity();
  projector.set(unit, p.J);
  for (SparseMatrix* A : {&p.K, &p.C, &p.M}) *A = symmetric_along_motions(*A, projector, p.J.rows());
  const double sigma = 0.5 * std::sqrt(limit_of(p, count));
  Operator op(p, sigma);
  if (!op.ok()) return out;
  // Motions that the constraints leave are at least n − m; the iteration ends when it has found all.
  const int least = 2 * count + 3 * block,
            most = std::max<int>(block,
                                 static_cast<int>(std::min<Index>(12 * count + 120, 2 * n)) / block * block);
  Basis basis(op, most);
  if (!basis.start()) return out;
  std::vector<Ritz> found;
  ComplexPairs pairs;
  for (int check = std::min(most, 2 * least);; check = std::min(most, check + check / 4 + block)) {
    while (basis.size() < check && basis.size() + block <= most)
      if (!basis.grow()) return out;
    pairs = general_eigen(basis.projected());
    if (!pairs.ok) return out;
    const MatrixXd coupling = basis.coupling();
    found.clear();
    for (Index k = 0; k < pairs.values.size(); ++k) {
      const std::complex<double> theta = pairs.values[k];
      if (!(std::abs(theta) > infinite)) continue;
      Ritz r{1. + 1. / theta, k, 0};
      r.residual = (coupling * pairs.vectors.col(k).tail(block)).norm() / std::abs(theta);
      found.push_back(r);
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Ritz& a, const Ritz& b) { return std::abs(a.value) < std::abs(b.value); });
    // Of conjugate pairs one counts.
    int have = 0, zeros = 0;
    bool all = true;
    for (const Ritz& r : found) {
      const bool is_zero = std::abs(r.value) < zero;
      all = all && r.residual <= (is_zero ? 1e-7 : converged);
      if (!all) break;
      if (is_zero)
        ++zeros;
      else if (r.value.imag() >= 0)
        ++have;
      if (have + (zeros + 1) / 2 > count) break;
    }
    if (all || have + (zeros + 1) / 2 > count) break;
    if (basis.size() + block > most) return out;
  }
  const bool symmetric_pencil = is_symmetric(p.M) && is_symmetric(p.C) && is_symmetric(p.K);
  MatrixXd still(n, 0);
  std::vector<std::complex<double>> values;
  std::vector<VectorXcd> vectors;
  const auto V = basis.vectors().topRows(n);
  for (const Ritz& r : found) {
    if (static_cast<int>(values.size() + static_cast<std::size_t>(still.cols())) >= count) break;
    if (r.residual > 1e-6) break;
    const VectorXcd y = pairs.vectors.col(r.column);
    VectorXcd x(n);
    x.real() = V * y.real();
    x.imag() = V * y.imag();
    if (!(x.norm() > 0)) continue;
    x /= x.norm();
    if (std::abs(r.value) < zero) {
      for (const VectorXd& part : {VectorXd(x.real()), VectorXd(x.imag())}) {
        VectorXd w = part;
        for (int twice = 0; twice < 2; ++twice) w -= still * (still.transpose() * w);
        if (!(w.norm() > same_vector)) continue;
        still.conservativeResize(n, still.cols() + 1);
        still.col(still.cols() - 1) = w / w.norm();
      }
      continue;
    }
    const bool real = std::abs(r.value.imag()) <= 1e-10 * std::abs(r.value);
    if (!real && r.value.imag() < 0) continue;
    std::complex<double> value = sigma * r.value;
    if (symmetric_pencil) {
      const auto square = [&](const SparseMatrix& A) {
        const VectorXcd ax = A.cast<std::complex<double>>() * x;
        return (x.transpose() * ax)(0, 0);
      };
      const std::complex<double> a = square(p.M), b = square(p.C), c = square(p.K);
      const std::complex<double> root = std::sqrt(b * b - 4. * a * c);
      // Of equal eigenvalues x may be a complex mixture whose square vanishes.
      if (std::abs(a) > 0.05 * std::abs(x.dot(p.M.cast<std::complex<double>>() * x))) {
        const std::complex<double> one = (-b + root) / (2. * a), two = (-b - root) / (2. * a);
        const std::complex<double> better = std::abs(one - value) < std::abs(two - value) ? one : two;
        if (std::abs(better - value) < 1e-5 * std::abs(value)) value = better;
      }
    }
    if (real) value = value.real();
    values.push_back(value);
    vectors.push_back(x);
  }
  out.rigid = still;
  out.values.resize(std::ssize(values));
  out.vectors.resize(n, std::ssize(values));
  for (std::size_t k = 0; k < values.size(); ++k) {
    out.values[static_cast<Index>(k)] = values[k];
    out.vectors.col(static_cast<Index>(k)) = vectors[k];
  }
  out.ok = true;
  return out;
}

}  // namespace mimbre::linalg
