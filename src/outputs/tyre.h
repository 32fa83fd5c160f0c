#pragma once
#include <array>

#include "forces/measure_wheel.h"
#include "mimbre/channels.h"
#include "outputs/view.h"
#include "outputs/wheel_quantities.h"
#include "spec/check/checked_item.h"
#include "spec/force_law.h"
#include "spec/output_kind.h"

/// What the road does to a tyre, and how it rolls, in the axes of its contact.
namespace mimbre::outputs {

inline ElementState<const double> tyre_state(const OutputView& view, const spec::Output& o) {
  return view.element(view.model.first_tyre + o.item);
}

/// One of the quantities of a tyre that rolls.
inline double wheel_value(const OutputView& view, const spec::Output& o, int quantity) {
  std::array<double, wheel_quantities.size()> values;
  read_wheel(view.model, view.model.elements[view.model.first_tyre + o.item], tyre_state(view, o),
             values.data());
  return values[static_cast<std::size_t>(quantity)];
}

inline ChannelInfo describe_wheel(const Compiled& m, const spec::Output& o, int quantity) {
  const WheelQuantity& q = wheel_quantities[static_cast<std::size_t>(quantity)];
  return {o.name, q.unit,
          fmt::format(fmt::runtime(q.meaning), m.spec().tyres[static_cast<std::size_t>(o.item)].name)};
}

/// Models of tyres that roll: "brush, magic_formula".
inline std::string rolling_models() {
  std::string models;
  for (const LawInfo* law : all_laws())
    if (law->rolling_size) models += fmt::format("{}{}", models.empty() ? "" : ", ", law->model);
  return models;
}

inline void check_rolls(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
  const spec::Tyre& tyre = model.tyres[static_cast<std::size_t>(o.item)];
  const int law = find_law(tyre.law);
  if (law >= 0 && !law_info(law).rolling_size)
    item.error(
        fmt::format("tyre '{}' only carries and has no more than a vertical force; give it another model: {}",
                    tyre.name, rolling_models()));
}

/// Component 0 vertical, which every tyre has; of one that rolls 1 longitudinal, 2 lateral.
struct TyreForce {
  static constexpr const char* words[] = {"vertical", "longitudinal", "lateral"};
  static void check(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
    if (o.component != 0) check_rolls(model, item, o);
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    if (o.component > 0) return describe_wheel(m, o, o.component - 1);
    return {
        o.name, "N",
        fmt::format("vertical force of tyre '{}'", m.spec().tyres[static_cast<std::size_t>(o.item)].name)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return o.component > 0 ? wheel_value(view, o, o.component - 1) : -tyre_state(view, o).force[wheel::gap];
  }
  static constexpr OutputInfo info{.name = "tyre_force",
                                   .of = OutputInfo::Of::tyre,
                                   .words = words,
                                   .otherwise = 0,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check,
                                   .describe = describe,
                                   .value = value};
};

struct TyreMoment {
  static constexpr const char* words[] = {"overturning", "rolling", "aligning"};
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return describe_wheel(m, o, first_wheel_moment + o.component);
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return wheel_value(view, o, first_wheel_moment + o.component);
  }
  static constexpr OutputInfo info{.name = "tyre_moment",
                                   .of = OutputInfo::Of::tyre,
                                   .words = words,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_rolls,
                                   .describe = describe,
                                   .value = value};
};

/// How it rolls: one of the quantities behind its moments.
template <int quantity>
struct TyreRolling {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return describe_wheel(m, o, first_wheel_slip + quantity);
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return wheel_value(view, o, first_wheel_slip + quantity);
  }
  static constexpr std::array names{"tyre_slip", "tyre_slip_angle", "tyre_camber", "tyre_deflection"};
  static constexpr OutputInfo info{.name = names[quantity],
                                   .of = OutputInfo::Of::tyre,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_rolls,
                                   .describe = describe,
                                   .value = value};
};
using TyreSlip = TyreRolling<0>;
using TyreSlipAngle = TyreRolling<1>;
using TyreCamber = TyreRolling<2>;
using TyreDeflection = TyreRolling<3>;

}  // namespace mimbre::outputs
