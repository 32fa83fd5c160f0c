#pragma once
#include <vector>

#include "compile/compiled.h"

/// What the compilers of all force elements share.
namespace mimbre {

/// Gives it its path and states; its index.
int add_element(Compiled& c, ElementData e);

/// On a coordinate of a joint, in the tree or cut.
ElementData on_coordinate(const Compiled& c, int joint, int coordinate);
/// Before its other states: it counts turns.
void count_turns(ElementData& e);

/// Appends to the model's numbers of laws; the place of the first.
int add_numbers(Compiled& c, const std::vector<double>& numbers);
/// The numbers of its law that follow from those given.
void add_derived(Compiled& c, const ElementData& e, const std::vector<double>& given);
int add_functions(Compiled& c, const std::vector<Function>& functions);

}  // namespace mimbre
