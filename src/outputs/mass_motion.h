#pragma once
#include <algorithm>

#include "mimbre/channels.h"
#include "mimbre/reduced_body.h"
#include "outputs/view.h"
#include "spec/check/checked_item.h"
#include "spec/output_kind.h"

/// Centre of mass and momenta of bodies, in global axes; of no body named of all.
namespace mimbre::outputs {

/// 'a', 'b' of the bodies, for people.
inline std::string body_names(const Compiled& m, const spec::Output& o) {
  if (o.bodies.empty()) return "all bodies";
  std::string text;
  for (const int b : o.bodies)
    text +=
        fmt::format("{}'{}'", text.empty() ? "" : ", ", m.spec().bodies[static_cast<std::size_t>(b)].name);
  return text;
}

inline void check_mass(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
  if (o.about) item.finite("about", *o.about);
  double mass = 0;
  const auto add = [&](const spec::Body& body) { mass += body.flexible ? body.flexible->mass : body.mass; };
  for (std::size_t k = 0; k < o.bodies.size(); ++k) {
    const int body = o.bodies[k];
    if (!item.index("one of bodies", body, model.bodies.size(), "bodies")) return;
    const auto before = o.bodies.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::find(o.bodies.begin(), before, body) != before)
      return item.error(
          fmt::format("body '{}' is named twice", model.bodies[static_cast<std::size_t>(body)].name));
    add(model.bodies[static_cast<std::size_t>(body)]);
  }
  if (o.bodies.empty()) std::for_each(model.bodies.begin(), model.bodies.end(), add);
  if (mass == 0) item.error("has no mass, and so neither a centre of mass nor momentum");
}

struct CentreOfMass {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m",
            fmt::format("global {} of the centre of mass of {}", axis_words[o.component], body_names(m, o))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return Vec3d(view.mass_motion().centre + view.origin())[o.component];
  }
  static constexpr OutputInfo info{.name = "centre_of_mass",
                                   .of = OutputInfo::Of::bodies,
                                   .words = axis_words,
                                   .check = check_mass,
                                   .describe = describe,
                                   .value = value};
};

struct LinearMomentum {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "kg m/s",
            fmt::format("global {} momentum of {}", axis_words[o.component], body_names(m, o))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.mass_motion().linear[o.component];
  }
  static constexpr OutputInfo info{.name = "linear_momentum",
                                   .of = OutputInfo::Of::bodies,
                                   .words = axis_words,
                                   .check = check_mass,
                                   .describe = describe,
                                   .value = value};
};

/// About their centre of mass, or about a fixed point.
struct AngularMomentum {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {
        o.name, "kg m²/s",
        fmt::format("global {} angular momentum of {} about {}", axis_words[o.component], body_names(m, o),
                    o.about ? fmt::format("[{:g}, {:g}, {:g}]", (*o.about)[0], (*o.about)[1], (*o.about)[2])
                            : std::string("their centre of mass"))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const MassMotion of = view.mass_motion();
    if (!o.about) return of.angular[o.component];
    const Vec3d centre = of.centre + view.origin(), arm = centre - *o.about;
    return (of.angular + arm.cross(of.linear))[o.component];
  }
  static constexpr OutputInfo info{.name = "angular_momentum",
                                   .of = OutputInfo::Of::bodies,
                                   .words = axis_words,
                                   .about = true,
                                   .check = check_mass,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
