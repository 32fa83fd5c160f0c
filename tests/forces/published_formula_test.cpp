#include "forces/published_formula.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "forces/magic_formula.h"
#include "support/random_mechanism.h"
#include "tyre_files/tyre_data.h"

/// All forces and moments of random tyres against the published equations, written a second time.
namespace mimbre::test::published_formula_test {
namespace {

using namespace forces;
using magic::Number;

const std::vector<std::pair<const char*, std::pair<double Published::*, double MagicOutput<double>::*>>>
    outputs{{"Fx", {&Published::Fx, &MagicOutput<double>::Fx}},
            {"Fy", {&Published::Fy, &MagicOutput<double>::Fy}},
            {"Mx", {&Published::Mx, &MagicOutput<double>::Mx}},
            {"My", {&Published::My, &MagicOutput<double>::My}},
            {"Mz", {&Published::Mz, &MagicOutput<double>::Mz}},
            {"trail", {&Published::trail, &MagicOutput<double>::trail}},
            {"sigma_kappa", {&Published::sigma_kappa, &MagicOutput<double>::sigma_kappa}},
            {"sigma_alpha", {&Published::sigma_alpha, &MagicOutput<double>::sigma_alpha}}};

Coefficients coefficients_of(const std::vector<double>& numbers) {
  Coefficients c;
  for (int i = 0; i < magic::count; ++i)
    c[std::string(magic::rows[static_cast<std::size_t>(i)].key)] = numbers[static_cast<std::size_t>(i)];
  c["version"] = numbers[magic::version];
  return c;
}

/// All numbers of the formulas off by up to 20 %; those that the file lacks get the size that other tyres
/// have.
std::vector<double> perturbed(std::vector<double> numbers, Random& random) {
  for (int i = magic::longitudinal_stiffness; i < magic::count; ++i) {
    double& x = numbers[static_cast<std::size_t>(i)];
    x = x == 0 ? random.number(-0.02, 0.02) : x * random.number(0.8, 1.2);
  }
  numbers[magic::lmuv] = random.number(0, 0.2);
  numbers[magic::longvl] = random.number(10, 20);
  if (numbers[magic::pty2] < 1) numbers[magic::pty2] = 2;
  return numbers;
}

/// Up to 49°: from 56° on the slip of the moment, tan α with the tangent taken once more, would come around.
Slip random_slip(const std::vector<double>& n, Random& random, double camber) {
  const auto cubed = [&](double size) { return size * std::pow(random.number(-1, 1), 3); };
  const double speed = random.number(0.5, 60);
  return {.Fz = n[magic::fnomin] * random.number(0.05, 2.5),
          .kappa = random.number(0, 1) < 0.2 ? 0 : cubed(1.5),
          .alpha = random.number(0, 1) < 0.2 ? 0 : cubed(0.85),
          .gamma = camber * random.number(-1, 1),
          .p = n[magic::nompres] * random.number(0.8, 1.2),
          .Vcx = random.number(0, 1) < 0.3 ? -speed : speed};
}

MagicOutput<double> ours(const std::vector<double>& numbers, const Slip& s) {
  const double nominal = numbers[magic::nompres];
  return magic_formula(numbers.data(), MagicInput<double>{.Fz = s.Fz,
                                                          .kappa = s.kappa,
                                                          .alpha = s.alpha,
                                                          .gamma = s.gamma,
                                                          .dpi = (s.p - nominal) / nominal,
                                                          .Vx = s.Vcx});
}

/// Largest difference of each output, by the size that it has on average.
void expect_as_published(const std::vector<double>& numbers, double camber, Random& random,
                         double tolerance) {
  const Coefficients c = coefficients_of(numbers);
  std::vector<Slip> slips;
  for (int k = 0; k < 200; ++k) slips.push_back(random_slip(numbers, random, camber));
  std::vector<Published> published;
  for (const Slip& s : slips) published.push_back(published_formula(c, s));
  for (const auto& [name, places] : outputs) {
    double mean = 0;
    for (const Published& want : published)
      mean += std::abs(want.*places.first) / static_cast<double>(slips.size());
    ASSERT_GT(mean, 0) << name;
    for (std::size_t k = 0; k < slips.size(); ++k) {
      const Slip& s = slips[k];
      const double want = published[k].*places.first;
      ASSERT_NEAR(ours(numbers, s).*places.second, want, tolerance * std::max(mean, std::abs(want)))
          << name << " Fz " << s.Fz << " kappa " << s.kappa << " alpha " << s.alpha << " gamma " << s.gamma
          << " p " << s.p << " Vcx " << s.Vcx;
    }
  }
}

struct Kind {
  const char* file;
  double camber;
  friend void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.file << ", " << kind.camber; }
};
class PublishedFormula : public testing::TestWithParam<Kind> {};

TEST_P(PublishedFormula, IsOurs) {
  const auto& [file, camber] = GetParam();
  std::vector<double> numbers = tyre_of(file).numbers;
  if (camber > 0.3) {  // as of motorcycles; a car's friction and stiffness would be used up by that camber
    numbers[magic::pdx3] = 0.5;
    numbers[magic::pdy3] = 0.8;
    numbers[magic::pky5] = -0.3;
  }
  Random random(11);
  expect_as_published(numbers, camber, random, 1e-7);
  for (int round = 0; round < 40; ++round)
    expect_as_published(perturbed(numbers, random), camber, random, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Tyres, PublishedFormula,
                         testing::Values(Kind{"car_205_60R15_61.tir", 0.1}, Kind{"every_term_61.tir", 0.1},
                                         Kind{"every_term_61.tir", 0.8}, Kind{"car_52.tir", 0.1},
                                         Kind{"car_52.tir", 0.8}));

/// No number of the formulas is one that the comparison does not see.
TEST(PublishedFormulas, EveryNumberOfTheFormulasCounts) {
  Random random(12);
  std::set<std::string> without{"FITTYP",  "WIDTH",           "RIM_RADIUS",       "INFLPRES",
                                "NOMPRES", "UNLOADED_RADIUS", "VERTICAL_DAMPING", "VERTICAL_STIFFNESS"};
  for (int i = magic::breff; i < magic::longitudinal_stiffness; ++i)
    without.insert(std::string(magic::rows[static_cast<std::size_t>(i)].key));
  std::vector<std::vector<double>> tyres;
  for (const char* file : {"every_term_61.tir", "car_52.tir"})
    tyres.push_back(perturbed(tyre_of(file).numbers, random));
  for (int i = 0; i < magic::count; ++i) {
    const std::string key(magic::rows[static_cast<std::size_t>(i)].key);
    if (without.contains(key)) continue;
    double change = 0;
    for (const auto& numbers : tyres) {
      std::vector<double> other = numbers;
      other[static_cast<std::size_t>(i)] *= 1.01;
      const Coefficients first = coefficients_of(numbers), second = coefficients_of(other);
      for (int k = 0; k < 20; ++k) {
        const Slip s = random_slip(numbers, random, 0.1);
        const Published a = published_formula(first, s), b = published_formula(second, s);
        const MagicOutput<double> c = ours(numbers, s), d = ours(other, s);
        for (const auto& [name, places] : outputs) {
          const double by = b.*places.first - a.*places.first, size = std::abs(a.*places.first);
          change = std::max(change, std::abs(by) / (size + 1e-9));
          EXPECT_NEAR(d.*places.second - c.*places.second, by, 1e-6 * (size + 1e-3)) << key << " " << name;
        }
      }
    }
    EXPECT_GT(change, 1e-6) << key;
  }
}

}  // namespace
}  // namespace mimbre::test::published_formula_test
