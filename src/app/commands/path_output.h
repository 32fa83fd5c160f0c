#pragma once
#include <optional>
#include <string>
#include <vector>

#include "app/common.h"

/// mimbre static --path: equilibria under growing loads.
namespace mimbre::app {

struct PathArguments {
  bool wanted = false;
  std::optional<double> from, to;
  std::optional<int> points, bifurcations;
  std::string output;  ///< CSV
};

/// The options, beside those of `static`. `loads` are those of --load.
void add_path_options(Parser& parser, PathArguments& arguments);

/// Throws UsageError where options of --path are given without it.
void refuse_path_options(const PathArguments& arguments);

/// Returns the exit code.
int run_path(const LoadedModel& loaded, const PathArguments& arguments, const std::vector<std::string>& loads,
             bool json, bool strict);

}  // namespace mimbre::app
