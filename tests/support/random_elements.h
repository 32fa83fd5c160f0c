#pragma once
#include <string>
#include <vector>

/// Random models with force elements of every kind, and with forces that jump: by events, sampled signals,
/// relays, inputs that the host sets, and time.
namespace mimbre::test {

/// An input that the host sets.
struct SetInput {
  double time = 0;  ///< s, a multiple of random_elements_grid
  std::string input;
  double value = 0;
};

/// s; what is sampled or set jumps at multiples of it.
constexpr double random_elements_grid = 0.02;

struct RandomElements {
  std::string text;
  std::vector<SetInput> sets;  ///< in the order of their times
  double end = 0.4;            ///< s
};

/// The same seed gives the same model. Some are a mechanism of joints of every type, some have wheels.
RandomElements random_elements(unsigned seed);

}  // namespace mimbre::test
