#pragma once
#include <map>
#include <string>

#include "compile/compiled.h"
#include "mimbre/method.h"

namespace mimbre {

/// Where the integrator is `automatic`: the method with dopri853 or radau in its place, and why in
/// Method::chosen. Compared is about what each costs for the accuracy: the shorter of the steps that accuracy
/// and stability permit to an explicit method, by its evaluations, against the steps of the implicit one,
/// with its matrices. Contacts are stiff while they are closed, which the start need not show. `inputs`: as
/// of RunOptions.
Method choose_integrator(const Compiled& model, Method method, const std::map<std::string, double>& inputs);

}  // namespace mimbre
