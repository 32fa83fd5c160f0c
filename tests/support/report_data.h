#pragma once
#include <string>
#include <vector>

#include "mimbre/results.h"
#include "support/json.h"

/// Results to make pages of, and what a page holds.
namespace mimbre::report_data {

using test::Json;

/// A rigid and a flexible body (two points, one mode), two channels, one road.
Results small_results(int instants = 3);

std::vector<unsigned char> from_base64(const std::string& text);

/// Test machines are little-endian, as the arrays are. Of double, float and std::uint32_t.
template <typename T>
std::vector<T> decoded(const Json& array);

/// What a browser hands to the page's script: all up to the first end of the element.
std::string data_text(const std::string& html);

}  // namespace mimbre::report_data
