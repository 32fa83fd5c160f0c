#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace mimbre {

/// Takes values to or from a flat block of numbers. Whatever remembers something from one step to the next
/// lists it once, in a function `transfer`, for counting, saving and restoring alike; so nothing is saved
/// that is not restored. Sizes are the model's: they are not transferred. Neither allocates nor throws.
class StateTransfer {
 public:
  /// Only counts.
  StateTransfer() = default;
  static StateTransfer to(std::span<double> block) { return StateTransfer(block.data(), nullptr); }
  static StateTransfer from(std::span<const double> block) { return StateTransfer(nullptr, block.data()); }

  /// Numbers so far.
  std::size_t count() const { return at_; }
  bool restoring() const { return from_ != nullptr; }

  template <class... Values>
  void operator()(Values&... values) {
    (value(values), ...);
  }

 private:
  StateTransfer(double* to, const double* from) : to_(to), from_(from) {}

  void numbers(double* x, std::size_t count) {
    if (to_) std::copy_n(x, count, to_ + at_);
    if (from_) std::copy_n(from_ + at_, count, x);
    at_ += count;
  }
  /// Whole numbers up to 2⁵³ and truth values.
  template <class Whole>
  void whole(Whole& x) {
    double number = static_cast<double>(x);
    numbers(&number, 1);
    if (from_) x = static_cast<Whole>(number);
  }

  void value(double& x) { numbers(&x, 1); }
  void value(int& x) { whole(x); }
  void value(std::int64_t& x) { whole(x); }
  void value(bool& x) { whole(x); }
  void value(std::vector<double>& x) { numbers(x.data(), x.size()); }
  template <int Rows, int Columns>
  void value(Eigen::Matrix<double, Rows, Columns>& x) {
    numbers(x.data(), static_cast<std::size_t>(x.size()));
  }
  template <int Rows, int Columns>
  void value(std::vector<Eigen::Matrix<double, Rows, Columns>>& all) {
    for (auto& x : all) value(x);
  }

  double* to_ = nullptr;
  const double* from_ = nullptr;
  std::size_t at_ = 0;
};

}  // namespace mimbre
