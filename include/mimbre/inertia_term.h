#pragma once
#include <array>
#include <string>
#include <vector>

/// The terms of a flexible body's inertia that a model may neglect, one by one.
namespace mimbre {

/// In the floating frame of a body, with the amplitudes y of its modes X, the undeformed place r̄ of a point,
/// the acceleration a of the frame's origin, and the frame's angular velocity ω and acceleration α (Lugrís
/// 2008, 3.51–3.71). What stays in any case: the rigid body's inertia, Mff ÿ, and S = ∫ X dm, which couples ÿ
/// with a.
enum class InertiaTerm {
  first_moment,                ///< S y in ∫ r dm
  second_moment_linear,        ///< what ∫ r rᵀ dm has of y
  second_moment_quadratic,     ///< and of y yᵀ
  rotation_coupling,           ///< of ÿ with α: ∫ r × X dm
  rotation_coupling_deformed,  ///< its part by y
  centrifugal,                 ///< on the modes: ∫ Xᵀ (ω × (ω × r)) dm
  centrifugal_deformed,        ///< its part by y, which softens
  coriolis_modes,              ///< on the modes: 2 ∫ Xᵀ (ω × X ẏ) dm
  coriolis_body,               ///< on the frame: 2 ω × S ẏ, and 2 ∫ r × (ω × X ẏ) dm
  coriolis_body_deformed,      ///< the part of the second by y
};
constexpr int inertia_term_count = 10;

struct InertiaTermInfo {
  const char* name;   ///< in model files
  const char* about;  ///< for tables
};
/// In the order of InertiaTerm.
constexpr std::array<InertiaTermInfo, inertia_term_count> inertia_terms{{
    {"first_moment", "change of the first moment of mass"},
    {"second_moment_linear", "change of the inertia tensor, linear in the amplitudes"},
    {"second_moment_quadratic", "likewise, quadratic"},
    {"rotation_coupling", "modes and angular acceleration"},
    {"rotation_coupling_deformed", "its change with the deformation"},
    {"centrifugal", "centrifugal forces on the modes"},
    {"centrifugal_deformed", "their change with the deformation"},
    {"coriolis_modes", "Coriolis forces on the modes"},
    {"coriolis_body", "Coriolis forces and moments on the body"},
    {"coriolis_body_deformed", "their change with the deformation"},
}};

/// Any of the terms.
struct InertiaTerms {
  unsigned bits = 0;

  bool operator==(const InertiaTerms&) const = default;
  bool empty() const { return bits == 0; }
  bool has(InertiaTerm term) const { return (bits >> static_cast<int>(term) & 1u) != 0; }
  void add(InertiaTerm term) { bits |= 1u << static_cast<int>(term); }

  /// With a term goes what it has by the deformation.
  InertiaTerms complete() const {
    InertiaTerms all = *this;
    if (has(InertiaTerm::rotation_coupling)) all.add(InertiaTerm::rotation_coupling_deformed);
    if (has(InertiaTerm::centrifugal)) all.add(InertiaTerm::centrifugal_deformed);
    if (has(InertiaTerm::coriolis_body)) all.add(InertiaTerm::coriolis_body_deformed);
    return all;
  }
};

/// Their names in model files.
inline std::vector<std::string> names_of(InertiaTerms terms) {
  std::vector<std::string> names;
  for (int k = 0; k < inertia_term_count; ++k)
    if (terms.has(static_cast<InertiaTerm>(k)))
      names.emplace_back(inertia_terms[static_cast<std::size_t>(k)].name);
  return names;
}

}  // namespace mimbre
