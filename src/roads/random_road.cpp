#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "base/random_numbers.h"
#include "math/elementary.h"
#include "math/once/decompositions.h"
#include "mimbre/road_profile.h"

namespace mimbre {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double reference = 0.1;         ///< n₀, cycles/m
constexpr double waves_per_factor = 170;  ///< in a band whose ends are as 1 and e: 118 to an octave
constexpr std::size_t most_points = 50'000'000, most_tracks = 200;

/// Modified Bessel function of the second kind, K_ν(x) = ∫₀^∞ exp(−x cosh t) cosh(ν t) dt. The integrand and
/// all its derivatives are even and vanish at the far end, so that the trapezoidal rule converges like an
/// exponential.
double bessel_k(double order, double x) {
  constexpr double step = 0.05;
  double sum = 0.5 * mimbre::exp(-x);
  for (double t = step; x * mimbre::cosh(t) < 700; t += step)
    sum += mimbre::exp(-x * mimbre::cosh(t)) * mimbre::cosh(order * t);
  return step * sum;
}

/// Γ(x) = Γ(x + 3) / (x (x + 1) (x + 2)), Γ(y) = ∫ exp(y t − exp t) dt over all t: again by the trapezoidal
/// rule. Of 0.5 ≤ x ≤ 2; the C library's has other bits on other machines.
double gamma(double x) {
  constexpr double step = 0.2;
  double sum = 0;
  for (int k = -60; k <= 24; ++k) sum += mimbre::exp((x + 3) * step * k - mimbre::exp(step * k));
  return step * sum / (x * (x + 1) * (x + 2));
}

double coherence(double waviness, double frequency, double distance) {
  const double half = waviness / 2, x = 2 * pi * frequency * distance;
  if (x < 1e-6) return 1;
  if (x > 600) return 0;
  return 2 * mimbre::pow(x / 2, half) * bessel_k(half, x) / gamma(half);
}

void check(const RandomRoad& what) {
  const auto need = [](bool good, const std::string& message) {
    if (!good) throw std::invalid_argument("random road: " + message);
  };
  const auto is_positive = [](double x) { return x > 0 && std::isfinite(x); };
  need(what.roughness >= 0 && std::isfinite(what.roughness),
       fmt::format("the roughness is {} m³; it must not be below 0", what.roughness));
  need(what.waviness >= 1 && what.waviness <= 4,
       fmt::format("the waviness is {}; 1 to 4 is needed", what.waviness));
  need(is_positive(what.increment), fmt::format("the increment is {} m; it must be above 0", what.increment));
  need(is_positive(what.length) && what.length >= what.increment,
       fmt::format("the length is {} m; it must not be below the increment", what.length));
  need(is_positive(what.lowest) && what.lowest < what.highest &&
           what.highest <= 0.5 / what.increment * (1 + 1e-9),
       fmt::format(
           "frequencies from {} to {} cycles/m; they must grow, be above 0 and at most {}: an increment of "
           "{} m shows no shorter waves",
           what.lowest, what.highest, 0.5 / what.increment, what.increment));
  need(what.v.size() >= 2 && what.v.size() <= most_tracks,
       fmt::format("{} tracks; 2 to {} are needed", what.v.size(), most_tracks));
  for (std::size_t k = 0; k < what.v.size(); ++k)
    need(std::isfinite(what.v[k]) && (k == 0 || what.v[k] - what.v[k - 1] >= 1e-3),
         fmt::format("the track {} is at {} m; tracks go from right to left, 1 mm apart at least", k + 1,
                     what.v[k]));
  need(what.length / what.increment * static_cast<double>(what.v.size()) < static_cast<double>(most_points),
       fmt::format("more than {} heights", most_points));
}

/// Of one wave: what each track has of its cosine and of its sine.
struct Wave {
  double frequency;  ///< cycles/m
  Eigen::VectorXd cosine, sine;
};

/// With phases of its own for each track, mixed so that tracks have the coherence of their distance.
Wave wave(const RandomRoad& what, std::uint64_t number, double low, double high) {
  const Eigen::Index tracks = static_cast<Eigen::Index>(what.v.size());
  const std::uint64_t place = number * (most_tracks + 1);
  Wave out;
  out.frequency = low * mimbre::pow(high / low, uniform_at(what.seed, place));
  const double density = what.roughness * mimbre::pow(out.frequency / reference, -what.waviness);
  const double amplitude = std::sqrt(2 * density * (high - low));
  Eigen::MatrixXd together(tracks, tracks);  // below the diagonal
  Eigen::VectorXd c(tracks), s(tracks);
  for (Eigen::Index i = 0; i < tracks; ++i) {
    const double phase = 2 * pi * uniform_at(what.seed, place + 1 + static_cast<std::uint64_t>(i));
    c(i) = mimbre::cos(phase);
    s(i) = mimbre::sin(phase);
    for (Eigen::Index j = 0; j <= i; ++j)
      together(i, j) =
          coherence(what.waviness, out.frequency,
                    std::abs(what.v[static_cast<std::size_t>(i)] - what.v[static_cast<std::size_t>(j)]));
  }
  // Of long waves the tracks hardly differ; what is added keeps the matrix away from a singular one.
  together.diagonal().array() += 1e-10;
  const Eigen::MatrixXd mixing = Cholesky(together).lower();
  out.cosine = amplitude * (mixing * c);
  out.sine = -amplitude * (mixing * s);
  return out;
}

}  // namespace

double road_roughness(char road_class) {
  if (road_class < 'A' || road_class > 'H')
    throw std::invalid_argument(fmt::format("no road class '{}'; A to H are of ISO 8608", road_class));
  return 16e-6 * mimbre::pow(4.0, road_class - 'A');
}

RoadGrid random_road(const RandomRoad& what) {
  check(what);
  RoadGrid road;
  const std::size_t rows = static_cast<std::size_t>(std::ceil(what.length / what.increment - 1e-9)) + 1;
  const std::size_t tracks = what.v.size();
  road.increment = what.increment;
  for (std::size_t i = 0; i < rows; ++i) road.x.push_back(what.increment * static_cast<double>(i));
  road.y = road.line_height = road.bank = std::vector<double>(rows);
  road.v = what.v;
  road.height.assign(rows * tracks, 0);
  const double factor = what.highest / what.lowest;
  const int waves = std::max(1, static_cast<int>(std::ceil(waves_per_factor * mimbre::log(factor))));
  for (int k = 0; k < waves; ++k) {
    const Wave w = wave(what, static_cast<std::uint64_t>(k),
                        what.lowest * mimbre::pow(factor, static_cast<double>(k) / waves),
                        what.lowest * mimbre::pow(factor, static_cast<double>(k + 1) / waves));
    const double turn = 2 * pi * w.frequency * what.increment, turn_c = mimbre::cos(turn),
                 turn_s = mimbre::sin(turn);
    double c = 1, s = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      // Turned on from row to row; now and then anew, so that round-off does not grow.
      if (i % 64 == 0) {
        c = mimbre::cos(turn * static_cast<double>(i));
        s = mimbre::sin(turn * static_cast<double>(i));
      }
      for (std::size_t j = 0; j < tracks; ++j)
        road.height[i * tracks + j] +=
            w.cosine(static_cast<Eigen::Index>(j)) * c + w.sine(static_cast<Eigen::Index>(j)) * s;
      const double next = c * turn_c - s * turn_s;
      s = s * turn_c + c * turn_s;
      c = next;
    }
  }
  return road;
}

}  // namespace mimbre
