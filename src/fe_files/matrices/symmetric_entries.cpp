#include "fe_files/matrices/symmetric_entries.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "fe_files/units.h"

namespace mimbre::fe {

namespace {

using Entry = SymmetricEntries::Entry;

/// Programs round when they write; the two triangles may differ so much, relative to the largest entry.
constexpr double kAsymmetry = 1e-6;

bool before(const Entry& a, const Entry& b) { return std::tie(a.column, a.row) < std::tie(b.column, b.row); }
bool same_place(const Entry& a, const Entry& b) { return a.column == b.column && a.row == b.row; }

std::string place(const Entry& entry, const SolidMesh& mesh) {
  const auto name = [&](int key) {
    const Dof dof = dof_of_key(key);
    return fmt::format("node {} direction {}", mesh.labels[static_cast<std::size_t>(dof.node)],
                       dof.direction + 1);
  };
  return fmt::format("({}; {})", name(entry.row), name(entry.column));
}

void sort_and_merge(std::vector<Entry>& entries, SymmetricEntries::Repeated repeated, const Mark& mark,
                    const SolidMesh& mesh) {
  // Files are mostly written in order.
  if (!std::is_sorted(entries.begin(), entries.end(), before))
    std::sort(entries.begin(), entries.end(), before);
  std::size_t last = 0;
  for (std::size_t i = 1; i < entries.size(); ++i) {
    if (!same_place(entries[i], entries[last])) {
      entries[++last] = entries[i];
      continue;
    }
    if (repeated == SymmetricEntries::Repeated::refused)
      throw InputError(mark, fmt::format("the entry {} is there twice", place(entries[i], mesh)));
    entries[last].value += entries[i].value;
  }
  if (!entries.empty()) entries.resize(last + 1);
}

double largest(const std::vector<Entry>& entries) {
  double result = 0;
  for (const Entry& entry : entries) result = std::max(result, std::abs(entry.value));
  return result;
}

}  // namespace

std::vector<int> SymmetricEntries::keys() const {
  std::vector<int> result;
  const auto compact = [&] {
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
  };
  std::size_t compacted = 0;
  for (const std::vector<Entry>* entries : {&lower_, &upper_})
    for (const Entry& entry : *entries) {
      result.push_back(entry.column);
      result.push_back(entry.row);
      if (result.size() > 2 * compacted + 100000) {
        compact();
        compacted = result.size();
      }
    }
  compact();
  return result;
}

Eigen::SparseMatrix<double> SymmetricEntries::build(const std::vector<int>& keys, Repeated repeated,
                                                    Stored stored, const Mark& mark, const SolidMesh& mesh) {
  sort_and_merge(lower_, repeated, mark, mesh);
  sort_and_merge(upper_, repeated, mark, mesh);
  const bool lower_is_diagonal =
      std::all_of(lower_.begin(), lower_.end(), [](const Entry& e) { return e.row == e.column; });
  const bool both = !lower_is_diagonal && !upper_.empty();
  const double tolerance = kAsymmetry * std::max(largest(lower_), largest(upper_));
  // One list of both triangles, in place: the mirrored upper one adds what the lower one lacks.
  std::size_t l = 0;
  std::vector<Entry> added;
  for (const Entry& upper : upper_) {
    while (l < lower_.size() && before(lower_[l], upper)) {
      if (both && stored == Stored::full && lower_[l].row != lower_[l].column &&
          std::abs(lower_[l].value) > tolerance)
        throw InputError(
            mark, fmt::format("is not symmetric: the entry {} has no mirror image", place(lower_[l], mesh)));
      ++l;
    }
    if (l < lower_.size() && same_place(lower_[l], upper)) {
      if (std::abs(lower_[l].value - upper.value) > tolerance)
        throw InputError(mark, fmt::format("is not symmetric: {} at {} and {} at its mirror image",
                                           lower_[l].value, place(lower_[l], mesh), upper.value));
      lower_[l].value = 0.5 * (lower_[l].value + upper.value);
      ++l;
    } else {
      if (both && stored == Stored::full && std::abs(upper.value) > tolerance)
        throw InputError(
            mark, fmt::format("is not symmetric: the mirror image of {} is missing", place(upper, mesh)));
      added.push_back(upper);
    }
  }
  if (both && stored == Stored::full)
    for (; l < lower_.size(); ++l)
      if (lower_[l].row != lower_[l].column && std::abs(lower_[l].value) > tolerance)
        throw InputError(
            mark, fmt::format("is not symmetric: the entry {} has no mirror image", place(lower_[l], mesh)));
  upper_ = {};
  if (!added.empty()) {
    const auto middle = static_cast<std::ptrdiff_t>(lower_.size());
    lower_.insert(lower_.end(), added.begin(), added.end());
    added = {};
    std::inplace_merge(lower_.begin(), lower_.begin() + middle, lower_.end(), before);
  }
  if (lower_.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw InputError(mark, "has more entries than 2147483647");

  const int n = static_cast<int>(keys.size());
  // Keys are nearly dense: a table beats a search.
  std::vector<int> index(keys.empty() ? 0 : static_cast<std::size_t>(keys.back()) + 1, -1);
  for (int i = 0; i < n; ++i) index[static_cast<std::size_t>(keys[static_cast<std::size_t>(i)])] = i;
  const auto index_of = [&](int key, const Entry& entry) {
    const int found =
        static_cast<std::size_t>(key) < index.size() ? index[static_cast<std::size_t>(key)] : -1;
    if (found < 0)
      throw InputError(mark, fmt::format("the entry {} is not among the dofs", place(entry, mesh)));
    return found;
  };
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.resizeNonZeros(static_cast<Eigen::Index>(lower_.size()));
  int* starts = matrix.outerIndexPtr();
  std::fill(starts, starts + n + 1, 0);
  for (std::size_t i = 0; i < lower_.size(); ++i) {
    const Entry& entry = lower_[i];
    ++starts[index_of(entry.column, entry) + 1];
    matrix.innerIndexPtr()[i] = index_of(entry.row, entry);
    matrix.valuePtr()[i] = entry.value;
  }
  for (int i = 0; i < n; ++i) starts[i + 1] += starts[i];
  lower_ = {};
  return matrix;
}

void check_unique(const std::vector<Dof>& dofs, const SolidMesh& mesh, const Mark& mark) {
  std::vector<int> keys;
  for (const Dof& dof : dofs) keys.push_back(dof_key(dof));
  std::sort(keys.begin(), keys.end());
  const auto twice = std::adjacent_find(keys.begin(), keys.end());
  if (twice == keys.end()) return;
  const Dof dof = dof_of_key(*twice);
  throw InputError(mark, fmt::format("node {} direction {} is there twice",
                                     mesh.labels[static_cast<std::size_t>(dof.node)], dof.direction + 1));
}

void scale(Eigen::SparseMatrix<double>& matrix, const std::vector<Dof>& dofs, double factor, double length) {
  if (factor == 1 && length == 1) return;
  const auto arm = [&](int row) { return dofs[static_cast<std::size_t>(row)].direction >= 3 ? length : 1.0; };
  for (int column = 0; column < matrix.outerSize(); ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it)
      it.valueRef() *= factor * arm(static_cast<int>(it.row())) * arm(column);
}

namespace {

/// What a free body's matrices have: no force by a translation, the same mass along all three axes.
void check_translations(ImportedMatrices& result, const Mark& stiffness, const Mark& mass) {
  const auto& dofs = result.matrices.dofs;
  const auto n = static_cast<Eigen::Index>(dofs.size());
  Eigen::Vector3d masses;
  double total_stiffness = 0;
  for (int i = 0; i < n; ++i) total_stiffness += std::abs(result.matrices.stiffness.coeff(i, i));
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i)
      if (dofs[static_cast<std::size_t>(i)].direction == axis) unit(i) = 1;
    const Eigen::VectorXd force = result.matrices.stiffness.selfadjointView<Eigen::Lower>() * unit;
    masses(axis) = unit.dot(result.matrices.mass.selfadjointView<Eigen::Lower>() * unit);
    if (force.cwiseAbs().sum() > 1e-5 * total_stiffness)
      result.warnings.push_back(
          {{stiffness.file, 0, 0},
           fmt::format("the stiffness resists a translation along {}: the body must be exported without "
                       "constraints and with all of its dofs",
                       "xyz"[axis])});
  }
  if (!(masses.minCoeff() > 0) || masses.maxCoeff() - masses.minCoeff() > 1e-5 * masses.maxCoeff())
    result.warnings.push_back(
        {{mass.file, 0, 0},
         fmt::format(
             "the mass is {:.6g} kg along x, {:.6g} kg along y, {:.6g} kg along z: dofs are missing or the "
             "matrix is not the mass",
             masses.x(), masses.y(), masses.z())});
}

}  // namespace

