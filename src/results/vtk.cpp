#include "mimbre/vtk.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>

#include "base/output_folder.h"
#include "base/output_place.h"
#include "mimbre/stress_history.h"
#include "results/vtk_text.h"

namespace mimbre {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using results::guarded;
using results::vtk_array;

void append(std::vector<float>& to, const Eigen::Ref<const Eigen::VectorXd>& values) {
  for (const double value : values) to.push_back(static_cast<float>(value));
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
  std::string data = vtk_array("displacement", 3, displacements);
  if (body.stress.size() > 0) {
    const Eigen::VectorXd stress = body.stress * amplitudes.head(body.stress.cols());
    append(stresses, stress);
    append(largest, envelope);
    for (Index k = 0; k < count; ++k)
      mises.push_back(static_cast<float>(von_mises(stress.segment<6>(6 * k))));
    std::string names;
    for (int c = 0; c < 6; ++c)
      names += fmt::format(" ComponentName{}=\"{}\"", c, stress_components[static_cast<std::size_t>(c)]);
    data += vtk_array("von_mises", 1, mises) + vtk_array("von_mises_max", 1, largest) +
            vtk_array("stress", 6, stresses, names);
  }
  if (!body.labels.empty()) data += vtk_array("node", 1, body.labels);
  return results::vtk_poly_data(points, data, body.lines, body.triangles);
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

}  // namespace

std::string write_vtk(const Results& results, const std::string& folder, const VtkOptions& options) {
  const auto place =
      guarded(folder, [&] { return std::make_unique<OutputFolder>(folder, results::is_vtk_export); });
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
                          results.time[k], b, results::xml_escaped(body.name), name);
    }
    if (options.progress) options.progress(static_cast<double>(f + 1) / static_cast<double>(frames));
  }
  write("run.pvd", results::vtk_collection(list));
  guarded(folder, [&] { place->commit(); });
  return (fs::path(folder) / "run.pvd").string();
}

}  // namespace mimbre
