#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/model.h"

/// Bodies that are drawn apart, each where it was made, brought together by their joints.
namespace mimbre {

/// Brings together the bodies of joints that give a point on each of two bodies (spec::Joint::apart): from
/// the coordinates that are given (`initial_position`), near others (`near`), or as they are drawn, the
/// coordinates are found that close all loops, if need be from other positions. The bodies' poses become
/// those of the found position, and `near` of the joints its coordinates. A model without such joints, or
/// whose lengths do not fit, comes back unchanged: the start of a simulation reports the misfit.
/// Throws InputError where the model cannot be compiled.
spec::Model brought_together(spec::Model model);

/// Loops that share coordinates, and the ways in which they close.
struct AssemblyChoice {
  struct Coordinate {
    std::string joint;
    int coordinate = 0;  ///< of the joint's velocity coordinates
    bool angle = false;  ///< rad, within ±π; else m
  };
  std::vector<std::string> loops;         ///< their cut joints
  std::vector<Coordinate> coordinates;    ///< that are found, the others being held
  std::vector<std::vector<double>> ways;  ///< values of these; the first is the one that is taken
};

/// Of a model whose bodies were brought together: every choice between positions that the lengths and the
/// coordinates that stay (those given, and those in which the mechanism moves) leave open, as far as a search
/// from many positions finds them. Empty for other models, and for those of more than 200 coordinates.
std::vector<AssemblyChoice> assembly_choices(const Model& model);

}  // namespace mimbre
