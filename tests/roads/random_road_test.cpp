#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "mimbre/road_profile.h"

/// Random roads: spectra, coherence of tracks, seeds.
namespace mimbre::random_road_test {
namespace {

using testing::HasSubstr;

constexpr int points = 1 << 13;
constexpr double increment = 0.1;

/// One-sided spectral densities of both tracks and across them, in bins of 1/(points increment) cycles/m.
/// Through a Hann window, whose mean square is 3/8: without it what long waves leak would cover the short
/// ones.
struct Spectra {
  std::vector<double> right, left;
  std::vector<std::complex<double>> cross;
};
void add(const RoadGrid& road, Spectra& sum) {
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> of[2];
  for (int track = 0; track < 2; ++track) {
    std::vector<double> windowed(points);
    for (int i = 0; i < points; ++i)
      windowed[static_cast<std::size_t>(i)] = road.height[static_cast<std::size_t>(2 * i + track)] *
                                              (0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / points));
    fft.fwd(of[track], windowed);
  }
  const double scale = 2 * increment / (points * 0.375);
  sum.right.resize(points / 2);
  sum.left.resize(points / 2);
  sum.cross.resize(points / 2);
  for (std::size_t k = 0; k < points / 2; ++k) {
    sum.right[k] += scale * std::norm(of[0][k]);
    sum.left[k] += scale * std::norm(of[1][k]);
    sum.cross[k] += scale * of[0][k] * std::conj(of[1][k]);
  }
}

RandomRoad class_c() {
  RandomRoad what;
  what.roughness = road_roughness('C');
  what.length = points * increment;
  what.increment = increment;
  return what;
}

class Bands : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    RandomRoad what = class_c();
    for (what.seed = 1; what.seed <= roads; ++what.seed) add(random_road(what), sum);
  }
  /// The mean over the octave around the frequency, as ISO 8608 smooths, of what is given by bin.
  template <class F>
  static auto mean_of(double centre, const F& by_bin) {
    const double bin = 1 / (points * increment);
    decltype(by_bin(std::size_t{}, 0.0)) total{};
    int count = 0;
    for (std::size_t k = 1; k < points / 2; ++k)
      if (const double n = bin * static_cast<double>(k);
          n >= centre / std::numbers::sqrt2 && n < centre * std::numbers::sqrt2) {
        total += by_bin(k, n);
        ++count;
      }
    return total / static_cast<double>(count);
  }
  static constexpr unsigned roads = 40;
  static inline Spectra sum;
};

/// Over the standard's range, 0.011 to 2.83 cycles/m, of 40 roads of 819 m. Single octaves of few long waves
/// scatter by 1/√(2 · 40 · bins): 4 % in the first.
TEST_F(Bands, HaveTheDensityOfTheClass) {
  for (double centre = std::pow(2, -6); centre <= 2; centre *= 2) {
    // Relative to the class's line at each frequency: the slope within an octave does not count.
    const auto relative = [](const std::vector<double>& density) {
      return [&](std::size_t k, double n) { return density[k] / roads / (256e-6 * std::pow(n / 0.1, -2)); };
    };
    EXPECT_NEAR(mean_of(centre, relative(sum.right)), 1, 0.1) << centre;
    EXPECT_NEAR(mean_of(centre, relative(sum.left)), 1, 0.1) << centre;
  }
}

/// What waves of all directions on a surface that is the same in all of them leave between two tracks, summed
/// by direction: n² ∫ (n² + m²)^−3/2 cos(2π m b) dm / 2 with m = n tan θ.
double coherence_of_directions(double n, double distance) {
  constexpr int count = 4000;
  double sum = 0;
  for (int k = 0; k < count; ++k) {
    const double angle = std::numbers::pi * ((k + 0.5) / count - 0.5);
    sum += std::cos(2 * std::numbers::pi * n * distance * std::tan(angle)) * std::cos(angle);
  }
  return 0.5 * sum * std::numbers::pi / count;
}

TEST_F(Bands, TracksHaveTheCoherenceOfTheirDistance) {
  for (double centre = std::pow(2, -6); centre <= 2; centre *= 2) {
    const std::complex<double> cross =
        mean_of(centre, [&](std::size_t k, double n) { return sum.cross[k] * n * n; });
    const double right = mean_of(centre, [&](std::size_t k, double n) { return sum.right[k] * n * n; });
    const double left = mean_of(centre, [&](std::size_t k, double n) { return sum.left[k] * n * n; });
    const double wanted =
        mean_of(centre, [](std::size_t, double n) { return coherence_of_directions(n, 1.5); });
    EXPECT_NEAR(cross.real() / std::sqrt(right * left), wanted, 0.05) << centre;
    EXPECT_NEAR(cross.imag() / std::sqrt(right * left), 0, 0.1) << centre;
  }
}

