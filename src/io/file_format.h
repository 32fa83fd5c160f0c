#pragma once
#include <string>

namespace mimbre::io {

/// The attribute `format` of an HDF5 file, such as "mimbre-results-1"; empty where there is none, or no such
/// file.
std::string file_format(const std::string& path);
bool is_reduced_body(const std::string& path);

}  // namespace mimbre::io
