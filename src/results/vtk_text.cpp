#include "results/vtk_text.h"

#include <fmt/format.h>

#include <cstring>

#include "results/base64.h"

namespace mimbre::results {
namespace {

/// The bytes that VTK's XML wants: their number, then themselves.
template <typename Number>
std::string binary(const std::vector<Number>& values) {
  const std::uint64_t size = values.size() * sizeof(Number);
  std::vector<unsigned char> bytes(sizeof size + size);
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, values.data(), size);
  return base64(bytes);
}

constexpr const char* type_name(float) { return "Float32"; }
constexpr const char* type_name(std::int32_t) { return "Int32"; }
constexpr const char* type_name(std::int64_t) { return "Int64"; }

template <typename Number>
std::string array(const char* name, int components, const std::vector<Number>& values,
                  const std::string& component_names = {}) {
  return fmt::format(
      "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{} "
      "format=\"binary\">{}</DataArray>\n",
      type_name(Number{}), name, components, component_names, binary(values));
}

template <std::size_t Corners>
std::string cells(const char* tag, const std::vector<std::array<int, Corners>>& all) {
  std::vector<std::int32_t> points, ends;
  for (const auto& cell : all) {
    points.insert(points.end(), cell.begin(), cell.end());
    ends.push_back(static_cast<std::int32_t>(points.size()));
  }
  return fmt::format("      <{0}>\n{1}{2}      </{0}>\n", tag, array("connectivity", 1, points),
                     array("offsets", 1, ends));
}

}  // namespace

std::string vtk_array(const char* name, int components, const std::vector<float>& values,
                      const std::string& component_names) {
  return array(name, components, values, component_names);
}
std::string vtk_array(const char* name, int components, const std::vector<std::int32_t>& values) {
  return array(name, components, values);
}
std::string vtk_array(const char* name, int components, const std::vector<std::int64_t>& values) {
  return array(name, components, values);
}

std::string vtk_poly_data(const std::vector<float>& points, const std::string& data,
                          const std::vector<std::array<int, 2>>& lines,
                          const std::vector<std::array<int, 3>>& triangles) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "  <PolyData>\n"
      "    <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"{}\">\n"
      "      <Points>\n{}      </Points>\n"
      "      <PointData>\n{}      </PointData>\n"
      "{}{}"
      "    </Piece>\n"
      "  </PolyData>\n"
      "</VTKFile>\n",
      points.size() / 3, lines.size(), triangles.size(), array("points", 3, points), data,
      cells("Lines", lines), cells("Polys", triangles));
}

std::string vtk_collection(const std::string& list) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
         "byte_order=\"LittleEndian\">\n  <Collection>\n" +
         list + "  </Collection>\n</VTKFile>\n";
}

std::string xml_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

bool is_vtk_export(const std::string& name) {
  if (name == "run.pvd" || name.ends_with(".vtp")) return true;
  if (!name.starts_with("mode_") || !name.ends_with(".pvd")) return false;
  return name.substr(5, name.size() - 9).find_first_not_of("0123456789") == std::string::npos;
}

}  // namespace mimbre::results
