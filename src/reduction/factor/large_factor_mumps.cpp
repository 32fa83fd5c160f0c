#include <dmumps_c.h>
#include <fmt/format.h>

#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

#include "base/one_thread.h"
#include "reduction/factor/large_factor.h"

namespace mimbre::fe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;

namespace {

// MUMPS has variables that all its instances share: one call at a time.
std::mutex one_at_a_time;

}  // namespace

/// An instance of MUMPS. Controls, jobs and results have the numbers of its manual (Users' guide 5.5).
struct LargeFactor::Implementation {
  enum class Kind { definite = 1, any = 2 };  ///< without pivots, and with

  explicit Implementation(Kind kind) {
    mumps.sym = static_cast<int>(kind);
    mumps.par = 1;
    mumps.comm_fortran = -987654;  // one process
    check(call(-1));
    for (int k = 1; k <= 4; ++k) control(k) = 0;  // prints nothing
    control(7) = 4;                               // ordered by PORD (docs/performance.md)
  }
  ~Implementation() { call(-2); }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  int& control(int k) { return mumps.icntl[k - 1]; }
  int result(int k) const { return mumps.infog[k - 1]; }

  /// Gives what it came to: below zero an error.
  int call(int job) {
    const std::lock_guard lock(one_at_a_time);
    mumps.job = job;
    dmumps_c(&mumps);
    return result(1);
  }

  void check(int outcome) const {
    if (outcome == -13 || outcome == -9) throw std::bad_alloc();
    if (outcome < 0) throw std::runtime_error(fmt::format("MUMPS: error {} ({})", outcome, result(2)));
  }

  /// Whether there are factors, for a definite kind of a definite matrix.
  bool factorise(const SparseMatrix<double>& lower) {
    std::vector<int> rows, columns;
    std::vector<double> values;
    rows.reserve(static_cast<std::size_t>(lower.nonZeros()));
    columns.reserve(rows.capacity());
    values.reserve(rows.capacity());
    for (Index c = 0; c < lower.cols(); ++c)
      for (SparseMatrix<double>::InnerIterator it(lower, c); it; ++it)
        if (it.row() >= c) {
          rows.push_back(static_cast<int>(it.row()) + 1);
          columns.push_back(static_cast<int>(c) + 1);
          values.push_back(it.value());
        }
    mumps.n = static_cast<int>(lower.rows());
    mumps.nnz = static_cast<MUMPS_INT8>(rows.size());
    mumps.irn = rows.data();
    mumps.jcn = columns.data();
    mumps.a = values.data();
    constexpr int singular_pattern = -6, too_little_work = -9, singular = -10;
    int outcome = call(1);
    if (outcome >= 0) outcome = call(2);
    while (outcome == too_little_work && control(14) < 1000) {
      control(14) *= 2;  // more than foreseen, %, because pivots were delayed
      outcome = call(2);
    }
    if (outcome == singular_pattern || outcome == singular) return false;
    check(outcome);
    const int negative_pivots = result(12);
    return mumps.sym == static_cast<int>(Kind::any) || negative_pivots == 0;
  }

  DMUMPS_STRUC_C mumps{};
};

LargeFactor::LargeFactor(const SparseMatrix<double>& lower, const std::string& what, Definiteness matrix) {
  using Kind = Implementation::Kind;
  const OneThread alone;
  implementation_ = std::make_unique<Implementation>(Kind::definite);
  if (implementation_->factorise(lower)) return;
  if (matrix == Definiteness::definite) throw std::invalid_argument(what);
  implementation_ = std::make_unique<Implementation>(Kind::any);
  if (!implementation_->factorise(lower)) throw std::invalid_argument(what);
}

LargeFactor::~LargeFactor() = default;

MatrixXd LargeFactor::solve(const MatrixXd& b) const {
  MatrixXd x = b;
  if (x.size() == 0) return x;
  const OneThread alone;
  Implementation& own = *implementation_;
  own.mumps.rhs = x.data();
  own.mumps.nrhs = static_cast<int>(x.cols());
  own.mumps.lrhs = static_cast<int>(x.rows());
  own.check(own.call(3));
  return x;
}

}  // namespace mimbre::fe
