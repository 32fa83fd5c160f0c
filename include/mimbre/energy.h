#pragma once
#include <array>

namespace mimbre {

/// The energy balance of a run, J. Works and dissipation add up from the start.
struct EnergyBalance {
  double kinetic = 0;
  double gravitational = 0;  ///< zero where the masses are at the global origin's height
  double elastic = 0;  ///< strain energy of the flexible bodies, with ½ yᵀ K_G y of geometric stiffness
  double springs =
      0;  ///< potential of elastic spring laws, zero at the assembled length, and of joint springs
  double tyres = 0;
  double dissipated = 0;  ///< dampers and modal damping
  double drive_work = 0;  ///< by driven joints on the mechanism
  double load_work = 0;   ///< by loads and by spring forces given as expressions (less what these owe to the
                          ///< rate: a damper's), and what the changing stress of bodies with geometric
                          ///< stiffness puts into ½ yᵀ K_G y
  double road_work = 0;   ///< by the road's height changing under the tyres
  double numerical = 0;   ///< what the numerics fed in: total − start − works + dissipated

  double total() const { return kinetic + gravitational + elastic + springs + tyres; }
};

/// A term of the balance by the name that channels and summaries give it.
struct EnergyTerm {
  const char* name;
  const char* meaning;
  double EnergyBalance::*value;
};

inline constexpr std::array<EnergyTerm, 10> energy_terms{{
    {"kinetic", "kinetic energy", &EnergyBalance::kinetic},
    {"gravitational", "potential energy of gravity", &EnergyBalance::gravitational},
    {"elastic", "strain energy of flexible bodies", &EnergyBalance::elastic},
    {"springs", "potential energy of springs", &EnergyBalance::springs},
    {"tyres", "potential energy of tyres", &EnergyBalance::tyres},
    {"dissipated", "dissipated by dampers so far", &EnergyBalance::dissipated},
    {"drive_work", "work of drives so far", &EnergyBalance::drive_work},
    {"load_work", "work of loads so far", &EnergyBalance::load_work},
    {"road_work", "work of the road so far", &EnergyBalance::road_work},
    {"numerical", "fed in by the numerics so far", &EnergyBalance::numerical},
}};

}  // namespace mimbre