ImportedMatrices finish_matrices(SolidMesh mesh, std::vector<Diagnostic> warnings, MatrixEntries entries,
                                 std::vector<Dof> rows, SymmetricEntries::Repeated repeated,
                                 SymmetricEntries::Stored stiffness_stored,
                                 SymmetricEntries::Stored mass_stored, const Mark& stiffness,
                                 const Mark& mass, const FileUnits& units) {
  check(units);
  std::vector<int> keys;
  if (rows.empty()) {
    keys = entries.stiffness.keys();
    const std::vector<int> others = entries.mass.keys();
    const auto middle = static_cast<std::ptrdiff_t>(keys.size());
    keys.insert(keys.end(), others.begin(), others.end());
    std::inplace_merge(keys.begin(), keys.begin() + middle, keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  } else {
    for (const Dof& dof : rows) keys.push_back(dof_key(dof));
    std::sort(keys.begin(), keys.end());
  }
  ImportedMatrices result;
  for (const int key : keys) result.matrices.dofs.push_back(dof_of_key(key));
  result.matrices.stiffness = entries.stiffness.build(keys, repeated, stiffness_stored, stiffness, mesh);
  result.matrices.mass = entries.mass.build(keys, repeated, mass_stored, mass, mesh);
  if (result.matrices.stiffness.nonZeros() == 0) throw InputError(stiffness, "has no stiffness");
  if (result.matrices.mass.nonZeros() == 0) throw InputError(mass, "has no mass");
  const double per_time = units.mass / (units.time * units.time);
  scale(result.matrices.stiffness, result.matrices.dofs, per_time, units.length);
  scale(result.matrices.mass, result.matrices.dofs, units.mass, units.length);
  result.file_dofs = std::move(rows);
  result.mesh = std::move(mesh);
  result.warnings = std::move(warnings);
  check_translations(result, stiffness, mass);
  return result;
}

}  // namespace mimbre::fe
