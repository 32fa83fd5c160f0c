#pragma once
#include "dynamics/relative/workspace.h"

namespace mimbre {

/// Whether a step of h seconds shows what contacts did in it: no sphere went through a solid unseen, and
/// blows took many of such steps. `work`: of the forces at its end; `before`: states of force elements at its
/// start; `whole`: the step that the model is stepped with, over which what is slower than free fall has no
/// blows. Neither allocates nor throws.
bool contact_followed(const Compiled& model, const relative::Workspace<double>& work, const double* before,
                      double h, double whole);

}  // namespace mimbre
