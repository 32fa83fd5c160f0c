#pragma once
#include <array>

/// What the choices of spec::Simulation are called in model files and on the command line, in the order of
/// its enumerations.
namespace mimbre::method_names {

inline constexpr std::array formulations{"relative", "natural"};
inline constexpr std::array inertias{"integrals", "projection", "projection_translations"};
inline constexpr std::array formalisms{"index3",  "index1",           "baumgarte",
                                       "penalty", "index1_augmented", "independent"};
inline constexpr std::array integrators{"generalized_alpha", "newmark", "hht"};

}  // namespace mimbre::method_names
