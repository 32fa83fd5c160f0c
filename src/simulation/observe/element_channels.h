#pragma once
#include <vector>

#include "compile/compiled.h"
#include "forces/element.h"
#include "mimbre/channels.h"

/// The standard channels of force elements: what they are, and their values after the forces, in the same
/// order from `to` on.
namespace mimbre {

void add_spring_info(const Compiled& model, int element, std::vector<ChannelInfo>& info);
void read_spring(const ElementState<const double>& state, double* to);

/// Of every tyre its vertical force and the road under it; of one that rolls the rest.
void add_tyre_info(const Compiled& model, int element, std::vector<ChannelInfo>& info);
void add_wheel_info(const Compiled& model, int element, std::vector<ChannelInfo>& info);
void add_road_info(const Compiled& model, int element, std::vector<ChannelInfo>& info);

/// Force and moment, where it exerts any.
void add_load_info(const Compiled& model, int element, std::vector<ChannelInfo>& info);
void read_load(const ElementData& load, const ElementState<const double>& state, double* to);

/// Force and measure of each component of one of the other elements.
void add_element_info(const Compiled& model, int element, std::vector<ChannelInfo>& info);
void read_element(const ElementState<const double>& state, double* to);

}  // namespace mimbre
