#include "model_file/text/units.h"

#include <array>

#include "portable/fmu/parts.h"

namespace mimbre::portable {
namespace {

std::optional<model_file::WrittenUnit> read_whole(const std::string& unit) {
  try {
    const auto read = model_file::read_unit(unit, 0, [](const std::string&) { return false; });
    if (read && read->end == unit.size()) return read;
  } catch (const std::exception&) {  // no unit that the project knows
  }
  return {};
}

}  // namespace

SiUnit si_unit(const std::string& unit) {
  SiUnit out;
  if (unit == "1" || unit == "-" || unit == "%") {
    out.known = true;
    out.factor = unit == "%" ? 0.01 : 1;
    return out;
  }
  const auto read = read_whole(unit);
  if (!read) return out;
  const model_file::Dimension& d = read->dimension;
  out.known = true;
  out.kg = d.kilogram;
  out.m = d.metre;
  out.s = d.second;
  out.rad = d.radian;
  out.A = d.ampere;
  out.factor = read->numerator / read->denominator;
  namespace q = model_file::quantity;
  for (const model_file::Quantity& quantity :
       std::array{q::mass, q::length, q::time, q::angle, q::speed, q::turning_speed, q::acceleration,
                  q::turning_acceleration, q::force, q::moment, q::pressure, q::stiffness,
                  q::turning_stiffness, q::damping, q::turning_damping}) {
    if (quantity.unit != unit) continue;
    const std::string others(quantity.others);
    for (std::size_t at = 0; at < others.size();) {
      const std::size_t end = std::min(others.find(", ", at), others.size());
      const std::string name = others.substr(at, end - at);
      if (const auto other = read_whole(name))
        out.others.emplace_back(name, other->denominator / other->numerator);
      at = end + 2;
    }
  }
  return out;
}

}  // namespace mimbre::portable
