#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

namespace mimbre {

/// A mechanism's own units, so that similar mechanisms are judged alike whatever their size: what is neither
/// small nor large of a coordinate (lengths: the length scale L, m; angles: 1 rad; modal amplitudes: what
/// moves the body by about L) and of a constraint equation, and an acceleration that it may have at rest,
/// |g|/L, 1/s².
struct Scales {
  std::vector<double> coordinates, equations;
  std::vector<char> is_angle;  ///< by equation: Φ is in rad, otherwise in m
  /// By equation: it holds between velocities alone, so that positions are free along it; empty: none is.
  std::vector<char> is_rate;
  double acceleration = 0;
  double round_off = 0;  ///< what violations cannot be driven below

  /// max |x_k| / (scale of coordinate k): an increment by the mechanism's size, or rates and accelerations of
  /// it.
  double of_coordinates(const double* x, int* where = nullptr) const {
    return largest(x, coordinates, where);
  }
  /// The same of equations, their rates or second derivatives.
  double of_equations(const double* phi) const { return largest(phi, equations); }
  /// The largest of the equations that are lengths, and of those that are angles; not a number counts as 0.
  void of_kinds(const double* phi, double& length, double& angle) const {
    length = angle = 0;
    for (std::size_t k = 0; k < is_angle.size(); ++k) {
      double& most = is_angle[k] ? angle : length;
      most = std::max(most, std::abs(phi[k]));
    }
  }
  /// Of accelerations at play, 1/s²: of the coordinates, and of gravity.
  double accelerations(const double* a) const { return std::max(acceleration, of_coordinates(a)); }
  /// How fast things go that are neither slow nor fast, 1/s: as a pendulum does, without gravity as v.
  double rate(const double* v) const {
    return acceleration > 0 ? std::sqrt(acceleration) : of_coordinates(v);
  }

 private:
  static double largest(const double* x, const std::vector<double>& scale, int* where = nullptr) {
    double most = 0;
    for (std::size_t k = 0; k < scale.size(); ++k) {
      if (!(std::abs(x[k]) > most * scale[k])) continue;
      most = std::abs(x[k]) / scale[k];
      if (where) *where = static_cast<int>(k);
    }
    return most;
  }
};

}  // namespace mimbre
