#pragma once
#include "dynamics/relative/workspace.h"

namespace mimbre {

/// Slower blows are not followed, m/s: what falls freely reaches as much in half a step of `whole` seconds.
double quiet_speed(const Compiled& model, double whole);

/// Whether a step of h seconds shows what contacts did in it: no sphere went through a solid unseen, and
/// blows took many of such steps. Those of swarms, of which there are some in every step, do not count.
/// `work`: of the forces at its end; `before`: states of force elements at its start; `quiet`: speed of the
/// blows that do not count. Neither allocates nor throws.
bool contact_followed(const Compiled& model, const relative::Workspace<double>& work, const double* before,
                      double h, double quiet);

}  // namespace mimbre
