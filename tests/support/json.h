#pragma once
#include <compare>
#include <cstddef>
#include <iosfwd>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace mimbre::test {

/// A value of a JSON text, to be looked at. What it is not is an error, never a default.
class Json {
 public:
  /// The text's whole value.
  static Json parse(const std::string& text);

  Json at(const std::string& key) const;
  Json at(std::size_t index) const;
  Json operator[](const std::string& key) const { return at(key); }
  Json operator[](const char* key) const { return at(std::string(key)); }
  Json operator[](int index) const { return at(static_cast<std::size_t>(index)); }
  Json operator[](std::size_t index) const { return at(index); }
  bool contains(const std::string& key) const;
  std::size_t size() const;  ///< of an array or an object
  bool empty() const { return size() == 0; }
  bool is_null() const;
  bool is_string() const;
  bool is_array() const;
  bool is_number() const;
  std::vector<std::string> keys() const;  ///< of an object
  std::string dump() const;
  /// An object without a key that it has.
  Json without(const std::string& key) const;

  double number() const;
  bool boolean() const;
  std::string text() const;
  std::vector<double> numbers() const;
  std::vector<std::string> texts() const;
  explicit operator bool() const { return boolean(); }
  operator double() const { return number(); }
  operator std::string() const { return text(); }

  /// An array's entries; an object's values.
  class Iterator {
   public:
    Json operator*() const { return of_->child(index_); }
    Iterator& operator++() {
      ++index_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return index_ == other.index_; }

   private:
    friend Json;
    Iterator(const Json* of, std::size_t index) : of_(of), index_(index) {}
    const Json* of_;
    std::size_t index_;
  };
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, size()}; }

  friend bool operator==(const Json& a, const Json& b) { return a.same(b); }
  friend bool operator==(const Json& a, const std::string& b) { return a.is_string() && a.text() == b; }
  friend bool operator==(const Json& a, const char* b) { return a == std::string(b); }
  friend bool operator==(const Json& a, const std::vector<double>& b) { return a.numbers() == b; }
  friend bool operator==(const Json& a, const std::vector<std::string>& b) { return a.texts() == b; }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  friend bool operator==(const Json& a, Number b) {
    if constexpr (std::is_same_v<Number, bool>)
      return a.boolean() == b;
    else
      return a.number() == static_cast<double>(b);
  }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  friend std::partial_ordering operator<=>(const Json& a, Number b) {
    return a.number() <=> static_cast<double>(b);
  }
  friend std::ostream& operator<<(std::ostream& out, const Json& json);

 private:
  Json child(std::size_t index) const;
  bool same(const Json& other) const;
  std::shared_ptr<const void> value_;  ///< owns the whole text's value
};

}  // namespace mimbre::test
