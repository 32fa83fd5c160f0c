#pragma once
#include <Eigen/Core>
#include <string>
#include <tuple>
#include <vector>

#include "mimbre/channels.h"

namespace mimbre {
class Simulation;
}

namespace mimbre::python {

/// By body its name and the ends of its lines, one pair after the other, global, m: 2·lines × 3.
using Picture = std::vector<std::tuple<std::string, Eigen::MatrixXd>>;

/// Of the moment; `header`: the simulation's own.
Picture picture(Simulation& simulation, const ResultsHeader& header);

}  // namespace mimbre::python
