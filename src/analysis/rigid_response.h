#pragma once
#include "mimbre/mode_selection.h"

namespace mimbre {

/// How the body number `body` of the model would deflect under what acts on it while it moves as if it were
/// rigid: a run without its modes gives the forces at its frames (joints, springs, tyres, loads) and the
/// motion of its frame; each mode, by itself, answers to its part of these and of inertia and gravity,
/// ÿ + c ẏ + ω² y = f(t), exactly for f linear between the instants. From rest and straight, or from the
/// static deflection where the model starts at equilibrium. Where joints hold the rigid body twice their
/// forces are one choice of many. Modes must be orthogonal. Throws as amplitudes_with does.
AmplitudeHistory rigid_response(const spec::Model& model, int body, const ModeSelectionOptions& options);

}  // namespace mimbre
