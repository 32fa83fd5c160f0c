#pragma once
#include <string>

namespace mimbre::hdf5 {

/// The attribute `format` of an HDF5 file, such as "mimbre-results-1"; empty where there is none, or no such
/// file.
std::string file_format(const std::string& path);

}  // namespace mimbre::hdf5
