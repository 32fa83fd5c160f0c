#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "fe/elements/beam_element.h"
#include "math/gauss.h"
#include "mimbre/beam_reduction.h"
#include "reduction/ancf_beam_line.h"
#include "reduction/shape_integrals.h"

namespace mimbre::fe {
namespace {

/// EI of an element for bending in the plane with this normal.
double bending_stiffness(const Mesh& mesh, int element, const Eigen::Vector3d& normal) {
  const BeamElement& beam = mesh.elements[static_cast<std::size_t>(element)];
  const Eigen::Vector3d n = element_geometry(mesh, element).axes.transpose() * normal;
  const double product = (beam.section.Iy - beam.section.Iz) * n.y() * n.z();
  if (std::abs(product) > 1e-6 * (beam.section.Iy + beam.section.Iz))
    throw std::invalid_argument(
        fmt::format("beam element {} bends out of the plane: a principal axis of its section must be along "
                    "the plane's normal",
                    element));
  return beam.material.young * (beam.section.Iy * n.y() * n.y() + beam.section.Iz * n.z() * n.z());
}

/// Stiffness at y = 0 over the element's eight amplitudes.
Eigen::Matrix<double, 8, 8> tangent(const AncfBeam::Element& e) {
  const double L = e.length;
  Eigen::Matrix4d bending;                  // of unit EI
  bending << 12, 6 * L, -12, 6 * L,         //
      6 * L, 4 * L * L, -6 * L, 2 * L * L,  //
      -12, -6 * L, 12, -6 * L,              //
      6 * L, 2 * L * L, -6 * L, 4 * L * L;
  Eigen::Matrix4d axial = Eigen::Matrix4d::Zero();
  for (const auto& [x, weight] : {std::pair{0.0, 1.0 / 6}, {0.5, 4.0 / 6}, {1.0, 1.0 / 6}}) {  // Lobatto
    const Eigen::Vector4d slope(6 * (x * x - x) / L, 1 - 4 * x + 3 * x * x, 6 * (x - x * x) / L,
                                3 * x * x - 2 * x);
    axial += weight * e.axial * L * slope * slope.transpose();
  }
  Eigen::Matrix<double, 8, 8> k = Eigen::Matrix<double, 8, 8>::Zero();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      k(2 * i, 2 * j) = axial(i, j);
      k(2 * i + 1, 2 * j + 1) = e.bending / (L * L * L) * bending(i, j);
    }
  return k;
}

/// The amplitude of a component (displacement along and across, stretch, slope) at the node in this position.
/// The first node stays and its slope keeps its direction; it may stretch. −1: none.
int amplitude_at(int position, int component) {
  if (position == 0) return component == 2 ? 0 : -1;
  return 4 * position - 3 + component;
}

/// Adds an element's mass, from `start` along directions[0], at the points of Gauss's rule.
void add_mass(const AncfBeam::Element& e, const Eigen::Vector3d& start,
              const std::array<Eigen::Vector3d, 2>& directions, double mass, ReducedBody& body) {
  for (const GaussPoint& point : gauss4) {
    const double x = point.xi;
    const std::array<double, 4> hermite{1 - 3 * x * x + 2 * x * x * x, e.length * (x - 2 * x * x + x * x * x),
                                        3 * x * x - 2 * x * x * x, e.length * (x * x * x - x * x)};
    Eigen::Matrix3Xd X = Eigen::Matrix3Xd::Zero(3, body.modes);
    for (std::size_t c = 0; c < 8; ++c)
      if (e.amplitudes[c] >= 0) X.col(e.amplitudes[c]) = hermite[c / 2] * directions[c % 2];
    add_mass_point(body, point.weight * mass, start + x * e.length * directions[0], X);
  }
}

}  // namespace

ReducedBody ancf_beam(const Mesh& mesh, const AncfOptions& options, const std::vector<NodeFrame>& frames) {
  if (!(std::isfinite(options.stiffness_damping) && options.stiffness_damping >= 0))
    throw std::invalid_argument(
        fmt::format("stiffness damping must not be negative, is {}", options.stiffness_damping));
  if (options.kind != AncfKind::planar) return spatial_ancf_beam(mesh, options, frames);
  const AncfLine line = ancf_line(mesh, options);
  AncfBeam beam;
  beam.along = line.along;
  beam.normal = options.normal.normalized();
  beam.stiffness_damping = options.stiffness_damping;
  if (!(std::abs(beam.normal.dot(beam.along)) < 1e-6)) refuse_ancf("it does not lie in the plane");
  const Eigen::Vector3d across = beam.normal.cross(beam.along);
  const std::array<Eigen::Vector3d, 2> directions{beam.along, across};

  ReducedBody body;
  const int nodes = static_cast<int>(line.nodes.size());
  body.modes = 4 * nodes - 3;
  body.mode_names.assign(1, "stretch at the first node");
  for (int k = 1; k < nodes; ++k)
    for (const char* what : {"displacement along", "displacement across", "stretch", "slope"})
      body.mode_names.push_back(fmt::format("{}, node {}", what, k + 1));

  clear_shape_integrals(body, body.modes);
  body.stiffness.setZero(body.modes, body.modes);
  for (int k = 0; k + 1 < nodes; ++k) {
    const int index = line.elements[static_cast<std::size_t>(k)];
    const BeamElement& element = mesh.elements[static_cast<std::size_t>(index)];
    const Eigen::Vector3d start = mesh.nodes.col(line.nodes[static_cast<std::size_t>(k)]);
    AncfBeam::Element e;
    e.length = element_geometry(mesh, index).length;
    e.axial = element.material.young * element.section.area;
    e.bending = bending_stiffness(mesh, index, beam.normal);
    for (int c = 0; c < 8; ++c) e.amplitudes[static_cast<std::size_t>(c)] = amplitude_at(k + c / 4, c % 4);
    const double mass = element.material.density * element.section.area * e.length;
    add_mass(e, start, directions, mass, body);
    const Eigen::Matrix<double, 8, 8> stiffness = tangent(e);
    for (int r = 0; r < 8; ++r)
      for (int c = 0; c < 8; ++c)
        if (e.amplitudes[static_cast<std::size_t>(r)] >= 0 && e.amplitudes[static_cast<std::size_t>(c)] >= 0)
          body.stiffness(e.amplitudes[static_cast<std::size_t>(r)],
                         e.amplitudes[static_cast<std::size_t>(c)]) += stiffness(r, c);
    const double polar = polar_inertia(element) * e.length;
    body.second_moment += polar * (0.5 * Eigen::Matrix3d::Identity() - beam.along * beam.along.transpose());
    beam.elements.push_back(e);
  }
  complete_ancf_body(mesh, line, options, body);

  body.node_shapes.setZero(3 * mesh.nodes.cols(), body.modes);
  Eigen::MatrixXd slopes = body.node_shapes;
  for (int k = 0; k < nodes; ++k)
    for (int c = 0; c < 4; ++c)
      if (const int at = amplitude_at(k, c); at >= 0 && k > 0)  // stretching turns nothing
        (c < 2 ? body.node_shapes : slopes).block<3, 1>(3 * line.nodes[static_cast<std::size_t>(k)], at) =
            directions[static_cast<std::size_t>(c % 2)];
  add_ancf_frames(mesh, frames, slopes, body);
  body.ancf = std::move(beam);
  return body;
}

}  // namespace mimbre::fe
