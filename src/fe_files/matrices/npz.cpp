#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/zip_file.h"
#include "fe_files/matrices/matrix_files.h"
#include "fe_files/text.h"

// Format: NumPy Enhancement Proposal 1 (.npy), scipy.sparse.save_npz.

namespace mimbre::fe {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are read as they stand in the file");

[[noreturn]] void fail(const std::string& name, const std::string& message) {
  throw InputError({name, 0, 0}, message);
}

/// One array: its kind ("<f8"), shape, length (product of the shape) and bytes.
struct Array {
  std::string kind;
  std::vector<std::int64_t> shape;
  bool by_columns = false;
  std::uint64_t length = 1;
  std::string_view data;
};

/// The text after `key` in the head, a dictionary as Python writes it.
std::string_view value_of(std::string_view head, std::string_view key, const std::string& name) {
  const std::size_t at = head.find(key);
  if (at == std::string_view::npos) fail(name, fmt::format("an array's head has no {}", key));
  head.remove_prefix(at + key.size());
  const std::size_t colon = head.find(':');
  return colon == std::string_view::npos ? std::string_view() : trimmed(head.substr(colon + 1));
}

Array parse_npy(std::string_view bytes, const std::string& name) {
  if (bytes.size() < 12 || bytes.substr(0, 6) != std::string_view("\x93NUMPY", 6))
    fail(name, "has a member that is no NumPy array");
  const int version = bytes[6];
  const std::size_t start = version == 1 ? 10 : 12;
  std::size_t length = 0;
  for (std::size_t i = start; i-- > 8;) length = length << 8 | static_cast<unsigned char>(bytes[i]);
  if (version < 1 || version > 3 || length > bytes.size() - start)
    fail(name, "has a NumPy array without a proper head");
  const std::string_view head = bytes.substr(start, length);
  Array array;
  std::string_view kind = value_of(head, "'descr'", name);
  if (kind.size() < 2 || kind[0] != '\'' || kind.find('\'', 1) == std::string_view::npos)
    fail(name, "has a structured NumPy array; plain numbers are needed");
  array.kind = kind.substr(1, kind.find('\'', 1) - 1);
  array.by_columns = value_of(head, "'fortran_order'", name).starts_with("True");
  std::string_view shape = value_of(head, "'shape'", name);
  const std::size_t end = shape.find(')');
  if (shape.empty() || shape[0] != '(' || end == std::string_view::npos)
    fail(name, "has a NumPy array without a shape");
  shape = shape.substr(1, end - 1);
  while (!trimmed(shape).empty()) {
    const auto extent = to_integer(next_field(shape));
    if (!extent || *extent < 0) fail(name, "has a NumPy array of an odd shape");
    const auto factor = static_cast<std::uint64_t>(*extent);
    if (factor > 0 && array.length > std::numeric_limits<std::uint64_t>::max() / factor)
      fail(name, "has an array of an absurd size");
    array.length *= factor;
    array.shape.push_back(*extent);
  }
  array.data = bytes.substr(start + length);
  return array;
}

template <class Number, class Result>
std::vector<Result> convert(const Array& array, const std::string& member, const std::string& name) {
  if (array.data.size() / sizeof(Number) < array.length || array.data.size() != array.length * sizeof(Number))
    fail(name,
         fmt::format("the array '{}' has {} bytes for {} numbers", member, array.data.size(), array.length));
  std::vector<Result> result(array.length);
  for (std::size_t i = 0; i < result.size(); ++i) {
    Number number;
    std::memcpy(&number, array.data.data() + i * sizeof(Number), sizeof(Number));
    result[i] = static_cast<Result>(number);
  }
  return result;
}

std::vector<std::int64_t> integers(const ZipFile& zip, const std::string& member, const std::string& name) {
  const std::string bytes = zip.read(member + ".npy");
  const Array array = parse_npy(bytes, name);
  if (array.kind == "<i4") return convert<std::int32_t, std::int64_t>(array, member, name);
  if (array.kind == "<i8") return convert<std::int64_t, std::int64_t>(array, member, name);
  fail(name,
       fmt::format("the array '{}' is of the kind '{}', not of whole numbers", member, shown(array.kind)));
}

std::vector<double> reals(const Array& array, const std::string& member, const std::string& name) {
  if (array.kind == "<f8") return convert<double, double>(array, member, name);
  if (array.kind == "<f4") return convert<float, double>(array, member, name);
  if (array.kind == "<i4") return convert<std::int32_t, double>(array, member, name);
  if (array.kind == "<i8") return convert<std::int64_t, double>(array, member, name);
  fail(name,
       fmt::format("the array '{}' is of the kind '{}', not of real numbers", member, shown(array.kind)));
}

std::vector<double> reals(const ZipFile& zip, const std::string& member, const std::string& name) {
  const std::string bytes = zip.read(member + ".npy");
  return reals(parse_npy(bytes, name), member, name);
}

/// Letters of the array 'format', which are bytes or UTF-32.
std::string format_of(const ZipFile& zip, const std::string& name) {
  if (!zip.has("format.npy")) fail(name, "is no matrix of scipy.sparse.save_npz: it has no member 'format'");
  const std::string bytes = zip.read("format.npy");
  std::string letters;
  for (const char c : parse_npy(bytes, name).data)
    if (c != '\0') letters += c;
  return letters;
}

}  // namespace

