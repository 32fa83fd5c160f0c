#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "base/output_folder.h"
#include "base/output_place.h"
#include "mimbre/linear_report.h"
#include "results/modes_parts.h"
#include "results/solid_surface.h"
#include "results/vtk_text.h"

namespace mimbre {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using results::guarded;

/// With more bodies round solids have fewer corners.
constexpr std::size_t many_bodies = 50;

/// All bodies as one: cells with the numbers of all points.
struct WholeDrawing {
  std::vector<BodyDrawing> bodies;
  std::vector<std::array<int, 2>> lines;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::int32_t> body_of_point;
};

/// A body without any drawing: from its origin to where joints and forces are, or three short lines.
void draw_frames(const ResultsHeader& header, int number, double size, BodyDrawing& body) {
  std::vector<Eigen::Vector3d> ends;
  for (const FrameDrawing& frame : header.frames)
    if (frame.body == number && frame.pose.position.norm() > 1e-9 * size) ends.push_back(frame.pose.position);
  if (ends.empty())
    for (int axis = 0; axis < 3; ++axis)
      ends.emplace_back((size > 0 ? 0.04 * size : 0.04) * Eigen::Vector3d::Unit(axis));
  body.points.setZero(3, 1 + std::ssize(ends));
  for (std::size_t k = 0; k < ends.size(); ++k) {
    body.points.col(static_cast<Index>(k + 1)) = ends[k];
    body.lines.push_back({0, static_cast<int>(k + 1)});
  }
  body.point_shapes.setZero(3 * body.points.cols(), body.modes);
}

WholeDrawing whole_drawing(const MechanismShapes& shapes) {
  WholeDrawing out;
  out.bodies = shapes.header.bodies;
  int first = 0;
  for (std::size_t b = 0; b < out.bodies.size(); ++b) {
    BodyDrawing& body = out.bodies[b];
    results::add_solids(body, out.bodies.size() > many_bodies ? 12 : 32);
    if (body.points.cols() == 0) draw_frames(shapes.header, static_cast<int>(b), shapes.size, body);
    for (const auto& [p, q] : body.lines) out.lines.push_back({first + p, first + q});
    for (const auto& [p, q, r] : body.triangles) out.triangles.push_back({first + p, first + q, first + r});
    const Index count = body.points.cols();
    out.body_of_point.insert(out.body_of_point.end(), static_cast<std::size_t>(count),
                             static_cast<std::int32_t>(b));
    first += static_cast<int>(count);
  }
  return out;
}

Eigen::Matrix3Xd points_at(const WholeDrawing& whole, const ResultsRow& row) {
  Eigen::Matrix3Xd points(3, std::ssize(whole.body_of_point));
  Index first = 0, mode = 0;
  for (std::size_t b = 0; b < whole.bodies.size(); ++b) {
    const BodyDrawing& body = whole.bodies[b];
    const auto pose = row.poses.col(static_cast<Index>(b));
    const Eigen::Matrix3d R = Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).toRotationMatrix();
    Eigen::Matrix3Xd own = body.points;
    if (body.modes > 0 && body.point_shapes.cols() == body.modes)
      own.reshaped() += body.point_shapes * row.modes.segment(mode, body.modes);
    points.middleCols(first, own.cols()) = (R * own).colwise() + pose.head<3>();
    first += own.cols();
    mode += body.modes;
  }
  return points;
}

std::vector<float> floats(const Eigen::Matrix3Xd& values) {
  const auto all = values.reshaped();
  return {all.begin(), all.end()};
}

/// Number, frequency and words, for people who open the file in an editor.
std::string mode_comment(const Mode& mode) {
  std::string text =
      fmt::format("{:.6g} Hz, damping ratio {:.4g}: {}", mode.frequency, mode.damping, mode.text);
  for (std::size_t at = 0; (at = text.find("--", at)) != std::string::npos;) text.replace(at, 2, "- -");
  return "<!-- " + text + " -->\n";
}

}  // namespace

std::string write_modes_vtk(const LinearisedModes& modes, const std::string& folder,
                            const ModesVtkOptions& options) {
  const MechanismShapes& shapes = results::shapes_of(modes);
  const auto place =
      guarded(folder, [&] { return std::make_unique<OutputFolder>(folder, results::is_vtk_export); });
  const auto write = [&](const std::string& name, const std::string& text) {
    guarded(fs::path(folder) / name, [&] { write_bytes((fs::path(place->path()) / name).string(), text); });
  };
  const WholeDrawing whole = whole_drawing(shapes);
  const Eigen::Matrix3Xd rest = points_at(whole, shapes.at);
  const std::string bodies = results::vtk_array("body", 1, whole.body_of_point);
  const int count = static_cast<int>(modes.modes.size()), frames = std::max(options.frames, 2);
  const auto digits = fmt::format("{}", count).size();
  std::string first;
  for (int m = 0; m < count; ++m) {
    const Mode& mode = modes.modes[static_cast<std::size_t>(m)];
    const std::string stem = fmt::format("mode_{:0{}}", m + 1, digits);
    const double factor = drawing_factor(shapes, m, options.share);
    const bool oscillates = mode.kind == Mode::Kind::oscillating;
    const double period = oscillates ? 2 * std::numbers::pi / mode.value.imag() : 1;
    std::string list;
    for (int f = 0; f < frames; ++f) {
      const double part = static_cast<double>(f) / frames;
      const Eigen::Matrix3Xd points =
          points_at(whole, moved_by_mode(shapes, m, factor, 2 * std::numbers::pi * part));
      const std::string name = fmt::format("{}_{:03}.vtp", stem, f);
      write(name, results::vtk_poly_data(
                      floats(points), results::vtk_array("displacement", 3, floats(points - rest)) + bodies,
                      whole.lines, whole.triangles));
      list += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", part * period, name);
      if (options.progress) options.progress((m + (f + 1.) / frames) / count);
    }
    write(stem + ".pvd", results::vtk_collection("    " + mode_comment(mode) + list));
    if (first.empty()) first = (fs::path(folder) / (stem + ".pvd")).string();
  }
  guarded(folder, [&] { place->commit(); });
  return first;
}

}  // namespace mimbre
