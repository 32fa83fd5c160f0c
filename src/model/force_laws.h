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
  std::string_view key;
  std::string_view unit;  ///< "m|rad": the second on an angle
  std::string_view about;
  double least = -std::numeric_limits<double>::infinity();      ///< it has to be larger than this
  double otherwise = std::numeric_limits<double>::quiet_NaN();  ///< where it is not given; NaN: it must be
  double most = std::numeric_limits<double>::infinity();        ///< the largest that it may be
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
  int states = 0;  ///< that it remembers from step to step, all 0 at first
  /// What is wrong with numbers that are right one by one; empty: nothing.
  std::string_view (*fault)(std::span<const double>) = nullptr;
};

/// The rows, and so ElementData::law. `sensor` only measures.
enum class Law { spring, tyre, load, sensor, actuator, bushing, user, gas_spring, friction, stop };

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

/// Of friction in a joint.
constexpr std::array<LawNumber, 5> friction_numbers{{
    {"sticking", "m|rad", "that the surfaces give before they slide", 0, 1e-5},
    {"static_ratio", "", "of the limit at rest to that in fast sliding", 1 - 1e-9, 1},
    {"stribeck", "m/s|rad/s", "speed over which the limit falls to that in fast sliding", 0, 1e-2},
    {"viscous", "N s/m|N m s/rad", "damping beside", -1e-300, 0},
    {"settling", "s", "time in which a vibration of what sticks dies away", -1e-300, 1e-3},
}};

/// Of a stop at the end of a joint's travel.
constexpr std::array<LawNumber, 6> stop_numbers{{
    {"lower", "m|rad", "where it begins below", -1e300, -1e299},
    {"upper", "m|rad", "where it begins above", -1e300, 1e299},
    {"stiffness", "N/m|N m/rad", "at the depth 'depth', or anywhere where the exponent is 1", 0},
    {"exponent", "", "of the force over the depth; 1: linear", 1 - 1e-9, 1},
    {"depth", "m|rad", "at which the stiffness is that", 0, 1e-3},
    {"restitution", "", "share of the speed that is left after a blow", 0.00999, 1, 1},
}};

constexpr std::string_view stop_fault(std::span<const double> n) {
  if (n[0] < -1e298 && n[1] > 1e298) return "gives no end of the travel: 'lower' or 'upper' is needed";
  return n[0] < n[1] ? "" : "'lower' has to be below 'upper'";
}

// clang-format off
constexpr std::array<LawInfo, 10> law_table{{
    {"spring", ""},
    {"tyre", ""},
    {"load", ""},
    {"sensor", "", true, true, true, true},
    {"actuator", "actuators", true, true, true, false, 1},
    {"bushing", "bushings", false, false, false, true},
    {"user", "", true, true, true, true},
    {"gas_spring", "gas_springs", true, false, false, false, 0, gas_spring_numbers},
    {"friction", "frictions", false, true, false, false, 1, friction_numbers, 4},
    {"stop", "stops", true, true, false, false, 0, stop_numbers, 1, stop_fault},
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
