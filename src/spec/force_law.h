#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "spec/number_key.h"

/// The description of a law of force elements: everything but its equations. Each law is one file of
/// src/forces, which owns both; forces/table.h lists them.
namespace mimbre {

struct Compiled;
struct ElementData;
namespace spec {
struct Element;
}

/// The list of the model that describes the elements of a law (ElementData::spec counts in it).
enum class SpecList { elements, springs, tyres, loads, contacts, sensors };

/// How a rolling tyre measures the road, besides its radius.
struct RollingSize {
  double share;      ///< of its deflection, by which it rolls as if it were smaller
  double footprint;  ///< half its length, m
};

struct LawInfo {
  using Numbers = std::span<const double>;
  using Faults = std::vector<std::string>;

  std::string_view name;          ///< in spec::Element::law
  std::string_view section = {};  ///< of the model file; empty: none of its own
  SpecList list = SpecList::elements;

  // Where it may act: along the line between two frames, on a joint's coordinate, along or about a direction,
  // in all six components between two frames, on a sum of joints' coordinates, along a line over several
  // frames, against the velocity of a frame.
  bool along = false, coordinate = false, axis = false, relative = false, coordinates = false, path = false,
       velocity = false;

  std::span<const LawNumber> numbers = {};
  int arguments = 0;          ///< signals that it takes,
  bool optional = false;      ///< all of them or none
  int functions = 0;          ///< that it has at most
  bool of_functions = false;  ///< its force is f₀(x) + f₁(ẋ), and a formula of both
  int states = 0;             ///< that it remembers from step to step, all 0 at first
  bool given = false;         ///< its force does not depend on the measure
  bool sticks = false;        ///< it heeds LawContext::holds

  /// The fault of numbers that are allowed one by one; empty: none.
  std::string_view (*fault)(Numbers) = nullptr;
  /// Faults of an element of this law that nothing else finds.
  void (*check)(const spec::Element&, Faults&) = nullptr;
  /// Appends the numbers that follow from those given, and places for those that set_scales() finds.
  /// `reference`: the measure in the assembled position.
  void (*derived)(Numbers given, double reference, std::vector<double>& behind) = nullptr;
  /// Inertia against the measure, kg or kg m².
  double (*inertia)(Numbers) = nullptr;
  /// Sets the law's numbers that depend on the mechanism's scales (compile/slow_speeds.h).
  void (*set_scales)(const Compiled&, const ElementData&, double* numbers) = nullptr;

  // Tyres.
  std::string_view model = {};                     ///< in the model file
  bool by_file = false;                            ///< its numbers come from a property file,
  void (*check_file)(Numbers, Faults&) = nullptr;  ///< and these are their faults
  /// At which one that rolls hardly does so, m/s, of all its compiled numbers.
  double (*slow_speed)(const double* numbers) = nullptr;
  RollingSize (*rolling_size)(Numbers) = nullptr;  ///< of those that roll
  // Contacts.
  bool (*resists_turning)(Numbers) = nullptr;
  int turning_states = 0;  ///< in place of `states`, where it does

  // How it is drawn between two points, and at a joint.
  std::string_view drawn_along = "actuator", drawn_at_joint = "motor";
};

/// All of them, in the order of ElementData::law.
std::span<const LawInfo* const> all_laws();
const LawInfo& law_info(int law);
/// -1: there is none of that name.
int find_law(std::string_view name);

/// What an element between two frames remembers of their turning (forces/measure_turning.h), before the
/// states of its law.
constexpr int turning_states = 8;

}  // namespace mimbre
