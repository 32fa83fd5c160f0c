#pragma once
#include <map>
#include <string>
#include <vector>

#include "mimbre/tyre_file.h"

/// The tyres of tests/data/tyres, and forces that others calculate of them.
namespace mimbre::test {

std::string tyre_path(const std::string& name);
TyreProperties tyre_of(const std::string& name);

/// Rows of a file of comma-separated values, by the names of its columns. Lines behind # are comments.
std::vector<std::map<std::string, double>> table_of(const std::string& name);

}  // namespace mimbre::test
