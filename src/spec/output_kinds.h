#pragma once
#include <array>

#include "mimbre/spec.h"

namespace mimbre {

/// What an output can be of: by its name in model files and builders.
struct OutputKind {
  const char* key;
  spec::Output::Kind kind;
  enum class Of { frame, joint, body, bodies, spring, tyre, contact } of;
};

inline constexpr std::array output_kinds{
    OutputKind{"position", spec::Output::Kind::position, OutputKind::Of::frame},
    OutputKind{"velocity", spec::Output::Kind::velocity, OutputKind::Of::frame},
    OutputKind{"acceleration", spec::Output::Kind::acceleration, OutputKind::Of::frame},
    OutputKind{"angular_velocity", spec::Output::Kind::angular_velocity, OutputKind::Of::frame},
    OutputKind{"roll", spec::Output::Kind::roll, OutputKind::Of::frame},
    OutputKind{"pitch", spec::Output::Kind::pitch, OutputKind::Of::frame},
    OutputKind{"yaw", spec::Output::Kind::yaw, OutputKind::Of::frame},
    OutputKind{"deflection", spec::Output::Kind::deflection, OutputKind::Of::frame},
    OutputKind{"displacement", spec::Output::Kind::displacement, OutputKind::Of::frame},
    OutputKind{"joint", spec::Output::Kind::joint_position, OutputKind::Of::joint},
    OutputKind{"joint_velocity", spec::Output::Kind::joint_velocity, OutputKind::Of::joint},
    OutputKind{"joint_acceleration", spec::Output::Kind::joint_acceleration, OutputKind::Of::joint},
    OutputKind{"joint_rotation", spec::Output::Kind::joint_rotation, OutputKind::Of::joint},
    OutputKind{"joint_quaternion", spec::Output::Kind::joint_quaternion, OutputKind::Of::joint},
    OutputKind{"joint_force", spec::Output::Kind::joint_force, OutputKind::Of::joint},
    OutputKind{"modal_amplitude", spec::Output::Kind::modal_amplitude, OutputKind::Of::body},
    OutputKind{"stress", spec::Output::Kind::stress, OutputKind::Of::body},
    OutputKind{"strain", spec::Output::Kind::strain, OutputKind::Of::body},
    OutputKind{"section_force", spec::Output::Kind::section_force, OutputKind::Of::body},
    OutputKind{"centre_of_mass", spec::Output::Kind::centre_of_mass, OutputKind::Of::bodies},
    OutputKind{"linear_momentum", spec::Output::Kind::linear_momentum, OutputKind::Of::bodies},
    OutputKind{"angular_momentum", spec::Output::Kind::angular_momentum, OutputKind::Of::bodies},
    OutputKind{"spring_force", spec::Output::Kind::spring_force, OutputKind::Of::spring},
    OutputKind{"spring_length", spec::Output::Kind::spring_length, OutputKind::Of::spring},
    OutputKind{"tyre_force", spec::Output::Kind::tyre_force, OutputKind::Of::tyre},
    OutputKind{"tyre_moment", spec::Output::Kind::tyre_moment, OutputKind::Of::tyre},
    OutputKind{"tyre_slip", spec::Output::Kind::tyre_slip, OutputKind::Of::tyre},
    OutputKind{"tyre_slip_angle", spec::Output::Kind::tyre_slip_angle, OutputKind::Of::tyre},
    OutputKind{"tyre_camber", spec::Output::Kind::tyre_camber, OutputKind::Of::tyre},
    OutputKind{"tyre_deflection", spec::Output::Kind::tyre_deflection, OutputKind::Of::tyre},
    OutputKind{"contact_force", spec::Output::Kind::contact_force, OutputKind::Of::contact},
    OutputKind{"contact_depth", spec::Output::Kind::contact_depth, OutputKind::Of::contact},
    OutputKind{"contact_count", spec::Output::Kind::contact_count, OutputKind::Of::contact},
};

/// Components of a contact's force, in their order: along the global axes, and sums of magnitudes.
inline constexpr std::array contact_components{"x", "y", "z", "normal", "tangential"};

/// Of what the road does to a tyre, in the axes of its contact. Of the force the first is what is meant where
/// none is named.
inline constexpr std::array tyre_force_components{"vertical", "longitudinal", "lateral"};
inline constexpr std::array tyre_moment_components{"overturning", "rolling", "aligning"};

/// Whether what it is of has components, of which one must be given, but of a tyre's force.
inline bool has_component(const OutputKind& kind) {
  using Kind = spec::Output::Kind;
  using Of = OutputKind::Of;
  if (kind.of == Of::tyre) return kind.kind == Kind::tyre_force || kind.kind == Kind::tyre_moment;
  return kind.of != Of::spring && kind.kind != Kind::contact_depth && kind.kind != Kind::contact_count &&
         kind.kind != Kind::roll && kind.kind != Kind::pitch && kind.kind != Kind::yaw &&
         kind.kind != Kind::deflection;
}

}  // namespace mimbre
