#pragma once
#include <string>
#include <vector>

#include "app/options.h"
#include "mimbre/linearise.h"

/// The options by which linear analyses take their point.
namespace mimbre::app {

struct PointArguments {
  std::string at = "automatic";
  std::vector<std::string> inputs;
  RunOptions method;
  int delay_order = 4;
};

void add_point_options(Parser& parser, PointArguments& arguments);
/// Throws UsageError for what is no point.
LinearOptions linear_options(const PointArguments& arguments, const spec::Simulation& given);

}  // namespace mimbre::app
