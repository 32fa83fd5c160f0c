#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>

/// Units behind numbers: `5 mm`, `2 kN/m`, `10 rpm`.
namespace mimbre::model_file {

/// Exponents of the base units.
struct Dimension {
  int kilogram = 0, metre = 0, second = 0, radian = 0, ampere = 0;
  bool operator==(const Dimension&) const = default;
};
Dimension product(const Dimension& a, const Dimension& b);
Dimension power(const Dimension& a, int exponent);

/// What a key's number measures.
struct Quantity {
  std::string_view unit;               ///< as messages and results call it; empty: a pure number
  std::optional<Dimension> dimension;  ///< none: any unit fits, as for parameters
  std::string_view others = {};        ///< other units of it that are in use, for messages
};
/// "kg is needed here (or g, lb)"
std::string needed(const Quantity& quantity);

namespace quantity {
inline constexpr Quantity any{"", {}};
inline constexpr Quantity number{"", Dimension{}};
inline constexpr Quantity mass{"kg", Dimension{1}, "g, lb"};
inline constexpr Quantity length{"m", Dimension{0, 1}, "mm, cm, in, ft"};
inline constexpr Quantity area{"m^2", Dimension{0, 2}, "mm^2, cm^2"};
inline constexpr Quantity section_modulus{"m^3", Dimension{0, 3}, "mm^3, cm^3"};
inline constexpr Quantity second_moment{"m^4", Dimension{0, 4}, "mm^4, cm^4"};
inline constexpr Quantity time{"s", Dimension{0, 0, 1}, "ms, min"};
inline constexpr Quantity angle{"rad", Dimension{0, 0, 0, 1}, "deg"};
inline constexpr Quantity speed{"m/s", Dimension{0, 1, -1}, "mm/s, km/h"};
inline constexpr Quantity turning_speed{"rad/s", Dimension{0, 0, -1, 1}, "deg/s, rpm"};
inline constexpr Quantity acceleration{"m/s^2", Dimension{0, 1, -2}, "mm/s^2"};
inline constexpr Quantity turning_acceleration{"rad/s^2", Dimension{0, 0, -2, 1}, "deg/s^2"};
inline constexpr Quantity force{"N", Dimension{1, 1, -2}, "kN, lbf"};
inline constexpr Quantity moment{"N m", Dimension{1, 2, -2}, "N mm, kN m"};
inline constexpr Quantity pressure{"Pa", Dimension{1, -1, -2}, "MPa, GPa"};
inline constexpr Quantity density{"kg/m^3", Dimension{1, -3}, "g/cm^3"};
inline constexpr Quantity inertia{"kg m^2", Dimension{1, 2}, "kg mm^2, g cm^2"};
inline constexpr Quantity stiffness{"N/m", Dimension{1, 0, -2}, "kN/m, N/mm"};
inline constexpr Quantity turning_stiffness{"N m/rad", Dimension{1, 2, -2, -1}, "N m/deg, kN m/rad"};
inline constexpr Quantity damping{"N s/m", Dimension{1, 0, -1}, "kN s/m, N s/mm"};
inline constexpr Quantity turning_damping{"N m s/rad", Dimension{1, 2, -1, -1}, "N m s/deg"};
}  // namespace quantity

/// Of a law y(x): its variable, its value, and their quotient.
struct LawUnits {
  Quantity x = quantity::number, y = quantity::number, slope = quantity::number;
};

/// What belongs to a coordinate that is a length, or an angle.
struct CoordinateUnits {
  Quantity position, velocity, acceleration, force, stiffness, damping;
  LawUnits elastic() const { return {position, force, stiffness}; }
  LawUnits damper() const { return {velocity, force, damping}; }
  LawUnits drive() const { return {quantity::time, position, velocity}; }
  LawUnits speed_drive() const { return {quantity::time, velocity, acceleration}; }
};
inline constexpr CoordinateUnits units_of_length{quantity::length,       quantity::speed,
                                                 quantity::acceleration, quantity::force,
                                                 quantity::stiffness,    quantity::damping};
inline constexpr CoordinateUnits units_of_angle{
    quantity::angle,  quantity::turning_speed,     quantity::turning_acceleration,
    quantity::moment, quantity::turning_stiffness, quantity::turning_damping};

/// Whether a number in units of the dimension can stand for the quantity. Radians count where nothing else
/// does: 100 Nm is a stiffness of a hinge as 100 Nm/rad is.
bool fits(const Dimension& dimension, const Quantity& quantity);

/// "kg*m^2/s^2"; the name of the unit where it has one.
std::string to_text(const Dimension& dimension);

/// A unit in a text, in SI: the number before it times `numerator`, then divided by `denominator` (so that
/// 5 mm is the number nearest to 0.005).
struct WrittenUnit {
  double numerator = 1, denominator = 1;
  Dimension dimension;
  std::size_t end = 0;  ///< behind it
};
/// The unit that begins at `at`: names joined by `*`, `/` or a blank, with exponents. Nothing where no
/// unit begins. `taken`: the name of a parameter or variable, which could be meant after an operator;
/// throws ExpressionError then.
std::optional<WrittenUnit> read_unit(const std::string& text, std::size_t at,
                                     const std::function<bool(const std::string&)>& taken);

/// " (did you mean 'mm'?)", or what would be right; `wanted`: what the whole number is, where that is known.
std::string unit_hint(const std::string& name, const Quantity& wanted);

}  // namespace mimbre::model_file
