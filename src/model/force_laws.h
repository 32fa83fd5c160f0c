#pragma once
#include <fmt/format.h>

#include <array>
#include <limits>
#include <span>
#include <string>
#include <string_view>

/// What there is to say of the laws of force elements besides their formulas, which are in src/forces: the
/// table here and that in forces/table.h have the same rows.
namespace mimbre {

/// A number of a law by its key in the model file.
struct LawNumber {
  static constexpr double none = std::numeric_limits<double>::infinity();
  std::string_view key = {};
  std::string_view unit = {};  ///< "m|rad": the second on an angle
  std::string_view about = {};
  double otherwise = std::numeric_limits<double>::quiet_NaN();  ///< where it is not given; NaN: it must be
  double above = -none;                                         ///< it has to be more than this,
  double least = -none, most = none;                            ///< and may be these

  constexpr bool allows(double x) const { return x > above && x >= least && x <= most; }
};

/// Place of a number by its key.
template <std::size_t n>
constexpr int place_of(const std::array<LawNumber, n>& numbers, std::string_view key) {
  int place = 0;
  while (numbers[static_cast<std::size_t>(place)].key != key) ++place;
  return place;
}

/// Why it does not allow x.
inline std::string wrong_number(const LawNumber& number, double x) {
  if (!(x > number.above)) return fmt::format("is {}; it has to be above {}", x, number.above);
  if (!(x >= number.least)) return fmt::format("is {}; it cannot be below {}", x, number.least);
  return fmt::format("is {}; it can be at most {}", x, number.most);
}

struct LawInfo {
  std::string_view name;     ///< in spec::Element::law
  std::string_view section;  ///< of the model file; empty: none of its own
  bool along = false;        ///< may act along the line between two frames,
  bool coordinate = false;   ///< on a joint's coordinate,
  bool axis = false;         ///< along or about a direction,
  bool relative = false;     ///< in all six components between two frames
  int arguments = 0;         ///< signals that it takes,
  std::span<const LawNumber> numbers = {};
  int states = 0;  ///< that it remembers from step to step, all 0 at first
  /// What is wrong with numbers that are right one by one; empty: nothing.
  std::string_view (*fault)(std::span<const double>) = nullptr;
  bool optional = false;     ///< signals: all of them or none
  bool coordinates = false;  ///< may act on a sum of joints' coordinates,
  bool path = false;         ///< along a line over several frames,
  bool velocity = false;     ///< against the velocity of a frame
  int functions = 0;         ///< that it has at most
  bool given = false;        ///< its force does not depend on what it measures
};

/// The rows, and so ElementData::law. `sensor` only measures.
enum class Law {
  spring,
  tyre,
  load,
  sensor,
  actuator,
  bushing,
  user,
  gas_spring,
  friction,
  stop,
  torsion_spring,
  cable,
  motor,
  drag,
  contact,
  brush_tyre,
  magic_tyre
};

/// Of a gas spring; the pressure is that at `length`.
constexpr std::array<LawNumber, 7> gas_spring_numbers{{
    {.key = "pressure", .unit = "Pa", .about = "of the gas at that length", .above = 0},
    {.key = "area", .unit = "m^2", .about = "of the piston", .above = 0},
    {.key = "length", .unit = "m", .about = "of the spring between its ends", .above = 0},
    {.key = "gas_length", .unit = "m", .about = "of the column of gas at that length", .above = 0},
    {.key = "exponent", .about = "1 slowly, 1.4 fast", .otherwise = 1.2, .above = 0},
    {.key = "damping", .unit = "N s/m", .about = "of the seals", .otherwise = 0, .least = 0},
    {.key = "ambient", .unit = "Pa", .about = "pressure outside", .otherwise = 101325, .least = 0},
}};

/// Of friction in a joint.
constexpr std::array<LawNumber, 5> friction_numbers{{
    {.key = "sticking",
     .unit = "m|rad",
     .about = "that the surfaces give before they slide",
     .otherwise = 1e-5,
     .above = 0},
    {.key = "static_ratio",
     .about = "of the limit at rest to that in fast sliding",
     .otherwise = 1,
     .least = 1},
    {.key = "stribeck",
     .unit = "m/s|rad/s",
     .about = "speed over which the limit falls to that in fast sliding",
     .otherwise = 1e-2,
     .above = 0},
    {.key = "viscous", .unit = "N s/m|N m s/rad", .about = "damping beside", .otherwise = 0, .least = 0},
    {.key = "settling",
     .unit = "s",
     .about = "in which a vibration of what sticks dies away",
     .otherwise = 1e-3,
     .least = 0},
}};

/// Of a stop at the end of a joint's travel, or of the distance of two points; ±1e300: nowhere.
constexpr std::array<LawNumber, 6> stop_numbers{{
    {.key = "lower", .unit = "m|rad", .about = "where it begins below", .otherwise = -1e300},
    {.key = "upper", .unit = "m|rad", .about = "where it begins above", .otherwise = 1e300},
    {.key = "stiffness",
     .unit = "N/m|N m/rad",
     .about = "at 'depth', or anywhere where the exponent is 1",
     .above = 0},
    {.key = "exponent", .about = "of the force over the depth; 1: linear", .otherwise = 1, .least = 1},
    {.key = "depth",
     .unit = "m|rad",
     .about = "at which the stiffness is that",
     .otherwise = 1e-3,
     .above = 0},
    {.key = "restitution",
     .about = "share of the speed that a blow leaves",
     .otherwise = 1,
     .least = 0.01,
     .most = 1},
}};

/// Behind them compile() puts two: the damping that the restitution needs (math/restitution.h), and the
/// speed, m/s or rad/s, below which no blow counts (model/slow_speeds.h).
constexpr int stop_damping = static_cast<int>(stop_numbers.size()), stop_slow = stop_damping + 1;

constexpr std::string_view stop_fault(std::span<const double> n) {
  if (n[0] <= -1e300 && n[1] >= 1e300) return "gives no end of the travel: 'lower' or 'upper' is needed";
  return n[0] < n[1] ? "" : "'lower' has to be below 'upper'";
}

/// Of a cable over points.
constexpr std::array<LawNumber, 4> cable_numbers{{
    {.key = "axial_stiffness", .unit = "N", .about = "E A: tension over strain", .above = 0},
    {.key = "damping", .unit = "N s/m", .about = "of the taut cable", .otherwise = 0, .least = 0},
    {.key = "length",
     .unit = "m",
     .about = "without tension; 0: such that the assembled cable has the preload",
     .otherwise = 0,
     .least = 0},
    {.key = "preload", .unit = "N", .about = "tension as assembled", .otherwise = 0, .least = 0},
}};

constexpr std::string_view cable_fault(std::span<const double> n) {
  return n[2] > 0 && n[3] > 0 ? "has a 'length' and a 'preload', which follow from each other; keep one" : "";
}

/// The length without tension, from the numbers that are given and the length in the assembled position.
constexpr double cable_rest_length(std::span<const double> n, double assembled) {
  return n[2] > 0 ? n[2] : assembled / (1 + n[3] / n[0]);
}

/// Of a motor on a joint's coordinate: by `constant` and `resistance`, or by a function, its curve.
constexpr std::array<LawNumber, 8> motor_numbers{{
    {.key = "ratio",
     .unit = "rad/m|",
     .about = "of the motor's turns to the joint's coordinate",
     .otherwise = 1},
    {.key = "inertia", .unit = "kg m^2", .about = "of the rotor", .otherwise = 0, .least = 0},
    {.key = "constant",
     .unit = "N m/A",
     .about = "torque over current, and voltage over speed",
     .otherwise = 0,
     .least = 0},
    {.key = "resistance", .unit = "ohm", .about = "of the winding", .otherwise = 0, .least = 0},
    {.key = "current_limit", .unit = "A", .about = "of either sign", .otherwise = 1e300, .above = 0},
    {.key = "torque_limit",
     .unit = "N m",
     .about = "at the motor, of either sign",
     .otherwise = 1e300,
     .above = 0},
    {.key = "drag", .unit = "N m s/rad", .about = "viscous, at the motor", .otherwise = 0, .least = 0},
    {.key = "efficiency",
     .about = "of the gear, which takes the rest of the torque as friction",
     .otherwise = 1,
     .above = 0,
     .most = 1},
}};

/// Behind them compile() puts the motor's speed, rad/s, within which the gear's friction turns about
/// (model/slow_speeds.h).
constexpr int motor_slow = static_cast<int>(motor_numbers.size());

constexpr std::string_view motor_fault(std::span<const double> n) {
  if (n[0] == 0) return "has the ratio 0, by which it would move nothing";
  return (n[2] > 0) == (n[3] > 0) ? "" : "'constant' and 'resistance' go together";
}

/// Of the rotor, as the joint's coordinate feels it, kg m² or kg.
constexpr double motor_inertia(std::span<const double> n) { return n[0] * n[0] * n[1]; }

/// Of the drag of a body in air.
constexpr std::array<LawNumber, 5> drag_numbers{{
    {.key = "area", .unit = "m^2", .about = "that the coefficients are for", .above = 0},
    {.key = "density", .unit = "kg/m^3", .about = "of the air", .otherwise = 1.225, .least = 0},
    {.key = "cx", .about = "coefficient along the frame's x", .least = 0},
    {.key = "cy", .about = "likewise y", .least = 0},
    {.key = "cz", .about = "likewise z", .least = 0},
}};

/// Of the contact of a sphere and a surface; some of their places.
constexpr std::size_t contact_restitution = 3, contact_rolling = 9, contact_spinning = 10;
/// What it remembers where it resists turning; where it does not, the table says.
constexpr int contact_turning_states = 22;
constexpr std::array<LawNumber, 11> contact_numbers{{
    {.key = "stiffness",
     .unit = "N/m",
     .about = "at 'depth', or anywhere where the exponent is 1",
     .above = 0},
    {.key = "exponent", .about = "of the force over the depth; 1: linear", .otherwise = 1, .least = 1},
    {.key = "depth", .unit = "m", .about = "at which the stiffness is that", .otherwise = 1e-3, .above = 0},
    {.key = "restitution",
     .about = "share of the speed that a blow leaves",
     .otherwise = 1,
     .least = 0.01,
     .most = 1},
    {.key = "friction",
     .about = "limit of the tangential force, by the normal one",
     .otherwise = 0,
     .least = 0},
    {.key = "static_ratio",
     .about = "of the limit at rest to that in fast sliding",
     .otherwise = 1,
     .least = 1},
    {.key = "stribeck",
     .unit = "m/s",
     .about = "speed over which the limit falls to that in fast sliding",
     .otherwise = 1e-2,
     .above = 0},
    {.key = "tangential",
     .about = "stiffness of what sticks, by that in the normal direction",
     .otherwise = 0.7,
     .above = 0},
    {.key = "settling",
     .unit = "s",
     .about = "in which a vibration of what sticks dies away",
     .otherwise = 1e-3,
     .least = 0},
    {.key = "rolling",
     .unit = "m",
     .about = "arm of the normal force that resists rolling",
     .otherwise = 0,
     .least = 0},
    {.key = "spinning",
     .unit = "m",
     .about = "arm of the normal force that resists turning about it",
     .otherwise = 0,
     .least = 0},
}};

/// Behind them as of stops.
constexpr int contact_damping = static_cast<int>(contact_numbers.size()), contact_slow = contact_damping + 1;

/// Of a tyre whose tread is a brush, besides its vertical stiffness and its radius, which come first; the
/// place of one of them. It rolls as a wheel that is smaller by a third of its deflection.
constexpr std::size_t brush_tyre_half_length = 6;
constexpr double brush_tyre_rolling = 1. / 3;
constexpr std::size_t brush_tyre_settling = 9;
constexpr std::array<LawNumber, 10> brush_tyre_numbers{{
    {.key = "damping", .unit = "N s/m", .about = "vertical", .otherwise = 0, .least = 0},
    {.key = "longitudinal_stiffness", .unit = "N", .about = "force over slip, at small slip", .above = 0},
    {.key = "cornering_stiffness",
     .unit = "N/rad",
     .about = "force over slip angle, at small angles",
     .above = 0},
    {.key = "friction", .about = "limit of the force along the road, by the vertical one", .least = 0},
    {.key = "longitudinal_relaxation",
     .unit = "m",
     .about = "way on which the force along follows its slip",
     .above = 0},
    {.key = "lateral_relaxation",
     .unit = "m",
     .about = "way on which the force across follows its slip",
     .above = 0},
    {.key = "half_length", .unit = "m", .about = "of the footprint", .above = 0},
    {.key = "load",
     .unit = "N",
     .about = "at which these are so: stiffnesses go with the load; 0: they do not",
     .otherwise = 0,
     .least = 0},
    {.key = "rolling_resistance",
     .about = "force that resists rolling, by the vertical one",
     .otherwise = 0,
     .least = 0},
    {.key = "settling",
     .unit = "s",
     .about = "damping over stiffness of the carcass, of a wheel that stands",
     .otherwise = 0.02,
     .least = 0},
}};

/// Among all its numbers, behind stiffness, radius and these: the speed at which it hardly rolls, m/s, of
/// find_scales().
constexpr int brush_tyre_slow = 2 + static_cast<int>(brush_tyre_numbers.size());

// clang-format off
constexpr std::array<LawInfo, 17> law_table{{
    {"spring", ""},
    {"tyre", ""},
    {"load", ""},
    {"sensor", "", true, true, true, true},
    {.name = "actuator", .section = "actuators", .along = true, .coordinate = true, .axis = true,
     .arguments = 1, .given = true},
    {.name = "bushing", .section = "bushings", .relative = true, .functions = 12},
    {"user", "", true, true, true, true},
    {"gas_spring", "gas_springs", true, false, false, false, 0, gas_spring_numbers},
    {"friction", "frictions", false, true, false, false, 1, friction_numbers, 4},
    {"stop", "stops", true, true, false, false, 0, stop_numbers, 1, stop_fault},
    {.name = "torsion_spring", .section = "torsion_springs", .coordinates = true, .functions = 2},
    {.name = "cable", .section = "cables", .arguments = 1, .numbers = cable_numbers, .states = 2,
     .fault = cable_fault, .optional = true, .path = true},
    {.name = "motor", .section = "motors", .coordinate = true, .arguments = 1, .numbers = motor_numbers,
     .fault = motor_fault, .functions = 1},
    {.name = "drag", .section = "drags", .arguments = 3, .numbers = drag_numbers, .optional = true,
     .velocity = true},
    {.name = "contact", .section = "", .numbers = contact_numbers, .states = 16},
    {.name = "brush_tyre", .section = "", .numbers = brush_tyre_numbers, .states = 9},
    {.name = "magic_tyre", .section = "", .states = 10},
}};
// clang-format on

/// What an element between two frames remembers of their turning (forces/measure_turning.h), before the
/// states of its law.
constexpr int turning_states = 8;

constexpr const LawInfo& law_info(int law) { return law_table[static_cast<std::size_t>(law)]; }
/// -1: there is none of that name.
constexpr int find_law(std::string_view name) {
  for (std::size_t k = 0; k < law_table.size(); ++k)
    if (law_table[k].name == name) return static_cast<int>(k);
  return -1;
}

}  // namespace mimbre
