#pragma once
#include <cstddef>
#include <new>
#include <utility>
#include <vector>

#include "base/array.h"

/// Static block-sparse symmetric factorisation A = L D Lᵀ, the linear solver of every Newton step. All
/// decisions (elimination order, fill, storage, which number is added where) are taken once from the pattern;
/// the numeric part runs over small dense panels without index search, allocation, exceptions or locks, and
/// always in the same order, so that equal input gives equal bits.
namespace mimbre::linalg {

/// Blocks (one per body: its joint and elastic dofs together) and which pairs of them couple.
struct BlockPattern {
  std::vector<int> sizes;                      ///< unknowns of each block; 0 is allowed
  std::vector<std::pair<int, int>> couplings;  ///< pairs of blocks, in any order; repeats do no harm
};

/// Where a dense block lives in the array of values: its entry (r, c) is values[offset + r*row_stride +
/// c*col_stride].
struct BlockPlace {
  std::ptrdiff_t offset = 0;
  int row_stride = 1;
  int col_stride = 1;
};

/// Panels are padded to this many rows: a vector of AVX2 in doubles. The same for every target, as layouts
/// and the order of sums follow from it.
inline constexpr int kLanes = 4;

/// Consecutive columns of L with (nearly) the same rows, stored as a dense column-major panel. Its first
/// `columns` rows are the columns' own (lower triangle); the other rows start at row `below`, a multiple
/// of 4. Rows between and after them are zeros.
struct Panel {
  std::ptrdiff_t offset = 0;  ///< of entry (0, 0) in the values
  int columns = 0;
  int stride = 0;                         ///< rows with padding, a multiple of kLanes
  int below = 0;                          ///< panel row of the first of the other rows
  int first = 0;                          ///< place of the first column in the elimination order
  int first_row = 0;                      ///< where the other rows start in BlockSymbolic::rows()
  int first_update = 0, last_update = 0;  ///< range in BlockSymbolic::updates()
};

/// Once its panel is factorised, target(rows, columns) -= panel(row.., :) D panel(column.., :)ᵀ.
/// When row == column the target is a diagonal block and only its lower triangle matters.
struct PanelUpdate {
  std::ptrdiff_t target = 0;  ///< offset in the values
  int target_stride = 0;
  int row = 0, column = 0;  ///< panel rows where the left and the right factor start
  int rows = 0, columns = 0;
};

/// What follows from the pattern alone. Immutable, so threads may share it.
/// Order: minimum degree on the blocks weighted by their sizes; of equals the highest index first (leaves
/// first, where bodies are numbered from the root). Panels: blocks merged with their elimination-tree parent
/// where that is faster.
class BlockSymbolic {
 public:
  BlockSymbolic() = default;  ///< of no unknowns
  /// Throws std::invalid_argument for a negative size or a coupling of a block that does not exist.
  explicit BlockSymbolic(const BlockPattern& pattern);

  int size() const { return start_.back(); }  ///< scalar unknowns
  int blocks() const { return static_cast<int>(start_.size()) - 1; }
  int start(int block) const { return start_[block]; }  ///< unknown k of a block is start(block) + k
  std::ptrdiff_t value_count() const { return value_count_; }

  /// True for pairs named in the pattern, in either order, and for i == j.
  bool coupled(int i, int j) const;
  /// Where to write row block i, column block j; throws std::invalid_argument unless they are coupled. (i, j)
  /// and (j, i) are one place, strides swapped: write one of them. Of diagonal blocks only entries r >= c are
  /// read; the others may be written.
  BlockPlace place(int i, int j) const;

  const Array<Panel>& panels() const { return panels_; }
  const Array<PanelUpdate>& updates() const { return updates_; }
  /// The caller's unknowns in the panels' other rows, stride - below for each panel; any unknown for padding.
  const Array<int>& rows() const { return rows_; }
  /// The caller's unknown at each place of the elimination order.
  const Array<int>& unknowns() const { return unknowns_; }

 private:
  Array<int> start_{0};                   // block → first unknown, and the total
  Array<std::pair<int, int>> couplings_;  // i >= j, diagonals included, sorted
  Array<BlockPlace> places_;              // of couplings_
  Array<Panel> panels_;
  Array<PanelUpdate> updates_;
  Array<int> rows_;
  Array<int> unknowns_;
  std::ptrdiff_t value_count_ = 0;
};

/// Outcome of a factorisation: ok, or the caller's unknown whose pivot cannot be divided by (zero, not
/// finite).
struct FactorStatus {
  int unknown = -1;
  bool ok() const { return unknown < 0; }
};

/// Memory on cache-line boundaries.
template <class T>
struct CacheAligned {
  using value_type = T;
  CacheAligned() = default;
  template <class U>
  CacheAligned(const CacheAligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64})); }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  bool operator==(const CacheAligned&) const { return true; }
};

/// The numbers: assemble into values(), factor() in place, solve() as often as needed. One thread at a time.
/// The symbolic part must outlive it.
template <class T>
class BlockFactor {
 public:
  explicit BlockFactor(const BlockSymbolic& symbolic);
  explicit BlockFactor(BlockSymbolic&&) = delete;

  void set_zero() noexcept;
  T* values() { return values_.data(); }
  const T* values() const { return values_.data(); }

  /// L D Lᵀ without pivoting: any symmetric matrix whose leading minors, in the elimination order, do not
  /// vanish. Definite matrices always qualify. After a failure the values are of no use.
  FactorStatus factor() noexcept;
  /// x ← A⁻¹ x, x in the caller's order.
  void solve(T* x) const noexcept;
  /// Calls visit(x) for each number x of the factorisation, which is another's when all are replaced by its.
  template <class Visit>
  void transfer(Visit& visit) {
    for (T& x : values_) visit(x);
    for (T& x : inverse_) visit(x);
  }

 private:
  using Array = std::vector<T, CacheAligned<T>>;
  const BlockSymbolic* symbolic_;
  Array values_;          // A, then the panels of L
  Array inverse_;         // 1/D in the elimination order
  Array scaled_;          // L D of the panel in hand
  mutable Array column_;  // one number per row of a panel
};

/// y = A x from assembled (not factorised) values, both in the caller's order. A plain reference, not for the
/// step.
template <class T>
void multiply(const BlockSymbolic& symbolic, const T* values, const T* x, T* y);

/// out = A from assembled (not factorised) values, size × size, both triangles, in the caller's order.
template <class T>
void to_dense(const BlockSymbolic& symbolic, const T* values, T* out);

extern template class BlockFactor<double>;
extern template void multiply(const BlockSymbolic&, const double*, const double*, double*);
extern template void to_dense(const BlockSymbolic&, const double*, double*);

}  // namespace mimbre::linalg
