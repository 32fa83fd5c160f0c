#include "mimbre/vtk.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>

#include "base/output_folder.h"
#include "base/output_place.h"
#include "mimbre/stress_history.h"
#include "results/base64.h"

namespace mimbre {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;

/// The bytes that VTK's XML wants: their number, then themselves.
template <typename Number>
std::string binary(const std::vector<Number>& values) {
  const std::uint64_t size = values.size() * sizeof(Number);
  std::vector<unsigned char> bytes(sizeof size + size);
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, values.data(), size);
  return results::base64(bytes);
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

void append(std::vector<float>& to, const Eigen::Ref<const Eigen::VectorXd>& values) {
  for (const double value : values) to.push_back(static_cast<float>(value));
}

/// Triangles or lines: their points, and where each ends.
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

std::string poly_data(const BodyDrawing& body, const Eigen::Matrix<double, 7, 1>& pose,
                      const Eigen::Ref<const Eigen::VectorXd>& amplitudes, const Eigen::VectorXd& envelope) {
  const Index count = body.points.cols();
  const Eigen::Matrix3d A = Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).toRotationMatrix();
  std::vector<float> points, displacements, stresses, mises, largest;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * count);
  if (body.point_shapes.cols() > 0) u = body.point_shapes * amplitudes.head(body.point_shapes.cols());
  for (Index k = 0; k < count; ++k) {
    const Eigen::Vector3d moved = A * u.segment<3>(3 * k);
    append(points, pose.head<3>() + A * body.points.col(k) + moved);
    append(displacements, moved);
  }
  std::string data = array("displacement", 3, displacements);
  if (body.stress.size() > 0) {
    const Eigen::VectorXd stress = body.stress * amplitudes.head(body.stress.cols());
    append(stresses, stress);
    append(largest, envelope);
    for (Index k = 0; k < count; ++k)
      mises.push_back(static_cast<float>(von_mises(stress.segment<6>(6 * k))));
    std::string names;
    for (int c = 0; c < 6; ++c)
      names += fmt::format(" ComponentName{}=\"{}\"", c, stress_components[static_cast<std::size_t>(c)]);
    data += array("von_mises", 1, mises) + array("von_mises_max", 1, largest) +
            array("stress", 6, stresses, names);
  }
  if (!body.labels.empty()) data += array("node", 1, body.labels);
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
      count, body.lines.size(), body.triangles.size(), array("points", 3, points), data,
      cells("Lines", body.lines), cells("Polys", body.triangles));
}

/// Names of files: letters, digits, '_', '-' and '.', each once.
std::vector<std::string> file_names(const std::vector<BodyDrawing>& bodies) {
  std::vector<std::string> names;
  std::set<std::string> used;
  for (const BodyDrawing& body : bodies) {
    std::string name = body.name.empty() ? "body" : body.name;
    for (char& c : name)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
    std::string free = name;
    for (int k = 2; !used.insert(free).second; ++k) free = fmt::format("{}_{}", name, k);
    names.push_back(free);
  }
  return names;
}

std::string escaped(const std::string& text) {
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

/// What an export makes, and a later one replaces.
bool is_exported(const std::string& name) { return name == "run.pvd" || name.ends_with(".vtp"); }

/// Reports what went wrong with `path`.
template <class Work>
auto guarded(const fs::path& path, Work&& work) {
  try {
    return work();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path.string(), error.what()));
  }
}

}  // namespace

std::string write_vtk(const Results& results, const std::string& folder, const VtkOptions& options) {
  const auto place = guarded(folder, [&] { return std::make_unique<OutputFolder>(folder, is_exported); });
  const auto write = [&](const std::string& name, const std::string& text) {
    guarded(fs::path(folder) / name, [&] { write_bytes((fs::path(place->path()) / name).string(), text); });
  };
  const auto& bodies = results.header.bodies;
  const std::vector<std::string> names = file_names(bodies);
  std::vector<Index> first_mode;
  std::vector<Eigen::VectorXd> envelopes;
  Index modes = 0;
  for (const BodyDrawing& body : bodies) {
    first_mode.push_back(modes);
    envelopes.push_back(
        body.stress.size() > 0
            ? stress_history(body, results.time, results.modes.middleCols(modes, body.modes), 0, 0).envelope
            : Eigen::VectorXd());
    modes += body.modes;
  }
  const Index instants = results.time.size(), most = std::max(options.most_instants, 2);
  const Index frames = std::min(instants, most);
  std::string list;
  for (Index f = 0; f < frames; ++f) {
    const Index k = frames < instants ? f * (instants - 1) / (frames - 1) : f;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const BodyDrawing& body = bodies[b];
      if (body.points.cols() == 0) continue;
      const std::string name = fmt::format("{}_{:05}.vtp", names[b], f);
      write(name,
            poly_data(body, results.poses[static_cast<std::size_t>(k)].col(static_cast<Index>(b)),
                      results.modes.row(k).segment(first_mode[b], body.modes).transpose(), envelopes[b]));
      list += fmt::format("    <DataSet timestep=\"{}\" part=\"{}\" name=\"{}\" file=\"{}\"/>\n",
                          results.time[k], b, escaped(body.name), name);
    }
    if (options.progress) options.progress(static_cast<double>(f + 1) / static_cast<double>(frames));
  }
  write("run.pvd",
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
        "byte_order=\"LittleEndian\">\n  <Collection>\n" +
            list + "  </Collection>\n</VTKFile>\n");
  guarded(folder, [&] { place->commit(); });
  return (fs::path(folder) / "run.pvd").string();
}

}  // namespace mimbre
