#pragma once
#include <string>
#include <vector>

#include "app/commands/point_options.h"
#include "mimbre/modes.h"

/// mimbre modes --over: modes over a parameter.
namespace mimbre::app {

struct CampbellArguments {
  std::string over;   ///< "NAME=FROM:TO:COUNT"
  std::string speed;  ///< unit of the parameter as a speed: rad/s, rpm, Hz; empty: it is none
  int most = 0;
  ModesSolver solver = ModesSolver::automatic;
};

/// Returns the exit code.
int run_campbell(const std::string& model, const std::vector<std::string>& settings,
                 const CampbellArguments& over, const PointArguments& point, bool json, bool strict);

}  // namespace mimbre::app
