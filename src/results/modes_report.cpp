#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "math/once/decompositions.h"
#include "mimbre/reduced_body.h"
#include "mimbre/report.h"
#include "results/report_json.h"
#include "results/report_page.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using results::Json;

Json numbers(const auto& values) {
  Json list = Json::array();
  for (const double value : values.reshaped()) list.push_back(value);
  return list;
}

Json array(const MatrixXd& values) {
  std::vector<float> list;
  for (const double value : values.reshaped()) list.push_back(static_cast<float>(value));
  return results::array_of(list);
}

/// Hz, by the Rayleigh quotient: of an eigenmode its frequency, of a mode with the interfaces held too.
double frequency(const ReducedBody& body, const VectorXd& amplitudes) {
  const double mass = amplitudes.dot(body.mass_matrix * amplitudes);
  const double square = amplitudes.dot(body.stiffness * amplitudes) / mass;
  // Rounding makes those of rigid motions a little negative.
  const double scale = body.stiffness.norm() / std::max(body.mass_matrix.norm(), 1e-300);
  if (square < 0 && square > -1e-9 * scale) return 0;
  return std::sqrt(square) / (2 * std::numbers::pi);
}

Json family(const ReducedBody& body, const char* name, const std::vector<std::string>& names,
            const MatrixXd& amplitudes) {
  Json modes = Json::array();
  for (Index k = 0; k < amplitudes.cols(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    modes.push_back({{"name", i < names.size() ? names[i] : "mode " + std::to_string(k + 1)},
                     {"frequency", frequency(body, amplitudes.col(k))}});
  }
  return {{"name", name}, {"modes", modes}, {"amplitudes", array(amplitudes)}};
}

/// The eigenmodes where the amplitudes are theirs, and the modes that the user knows.
Json families(const ReducedBody& body) {
  const MatrixXd own = MatrixXd::Identity(body.modes, body.modes);
  Json list = Json::array();
  const bool orthogonal = body.eigenfrequencies.size() == body.modes;
  const MatrixXd& change = body.user_from_modal;
  const bool square = change.rows() == body.modes && change.cols() == body.modes;
  if (!orthogonal || !square || change.isIdentity()) {
    list.push_back(family(body, "Modes", body.mode_names, own));
    return list;
  }
  std::vector<std::string> names;
  for (int k = 1; k <= body.modes; ++k) names.push_back("eigenmode " + std::to_string(k));
  list.push_back(family(body, "Eigenmodes, body frame held", names, own));
  if (const auto modes = inverse_if_regular(change))
    list.push_back(family(body, "Modes of the reduction", body.mode_names, *modes));
  return list;
}

Json frames_json(const ReducedBody& body) {
  Json frames = Json::array();
  for (const BodyFrame& frame : body.frames)
    frames.push_back({{"name", frame.name},
                      {"position", numbers(frame.position)},
                      {"rotation", numbers(frame.rotation.transpose())},  // row-major
                      {"shapes", array(frame.X)},
                      {"turns", array(frame.X_theta)}});
  return frames;
}

BodyDrawing drawing(const ReducedBody& body) {
  BodyDrawing drawn;
  drawn.name = body.name;
  drawn.points = body.nodes;
  drawn.point_shapes = body.node_shapes;
  drawn.lines = body.lines;
  drawn.triangles = body.triangles;
  drawn.labels = body.node_labels;
  drawn.stress = body.stress;
  drawn.line_radius = body.line_radius;
  drawn.modes = body.modes;
  return drawn;
}

Json data_json(const ReducedBody& body, const BodyDrawing& drawn) {
  Json checks = Json::array();
  for (const Check& check : body.checks)
    checks.push_back({{"name", check.name}, {"passed", check.passed}, {"detail", check.detail}});
  const Eigen::Vector3d centre = body.first_moment / body.mass;
  const Eigen::Matrix3d about_origin =
      body.second_moment.trace() * Eigen::Matrix3d::Identity() - body.second_moment;
  const Eigen::Matrix3d inertia =
      about_origin -
      body.mass * (centre.squaredNorm() * Eigen::Matrix3d::Identity() - centre * centre.transpose());
  return {{"format", "mimbre-modes-1"},
          {"name", body.name},
          {"checks", checks},
          {"mass", body.mass},
          {"centre", numbers(centre)},
          {"inertia", numbers(inertia)},
          {"frames", frames_json(body)},
          {"families", families(body)},
          {"body", results::body_json(drawn, results::drawn_points({drawn}))}};
}

}  // namespace

std::string modes_html(const ReducedBody& body) {
  const BodyDrawing drawn = drawing(body);
  results::check_drawing(drawn);
  return results::page_with(data_json(body, drawn));
}

void write_modes_report(const ReducedBody& body, const std::string& path) {
  results::write_page(modes_html(body), path);
}

}  // namespace mimbre