TEST(RandomRoad, ClassesGrowByFour) {
  EXPECT_DOUBLE_EQ(road_roughness('A'), 16e-6);
  EXPECT_DOUBLE_EQ(road_roughness('B'), 64e-6);
  EXPECT_DOUBLE_EQ(road_roughness('H'), 262144e-6);
  EXPECT_THROW(road_roughness('I'), std::invalid_argument);
  EXPECT_THROW(road_roughness('a'), std::invalid_argument);
}

/// ∫ Gd dn = Gd(n₀) n₀² (1/lowest − 1/highest), on a road that is long against its longest waves.
TEST(RandomRoad, HasTheVarianceOfItsSpectrum) {
  RandomRoad what;
  what.roughness = road_roughness('D');
  what.lowest = 0.2;
  what.highest = 1;
  what.length = 4000;
  what.increment = 0.25;
  const RoadGrid road = random_road(what);
  double square = 0;
  for (const double z : road.height) square += z * z / static_cast<double>(road.height.size());
  EXPECT_NEAR(square / (1024e-6 * 0.01 * (1 / 0.2 - 1)), 1, 0.05);
}

TEST(RandomRoad, IsThatOfItsSeed) {
  RandomRoad what = class_c();
  what.length = 20;
  const RoadGrid road = random_road(what);
  EXPECT_EQ(road.along(), 201u);
  EXPECT_EQ(road.x[10], 1.0);
  EXPECT_EQ(random_road(what).height, road.height);
  RandomRoad longer = what;
  longer.length = 50;
  const RoadGrid more = random_road(longer);
  EXPECT_EQ(std::vector<double>(more.height.begin(), more.height.begin() + 402), road.height);
  what.seed = 2;
  EXPECT_NE(random_road(what).height, road.height);
  what.roughness = 0;
  EXPECT_EQ(random_road(what).height, std::vector<double>(402));
}

/// Tracks so near to each other that they can hardly differ, and many of them.
TEST(RandomRoad, NeighbouringTracksAreAlike) {
  RandomRoad what = class_c();
  what.length = 50;
  what.v.clear();
  for (int k = 0; k < 10; ++k) what.v.push_back(0.01 * k);
  const RoadGrid road = random_road(what);
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < road.along(); ++i)
    for (std::size_t k = 1; k < 10; ++k) {
      worst = std::max(worst, std::abs(road.height[i * 10 + k] - road.height[i * 10 + k - 1]));
      largest = std::max(largest, std::abs(road.height[i * 10 + k]));
    }
  EXPECT_LT(worst, 0.1 * largest);
}

TEST(RandomRoad, SaysWhatCannotBe) {
  const auto complaint = [](auto change) {
    RandomRoad what = class_c();
    change(what);
    try {
      random_road(what);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(complaint([](RandomRoad& r) { r.highest = 6; }), HasSubstr("at most 5: an increment of 0.1 m"));
  EXPECT_THAT(complaint([](RandomRoad& r) { r.roughness = -1; }), HasSubstr("the roughness is -1"));
  EXPECT_THAT(complaint([](RandomRoad& r) { r.roughness = NAN; }), HasSubstr("the roughness is nan"));
  EXPECT_THAT(complaint([](RandomRoad& r) { r.waviness = 5; }), HasSubstr("the waviness is 5; 1 to 4"));
  EXPECT_THAT(complaint([](RandomRoad& r) { r.v = {1}; }), HasSubstr("1 tracks; 2 to 200"));
  EXPECT_THAT(complaint([](RandomRoad& r) { r.v = {1, 0}; }), HasSubstr("the track 2 is at 0 m"));
  EXPECT_THAT(complaint([](RandomRoad& r) { r.length = 0; }), HasSubstr("the length is 0 m"));
  EXPECT_THAT(complaint([](RandomRoad& r) { r.length = 1e9; }), HasSubstr("more than 50000000 heights"));
}

}  // namespace
}  // namespace mimbre::random_road_test
