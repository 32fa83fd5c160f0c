#pragma once
#include <string>
#include <vector>

#include "forces/element.h"
#include "mimbre/channels.h"

/// What is recorded of a tyre that rolls, besides its vertical force, in the axes of its contact
/// (forces/measure_wheel.h): those of ISO 8855, forces and moments of the road on the wheel.
namespace mimbre {

void add_wheel_info(const std::string& tyre, std::vector<ChannelInfo>& info);
/// After the forces; `to`: one value for each of these.
void read_wheel(const Compiled& model, const ElementData& tyre, const ElementState<const double>& state,
                double* to);

/// One of them, or the vertical force, as an output of that tyre.
ChannelInfo wheel_output_info(const std::string& tyre, const spec::Output& output);
/// After the forces.
double wheel_output(const Compiled& model, const ElementData& tyre, const spec::Output& output,
                    const ElementState<const double>& state);

}  // namespace mimbre
