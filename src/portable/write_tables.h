#pragma once
#include <string>
#include <vector>

#include "math/recorded.h"

namespace mimbre::portable {

/// "static const double name[] = {…};", at least one number.
std::string table(const std::string& name, const std::vector<double>& values);
std::string table(const std::string& name, const std::vector<int>& values);

/// The functions that phases call, `name_call_k(…)`, with their tables.
std::string write_callees(const Recording& recording, const std::string& name);

/// '@' becomes the name.
std::string named(const std::string& text, const std::string& name);

}  // namespace mimbre::portable
