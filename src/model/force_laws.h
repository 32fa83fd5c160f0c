#pragma once
#include <array>
#include <limits>
#include <span>
#include <string_view>

/// What there is to say of the laws of force elements besides their formulas, which are in src/forces: the
/// table here and that in forces/table.h have the same rows.
namespace mimbre {

/// A number of a law by its key in the model file.
struct LawNumber {
  std::string_view key, unit, about;
  double least = -std::numeric_limits<double>::infinity();      ///< it has to be larger than this
  double otherwise = std::numeric_limits<double>::quiet_NaN();  ///< where it is not given; NaN: it must be
};

struct LawInfo {
  std::string_view name;     ///< in spec::Element::law
  std::string_view section;  ///< of the model file; empty: none of its own
  bool along = false;        ///< may act along the line between two frames,
  bool coordinate = false;   ///< on a joint's coordinate,
  bool axis = false;         ///< along or about a direction,
  bool relative = false;     ///< in all six components between two frames
  int arguments = 0;         ///< signals that it takes
  std::span<const LawNumber> numbers = {};
};

/// The rows, and so ElementData::law. `sensor` only measures.
enum class Law { spring, tyre, load, sensor, actuator, bushing, user, gas_spring };

/// Of a gas spring; the pressure is that at `length`.
constexpr std::array<LawNumber, 7> gas_spring_numbers{{
    {"pressure", "Pa", "of the gas at that length", 0},
    {"area", "m^2", "of the piston", 0},
    {"length", "m", "of the spring between its ends", 0},
    {"gas_length", "m", "of the column of gas at that length", 0},
    {"exponent", "", "1 slowly, 1.4 fast", 0, 1.2},
    {"damping", "N s/m", "of the seals", -1e-300, 0},
    {"ambient", "Pa", "pressure outside", -1e-300, 101325},
}};

// clang-format off
constexpr std::array<LawInfo, 8> law_table{{
    {"spring", ""},
    {"tyre", ""},
    {"load", ""},
    {"sensor", "", true, true, true, true},
    {"actuator", "actuators", true, true, true, false, 1},
    {"bushing", "bushings", false, false, false, true},
    {"user", "", true, true, true, true},
    {"gas_spring", "gas_springs", true, false, false, false, 0, gas_spring_numbers},
}};
// clang-format on

constexpr const LawInfo& law_info(int law) { return law_table[static_cast<std::size_t>(law)]; }
/// -1: there is none of that name.
constexpr int find_law(std::string_view name) {
  for (std::size_t k = 0; k < law_table.size(); ++k)
    if (law_table[k].name == name) return static_cast<int>(k);
  return -1;
}

}  // namespace mimbre
