#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/array.h"
#include "mimbre/diagnostics.h"

/// Writes values as bytes and reads them again. A struct is written member by member, as its function
/// `members(archive, value)` lists them once for both (model_members.h).
namespace mimbre::archive {

/// T, or const T: what is read, or written.
template <class T, class U>
concept Of = std::same_as<std::remove_const_t<T>, U>;

/// A number as it is written: of the same length on every machine, whose words are 32 or 64 bits long.
template <class T>
struct Written {
  using type = T;
};
template <>
struct Written<bool> {
  using type = std::uint8_t;
};
template <>
struct Written<std::size_t> {
  using type = std::uint64_t;
};
template <class T>
requires std::is_enum_v<T>
struct Written<T> {
  using type = std::int32_t;
};
template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;
/// Of which a sequence is one block.
template <class T>
concept Block = Number<T> && std::same_as<typename Written<T>::type, T>;

class Writer {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void raw(const void* from, std::size_t size) {
    const auto* begin = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  void count(std::size_t size) { put(static_cast<std::uint64_t>(size)); }

  template <Number T>
  void put(const T& value) {
    const auto written = static_cast<typename Written<T>::type>(value);
    raw(&written, sizeof written);
  }
  void put(const std::string& text) {
    count(text.size());
    raw(text.data(), text.size());
  }
  template <class T>
  void sequence(const T& values) {
    count(values.size());
    if constexpr (Block<typename T::value_type>)
      raw(values.data(), values.size() * sizeof(typename T::value_type));
    else
      for (const auto& value : values) put(value);
  }
  void put(const std::vector<bool>& values) {
    count(values.size());
    for (const bool value : values) put(value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    sequence(values);
  }
  template <class T>
  void put(const Array<T>& values) {
    sequence(values);
  }
  template <class T, std::size_t n>
  void put(const std::array<T, n>& values) {
    for (const T& value : values) put(value);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  /// What several share is written once.
  template <class T>
  void put(const std::shared_ptr<const T>& shared) {
    if (!shared) return put(std::uint32_t{0});
    const auto [at, added] =
        shared_.try_emplace(shared.get(), static_cast<std::uint32_t>(shared_.size() + 1));
    put(at->second);
    if (added) put(*shared);
  }
  template <int rows, int columns>
  void put(const Eigen::Matrix<double, rows, columns>& m) {
    if constexpr (rows == Eigen::Dynamic) count(static_cast<std::size_t>(m.rows()));
    if constexpr (columns == Eigen::Dynamic) count(static_cast<std::size_t>(m.cols()));
    raw(m.data(), static_cast<std::size_t>(m.size()) * sizeof(double));
  }
  void put(const Eigen::SparseMatrix<double>& m) {
    count(static_cast<std::size_t>(m.rows()));
    count(static_cast<std::size_t>(m.cols()));
    count(static_cast<std::size_t>(m.nonZeros()));
    for (Eigen::Index column = 0; column < m.cols(); ++column)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(m, column); entry; ++entry)
        (*this)(static_cast<std::int32_t>(entry.row()), static_cast<std::int32_t>(column), entry.value());
  }
  template <class T>
  requires requires(Writer& writer, const T& value) { members(writer, value); }
  void put(const T& value) { members(*this, value); }

  std::vector<std::byte> bytes_;
  std::map<const void*, std::uint32_t> shared_;
};

/// Throws InputError where the bytes end too early or lengths cannot be.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  bool at_end() const { return left_.empty(); }

 private:
  [[noreturn]] static void damaged() { throw InputError(Mark{}, "these bytes of a model are damaged"); }
  void raw(void* to, std::size_t size) {
    if (size > left_.size()) damaged();
    if (size > 0) std::memcpy(to, left_.data(), size);
    left_ = left_.subspan(size);
  }
  /// Of things that have at least one byte each.
  std::size_t count() {
    std::uint64_t size = 0;
    get(size);
    if (size > left_.size()) damaged();
    return static_cast<std::size_t>(size);
  }
  /// Rows or columns, of which there may be many in an empty matrix.
  Eigen::Index extent() {
    std::uint64_t size = 0;
    get(size);
    if (size > 0x7fffffff) damaged();
    return static_cast<Eigen::Index>(size);
  }

  template <Number T>
  void get(T& value) {
    typename Written<T>::type written{};
    raw(&written, sizeof written);
    value = static_cast<T>(written);
  }
  void get(std::string& text) {
    text.resize(count());
    raw(text.data(), text.size());
  }
  template <class T>
  void sequence(T& values) {
    const std::size_t size = count();
    using Value = typename T::value_type;
    if constexpr (Block<Value>) {
      if (size > left_.size() / sizeof(Value)) damaged();
      values.resize(size);
      raw(values.data(), size * sizeof(Value));
    } else {
      for (std::size_t k = 0; k < size; ++k) get(values.emplace_back());
    }
  }
  void get(std::vector<bool>& values) {
    values.resize(count());
    for (std::size_t k = 0; k < values.size(); ++k) {
      bool value = false;
      get(value);
      values[k] = value;
    }
  }
  template <class T>
  void get(std::vector<T>& values) {
    sequence(values);
  }
  template <class T>
  void get(Array<T>& values) {
    values.clear();
    sequence(values);
  }
  template <class T, std::size_t n>
  void get(std::array<T, n>& values) {
    for (T& value : values) get(value);
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool there = false;
    get(there);
    value.reset();
    if (there) get(value.emplace());
  }
  template <class T>
  void get(std::shared_ptr<const T>& shared) {
    std::uint32_t number = 0;
    get(number);
    shared.reset();
    if (number == 0) return;
    if (number > shared_.size() + 1) damaged();
    if (number <= shared_.size()) {
      const Shared& known = shared_[number - 1];
      if (known.type != &type_of<T>) damaged();
      shared = std::static_pointer_cast<const T>(known.value);
      return;
    }
    const auto made = std::make_shared<T>();
    shared_.push_back({made, &type_of<T>});
    get(*made);
    shared = made;
  }
  template <int rows, int columns>
  void get(Eigen::Matrix<double, rows, columns>& m) {
    const Eigen::Index r = rows == Eigen::Dynamic ? extent() : rows;
    const Eigen::Index c = columns == Eigen::Dynamic ? extent() : columns;
    if (static_cast<std::uint64_t>(r) * static_cast<std::uint64_t>(c) > left_.size() / sizeof(double))
      damaged();
    m.resize(r, c);
    raw(m.data(), static_cast<std::size_t>(m.size()) * sizeof(double));
  }
  void get(Eigen::SparseMatrix<double>& m) {
    const Eigen::Index rows = extent(), columns = extent();
    const std::size_t entries = count();
    std::vector<Eigen::Triplet<double>> triplets;
    for (std::size_t k = 0; k < entries; ++k) {
      std::int32_t row = 0, column = 0;
      double value = 0;
      (*this)(row, column, value);
      if (row < 0 || row >= rows || column < 0 || column >= columns) damaged();
      triplets.emplace_back(row, column, value);
    }
    m.resize(rows, columns);
    m.setFromTriplets(triplets.begin(), triplets.end());
  }
  template <class T>
  requires requires(Reader& reader, T& value) { members(reader, value); }
  void get(T& value) { members(*this, value); }

  template <class T>
  static constexpr char type_of = 0;  ///< its address tells types apart
  struct Shared {
    std::shared_ptr<const void> value;
    const char* type;
  };
  std::span<const std::byte> left_;
  std::vector<Shared> shared_;
};

}  // namespace mimbre::archive
