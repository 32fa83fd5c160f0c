#include "simulation/watch/held_stretch.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "math/elementary.h"
#include "math/multiply_add.h"

/// What the watch computes in steps; once/held_stretch_start.cpp has how it begins.
namespace mimbre {
namespace {

using Eigen::Index;

/// sum + factor × column
template <class Matrix, std::size_t rows>
void add_multiple(const Matrix& matrix, int column, double factor, std::array<double, rows>& sum) {
  const double* const x = matrix.col(column).data();
  for (std::size_t r = 0; r < rows; ++r) sum[r] = multiply_add(x[r], factor, sum[r]);
}

/// Values by a signed index.
template <std::size_t size>
double& at(std::array<double, size>& values, int k) {
  return values[static_cast<std::size_t>(k)];
}
template <std::size_t size>
double at(const std::array<double, size>& values, int k) {
  return values[static_cast<std::size_t>(k)];
}

/// Forms by products, at c.
template <int rows, std::size_t size>
std::array<double, std::size_t{rows}> by_squares(const Eigen::Matrix<double, rows, Eigen::Dynamic>& forms,
                                                 int coordinates, const std::array<double, size>& c) {
  std::array<double, std::size_t{rows}> sum{};
  for (int i = 0, pair = 0; i < coordinates; ++i)
    for (int j = 0; j <= i; ++j, ++pair) add_multiple(forms, pair, at(c, i) * at(c, j), sum);
  return sum;
}

}  // namespace

void HeldStretch::transfer(StateTransfer& transfer) {
  for (Index k = 0; k < coupling_.size(); ++k) transfer(coupling_.data()[k]);
  for (Body& b : bodies_)
    for (Index k = 0; k < b.compliance.size(); ++k) transfer(b.compliance.data()[k]);
  transfer(slack_);
}

bool HeldStretch::find_press(Body& b, const double* amplitudes) {
  b.c = {};
  for (int k = 0; k < b.modes; ++k) add_multiple(b.bending, k, amplitudes[k], b.c);
  if (b.turn.size() == 0) return false;
  std::array<double, most_states> press{};
  for (int k = 0; k < b.modes; ++k) add_multiple(b.press, k, amplitudes[k], press);
  const std::array<double, most_states> turn = by_squares(b.turn, b.coordinates, b.c);
  // What A leaves of l_q, and its share in l.
  double square = 0, product = 0;
  for (int s = 0; s < b.states; ++s) {
    double left = 0;
    for (int t = 0; t < b.states; ++t) left += coupling_(b.first_state + s, b.first_state + t) * at(turn, t);
    square += left * left;
    product += left * at(press, s);
  }
  b.share = square > 0 ? std::clamp(product / square, 0.0, 1.0) : 0;
  for (int s = 0; s < b.states; ++s) press_[b.first_state + s] = b.share * at(turn, s);
  return b.share > 0;
}

void HeldStretch::release(Body& b, Ratios& ratios) {
  std::array<double, most_states> force{};
  for (int s = 0; s < b.states; ++s) at(force, s) = b.share * force_[b.first_state + s];
  std::array<double, most_coordinates> pressing{}, released = b.c;
  for (int i = 0, pair = 0; i < b.coordinates; ++i)
    for (int j = 0; j <= i; ++j, ++pair) {
      double weight = 0;
      for (int s = 0; s < b.states; ++s) weight += at(force, s) * b.turn(s, pair);
      at(pressing, i) += weight * at(b.c, j);
      at(pressing, j) += weight * at(b.c, i);
    }
  for (int i = 0; i < b.coordinates; ++i) add_multiple(b.compliance, i, at(pressing, i), released);
  double along = 0, square = 0;
  for (int i = 0; i < b.coordinates; ++i) {
    along += at(b.c, i) * at(released, i);
    square += at(released, i) * at(released, i);
  }
  if (square > 0) ratios.pressed = along / square;
  b.c = released;
}

const std::vector<HeldStretch::Ratios>& HeldStretch::find(const double* positions) {
  std::fill(ratios_.begin(), ratios_.end(), Ratios());
  if (slack_) return ratios_;
  bool pressed = false;
  for (Body& b : bodies_) pressed = find_press(b, positions + b.first_amplitude) || pressed;
  if (pressed) force_.noalias() = coupling_ * press_;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    Body& b = bodies_[k];
    if (b.share > 0) release(b, ratios_[k]);
    std::array<double, most_states> stretch = by_squares(b.stretch, b.coordinates, b.c);
    if (b.share > 0) {
      const std::array<double, most_states> turn = by_squares(b.turn, b.coordinates, b.c);
      for (int s = 0; s < b.states; ++s) at(stretch, s) += b.share * at(turn, s);
    }
    for (int s = 0; s < b.states; ++s) stretch_[b.first_state + s] = at(stretch, s);
  }
  force_.noalias() = coupling_ * stretch_;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Body& b = bodies_[k];
    double work = 0, energy = 0;
    for (int s = b.first_state; s < b.first_state + b.states; ++s) work += stretch_[s] * force_[s];
    for (const double x : b.c) energy += 0.5 * x * x;
    if (energy > 0) ratios_[k].missing = std::max(0.0, work) / energy;
  }
  return ratios_;
}

double HeldStretch::exaggeration(const Ratios& ratios) {
  // From above the root Newton's iterations come down to it.
  double share = ratios.missing > 1 ? 1 / mimbre::cbrt(ratios.missing) : 1;
  for (int k = 0; k < 40; ++k)
    share -= (share + ratios.missing * share * share * share - 1) / (1 + 3 * ratios.missing * share * share);
  return ratios.pressed / share - 1;
}

bool HeldStretch::exceeds(const Ratios& ratios, double most) {
  // α + ρ α³ grows with α: is it beyond 1 where σ/α − 1 is `most`, or below where that is −`most`?
  const auto left = [&](double share) { return share + ratios.missing * share * share * share; };
  return left(ratios.pressed / (1 + most)) > 1 || (most < 1 && left(ratios.pressed / (1 - most)) < 1);
}

}  // namespace mimbre
