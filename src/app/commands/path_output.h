#pragma once
#include <string>
#include <vector>

#include "app/common.h"

/// mimbre static --path: equilibria under growing loads.
namespace mimbre::app {

struct PathArguments {
  bool wanted = false;
  double from = 0, to = 1;
  int points = 200, bifurcations = 1;
  std::string output;  ///< CSV
};

/// The options, beside those of `static`. `loads` are those of --load.
void add_path_options(Parser& parser, PathArguments& arguments);

/// Returns the exit code.
int run_path(const LoadedModel& loaded, const PathArguments& arguments, const std::vector<std::string>& loads,
             bool json, bool strict);

}  // namespace mimbre::app
