#include "reduction/material_oddity.h"

#include <fmt/format.h>

namespace mimbre::fe {
namespace {

// From soft rubber to diamond, and from foam to tungsten.
constexpr double softest = 1e5, softest_heavy = 1e9, stiffest = 1.3e12;
constexpr double lightest = 10, heaviest_soft = 2200, heaviest = 25000;
/// Young's modulus over density, the square of a wave's speed: of carbon fibres 4e8.
constexpr double stiffest_of_its_mass = 6e8;

bool between(double low, double value, double high) { return low <= value && value <= high; }

}  // namespace

std::string oddity(const Material& m) {
  std::string text;
  const auto add = [&](const std::string& what, const std::string& likely) {
    text +=
        (text.empty() ? "" : ", ") + what + (likely.empty() ? "" : fmt::format(" (is it in {}?)", likely));
  };
  // What is as soft as rubber is as light: steel in MPa is not.
  const double least = between(lightest, m.density, heaviest_soft) ? softest : softest_heavy;
  const bool sound_modulus = between(least, m.young, stiffest);
  if (!sound_modulus)
    add(fmt::format("Young's modulus {:.6g} Pa", m.young), between(1e9, 1e6 * m.young, stiffest)   ? "MPa"
                                                           : between(1e9, 1e9 * m.young, stiffest) ? "GPa"
                                                                                                   : "");
  if (!between(lightest, m.density, heaviest) ||
      (sound_modulus && m.young > stiffest_of_its_mass * m.density))
    add(fmt::format("density {:.6g} kg/m³", m.density), between(500, 1e12 * m.density, heaviest)  ? "t/mm³"
                                                        : between(500, 1e3 * m.density, heaviest) ? "g/cm³"
                                                        : between(500, 1e9 * m.density, heaviest) ? "kg/mm³"
                                                                                                  : "");
  if (!between(0, m.poisson, 0.4999)) add(fmt::format("Poisson's ratio {:.4g}", m.poisson), "");
  return text;
}

}  // namespace mimbre::fe