SparseFile parse_npz(std::string bytes, const std::string& name) {
  SparseFile file = parse_any_npz(std::move(bytes), name);
  if (file.rows != file.columns) fail(name, "must be a square matrix");
  return file;
}

SparseFile parse_any_npz(std::string bytes, const std::string& name) {
  const ZipFile zip(std::move(bytes), name);
  const std::string format = format_of(zip, name);
  const std::vector<std::int64_t> shape = integers(zip, "shape", name);
  constexpr std::int64_t most = std::numeric_limits<int>::max();
  if (shape.size() != 2 || shape[0] < 1 || shape[0] > most || shape[1] < 1 || shape[1] > most)
    fail(name, "must be a matrix");
  SparseFile file;
  file.rows = shape[0];
  file.columns = shape[1];
  file.value = reals(zip, "data", name);
  const std::size_t n = file.value.size();
  for (const double value : file.value)
    if (!std::isfinite(value)) fail(name, "has entries that are not finite");
  const auto checked = [&](const std::vector<std::int64_t>& indices, std::int64_t count, const char* what) {
    if (indices.size() != n) fail(name, fmt::format("has {} indices for {} entries", indices.size(), n));
    std::vector<int> result(n);
    for (std::size_t i = 0; i < n; ++i) {
      if (indices[i] < 0 || indices[i] >= count)
        fail(name, fmt::format("has the index {} where there are {} {}", indices[i], count, what));
      result[i] = static_cast<int>(indices[i]);
    }
    return result;
  };
  if (format == "coo") {
    file.row = checked(integers(zip, "row", name), file.rows, "rows");
    file.column = checked(integers(zip, "col", name), file.columns, "columns");
    return file;
  }
  if (format != "csr" && format != "csc")
    fail(name, fmt::format("is stored as '{}'; write A.tocsr(), A.tocsc() or A.tocoo()", shown(format)));
  const bool by_rows = format == "csr";
  const std::vector<int> inner = by_rows ? checked(integers(zip, "indices", name), file.columns, "columns")
                                         : checked(integers(zip, "indices", name), file.rows, "rows");
  const std::vector<std::int64_t> starts = integers(zip, "indptr", name);
  bool good = starts.size() == static_cast<std::size_t>(by_rows ? file.rows : file.columns) + 1 &&
              starts.front() == 0 && starts.back() == static_cast<std::int64_t>(n);
  for (std::size_t i = 1; good && i < starts.size(); ++i) good = starts[i] >= starts[i - 1];
  if (!good) fail(name, "has an array 'indptr' that does not fit to its entries");
  std::vector<int> outer(n);
  for (std::size_t i = 0; i + 1 < starts.size(); ++i)
    std::fill(outer.begin() + starts[i], outer.begin() + starts[i + 1], static_cast<int>(i));
  file.row = by_rows ? outer : inner;
  file.column = by_rows ? inner : outer;
  return file;
}

Eigen::MatrixXd npz_matrix(const ZipFile& zip, const std::string& member, const std::string& name) {
  const std::string bytes = zip.read(member + ".npy");
  const Array array = parse_npy(bytes, name);
  if (array.shape.empty() || array.shape.size() > 2)
    fail(name, fmt::format("the array '{}' is no table", member));
  const std::vector<double> values = reals(array, member, name);
  const Eigen::Index rows = array.shape[0], columns = array.shape.size() == 2 ? array.shape[1] : 1;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (array.by_columns) return Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, columns);
  return Eigen::Map<const RowMajor>(values.data(), rows, columns);
}

}  // namespace mimbre::fe
