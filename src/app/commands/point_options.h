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
  std::vector<std::string> hold, find;  ///< of steady driving
  std::string body;
};

/// --hold, --find and --body of steady driving.
void add_trim_options(Parser& parser, PointArguments& arguments);
/// Whether one of them is given.
bool drives_steadily(const PointArguments& arguments);
/// Throws UsageError for conditions that are none.
TrimConditions trim_conditions(const PointArguments& arguments);

void add_point_options(Parser& parser, PointArguments& arguments);
/// Throws UsageError for what is no point.
LinearOptions linear_options(const PointArguments& arguments, const spec::Simulation& given);

}  // namespace mimbre::app
