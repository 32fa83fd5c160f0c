#pragma once
#include <map>
#include <memory>
#include <string>

#include "mimbre/model.h"
#include "mimbre/model_file.h"
#include "support/print.h"

/// Small mechanisms as model files.
namespace mimbre::test {

std::shared_ptr<const Model> model_of(const std::string& text);

/// A model of the examples folder.
std::shared_ptr<const Model> example(const std::string& file,
                                     const std::map<std::string, std::string>& set = {});

/// Crank, coupler and rocker in the plane z–x, axes along y; joints crank, crank_pin, rocker, rocker_pin.
/// Assembled with the crank upright. `more` goes into the joints' braces: {"rocker_pin", ", cut: always"}.
std::string four_bar_text(std::map<std::string, std::string> more = {},
                          const std::string& pin = "revolute, axis: [0, 1, 0]");

/// A four-bar with everything that signals and force elements can be: inputs of both kinds, tunable
/// parameters, continuous and sampled controllers, actuators on joints of the tree, on cut ones, along a line
/// and about an axis, a bushing with branches, a drive that follows an input.
std::shared_ptr<const Model> controlled_four_bar();

/// A four-bar with a cut joint and elements that act on several bodies at once or have inertia: a torsion
/// spring over joints of the tree and the cut one, a cable with a winch, motors on both, drag in a wind.
std::shared_ptr<const Model> geared_four_bar();
/// A swinging plate, shafts and bodies that fly but for constraints of every kind, among them couplings of
/// joints in the tree and cut.
std::shared_ptr<const Model> every_constraint();
/// A die and a ball, thrown, on a tray that a spring holds, against each other, a pole and a bumpy ground:
/// contacts of many kinds that are closed at the start, with friction and resistance to turning.
std::shared_ptr<const Model> die_and_ball();

}  // namespace mimbre::test
