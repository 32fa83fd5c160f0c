#pragma once
#include <string>

namespace mimbre::hdf5 {

/// Whether `path` is a plain file in HDF5 format, by its signature.
bool is_hdf5(const std::string& path);

/// The attribute `format` of an HDF5 file, such as "mimbre-results-1"; empty where there is none, or no such
/// file, or it is damaged.
std::string file_format(const std::string& path);

}  // namespace mimbre::hdf5
