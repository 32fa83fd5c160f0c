#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

/// Parts of VTK's XML files.
namespace mimbre::results {

/// A data array, binary. `component_names`: attributes.
std::string vtk_array(const char* name, int components, const std::vector<float>& values,
                      const std::string& component_names = {});
std::string vtk_array(const char* name, int components, const std::vector<std::int32_t>& values);
std::string vtk_array(const char* name, int components, const std::vector<std::int64_t>& values);

/// A PolyData file. `points`: x y z of each; `data`: arrays at the points; the other two are cells.
std::string vtk_poly_data(const std::vector<float>& points, const std::string& data,
                          const std::vector<std::array<int, 2>>& lines,
                          const std::vector<std::array<int, 3>>& triangles);

/// A file that lists files: `list` has its DataSet elements.
std::string vtk_collection(const std::string& list);

std::string xml_escaped(const std::string& text);

/// Does what writes `path`, and reports what went wrong with it.
template <class Work>
auto guarded(const std::filesystem::path& path, Work&& work) {
  try {
    return work();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("cannot write '" + path.string() + "': " + error.what());
  }
}

/// What an export makes, and a later one replaces: the series and the files that they list.
bool is_vtk_export(const std::string& name);

}  // namespace mimbre::results
