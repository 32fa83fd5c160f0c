#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_elements.h"

/// The energy balance of random models with elements of every kind and forces that jump closes with the
/// order of the rule.
namespace mimbre::test::random_balance_test {
namespace {

struct Balance {
  bool ok = true;
  double most = 0;  ///< J, the numerical energy in size, over the run
  double at_play =
      0;  ///< J, between the highest and the lowest energy, with what drives and loads turned over
};

Balance balance(const RandomElements& given, double step, spec::Simulation::Formulation formulation) {
  RunOptions options;
  options.step = step;
  options.energies = true;
  options.formulation = formulation;
  Simulation s(model_of(given.text), options);
  Balance b;
  double highest = s.energy().total(), lowest = highest - s.energy().kinetic, turnover = 0, work = 0;
  std::size_t next = 0;
  std::array<double, 8> last{};
  int step_number = 0;
  while (s.time() < given.end - 1e-9) {
    for (; next < given.sets.size() && given.sets[next].time < s.time() + 0.5 * step; ++next)
      s.set_input(s.input(given.sets[next].input), given.sets[next].value);
    const StepReport report = s.step();
    if (!report.ok()) {
      b.ok = false;
      std::cout << s.explain(report) << "\n";
      break;
    }
    const EnergyBalance& e = s.energy();
    last[static_cast<std::size_t>(step_number++) % last.size()] = std::abs(e.numerical);
    b.most = std::max(b.most, *std::min_element(last.begin(), last.end()));
    highest = std::max(highest, e.total());
    lowest = std::min(lowest, e.total() - e.kinetic);
    turnover += std::abs(e.drive_work + e.load_work + e.road_work - work);
    work = e.drive_work + e.load_work + e.road_work;
  }
  b.at_play = highest - lowest + turnover;
  return b;
}

int models() {
  const char* const given = std::getenv("MIMBRE_RANDOM_MODELS");
  return given ? std::atoi(given) : 24;
}

/// With MIMBRE_RANDOM_MODELS=500 as many, of which each prints a line; MIMBRE_RANDOM_STEP: the fine step, s.
TEST(RandomBalance, ClosesWithTheOrderOfTheRule) {
  const int count = models();
  const bool tells = count > 100;
  const char* const step = std::getenv("MIMBRE_RANDOM_STEP");
  const double fine_step = step ? std::atof(step) : 1.25e-4, coarse_step = 8 * fine_step;
  int second = 0, ran = 0;
  for (int seed = 1; seed <= count; ++seed) {
    const RandomElements given = random_elements(static_cast<unsigned>(seed));
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto formulation =
        seed % 2 ? spec::Simulation::Formulation::relative : spec::Simulation::Formulation::natural;
    try {
      const Balance coarse = balance(given, coarse_step, formulation),
                    fine = balance(given, fine_step, formulation);
      const double by = coarse.most / coarse.at_play, left = fine.most / fine.at_play,
                   order = std::log2(by / left) / 3;
      if (tells)
        std::cout << "model " << seed << " " << coarse.ok << fine.ok << " " << by << " " << left << " order "
                  << order << std::endl;
      EXPECT_TRUE(coarse.ok && fine.ok);
      if (!coarse.ok || !fine.ok) continue;
      ++ran;
      EXPECT_LT(left, 5e-4) << given.text;
      second += order > 1.5 || left < 1e-7;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "\n" << given.text;
    }
  }
  EXPECT_GE(second, 0.96 * ran);
}

}  // namespace
}  // namespace mimbre::test::random_balance_test
