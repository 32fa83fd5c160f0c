#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fe/elements/beam_element.h"
#include "math/gauss.h"
#include "reduction/ancf_beam_line.h"
#include "reduction/shape_integrals.h"

namespace mimbre::fe {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Spatial = AncfBeam::SpatialElement;

/// How the amplitudes of the nodes are numbered: three for each vector of a node, along the axes of the line.
struct Numbering {
  AncfKind kind = AncfKind::cable;
  int nodes = 0;  ///< with the middles of thick elements

  bool thick() const { return kind == AncfKind::thick; }
  int vectors() const { return thick() ? 3 : 2; }  ///< of a node: r, r', or r, y, z
  /// The first node stays; a cable may stretch there.
  int modes() const { return 3 * vectors() * (nodes - 1) + (thick() ? 0 : 1); }
  int at(int node, int vector, int component) const {
    if (node == 0) return !thick() && vector == 1 && component == 0 ? 0 : -1;
    return 3 * (vectors() * (node - 1) + vector) + component + (thick() ? 0 : 1);
  }
};

/// Columns: along, across and normal of the line, which are the axes of its sections.
Matrix3d line_axes(const Mesh& mesh, const AncfLine& line, bool thick) {
  Matrix3d axes;
  axes.col(0) = line.along;
  axes.col(1) = element_geometry(mesh, line.elements.front()).axes.col(1);
  axes.col(2) = axes.col(0).cross(axes.col(1));
  if (!thick) return axes;
  for (const int k : line.elements) {
    const Section& s = mesh.elements[static_cast<std::size_t>(k)].section;
    const Vector3d y = element_geometry(mesh, k).axes.col(1);
    if (y.cross(axes.col(1)).norm() > 1e-6 && !(s.Iy == s.Iz && s.shear_y == s.shear_z))
      throw std::invalid_argument(
          fmt::format("beam element {}: the axes of its section are not those of the first one, as they have "
                      "to be in thick "
                      "elements by absolute nodal coordinates",
                      k));
  }
  return axes;
}

Spatial element_of(const Mesh& mesh, int index, AncfKind kind) {
  const BeamElement& beam = mesh.elements[static_cast<std::size_t>(index)];
  const double E = beam.material.young, G = E / (2 * (1 + beam.material.poisson));
  Spatial e;
  e.length = element_geometry(mesh, index).length;
  e.axial = E * beam.section.area;
  e.bending_y = E * beam.section.Iy;
  e.bending_z = E * beam.section.Iz;
  if (kind == AncfKind::thick) {
    e.torsion = G * beam.section.J;
    e.shear_y = G * beam.section.shear_y;
    e.shear_z = G * beam.section.shear_z;
    e.section_shear = G * beam.section.area;
  } else if (std::abs(e.bending_y - e.bending_z) > 1e-6 * (e.bending_y + e.bending_z)) {
    throw std::invalid_argument(fmt::format(
        "beam element {}: a cable by absolute nodal coordinates bends alike in all directions, but "
        "the section's Iy and Iz differ; take beam: ancf_thick or corotational",
        index));
  }
  return e;
}

/// What r is made of at a place in the element: of each of its vectors.
std::array<double, 9> shapes_at(double x, double length, bool thick) {
  const double x2 = x * x, x3 = x2 * x;
  if (thick) return {(1 - x) * (1 - 2 * x), 0, 0, 4 * x * (1 - x), 0, 0, x * (2 * x - 1), 0, 0};
  return {1 - 3 * x2 + 2 * x3, length * (x - 2 * x2 + x3), 3 * x2 - 2 * x3, length * (x3 - x2)};
}

/// Adds an element's mass, from `start` on. In a thick one each section is four points with its moments.
void add_mass(const Spatial& e, const BeamElement& beam, const Vector3d& start, const Matrix3d& axes,
              bool thick, ReducedBody& body) {
  const double mass = beam.material.density * beam.section.area * e.length;
  const double high = std::sqrt(beam.section.Iz / beam.section.area),
               wide = std::sqrt(beam.section.Iy / beam.section.area);
  const auto add = [&](double x, double dm, double y, double z) {
    std::array<double, 9> shapes = shapes_at(x, e.length, thick);
    if (thick)
      for (std::size_t k = 0; k < 9; k += 3) {
        shapes[k + 1] = y * shapes[k];
        shapes[k + 2] = z * shapes[k];
      }
    Eigen::Matrix3Xd X = Eigen::Matrix3Xd::Zero(3, body.modes);
    for (std::size_t c = 0; c < (thick ? 27u : 12u); ++c)
      if (e.amplitudes[c] >= 0) X.col(e.amplitudes[c]) += shapes[c / 3] * axes.col(static_cast<int>(c % 3));
    add_mass_point(body, dm, start + axes * Vector3d(x * e.length, y, z), X);
  };
  for (const GaussPoint& point : gauss4) {
    const double dm = point.weight * mass;
    if (!thick) {
      add(point.xi, dm, 0, 0);
      continue;
    }
    for (const double y : {-high, high})
      for (const double z : {-wide, wide}) add(point.xi, 0.25 * dm, y, z);
  }
}

/// Adds k sᵀ s of a strain s by the element's amplitudes.
void add_stiffness(const Spatial& e, double k, const Eigen::Matrix<double, 1, 27>& strain, MatrixXd& out) {
  for (std::size_t r = 0; r < 27; ++r)
    for (std::size_t c = 0; c < 27; ++c)
      if (const double product = k * strain[static_cast<int>(r)] * strain[static_cast<int>(c)];
          product != 0 && e.amplitudes[r] >= 0 && e.amplitudes[c] >= 0)
        out(e.amplitudes[r], e.amplitudes[c]) += product;
}

/// Stiffness at y = 0: of a cable by stretch (three points of Lobatto) and curvature (two of Gauss).
void add_cable_stiffness(const Spatial& e, MatrixXd& out) {
  const double L = e.length, third = std::sqrt(1.0 / 12);
  Eigen::Matrix<double, 1, 27> strain;
  for (const auto& [x, weight] : {std::pair{0.0, 1.0 / 6}, {0.5, 4.0 / 6}, {1.0, 1.0 / 6}}) {
    strain.setZero();
    strain[0] = 6 * (x * x - x) / L;
    strain[3] = 1 - 4 * x + 3 * x * x;
    strain[6] = -strain[0];
    strain[9] = 3 * x * x - 2 * x;
    add_stiffness(e, weight * L * e.axial, strain, out);
  }
  for (const double x : {0.5 - third, 0.5 + third})
    for (int c = 1; c < 3; ++c) {
      strain.setZero();
      strain[c] = (12 * x - 6) / (L * L);
      strain[3 + c] = (6 * x - 4) / L;
      strain[6 + c] = -strain[c];
      strain[9 + c] = (6 * x - 2) / L;
      add_stiffness(e, 0.5 * L * e.bending_y, strain, out);
    }
}

/// Likewise of a thick element: of Timoshenko's beam (two points of Gauss), and of its sections at the nodes.
void add_thick_stiffness(const Spatial& e, MatrixXd& out) {
  using Row = Eigen::Matrix<double, 1, 27>;
  const double L = e.length, third = std::sqrt(1.0 / 12);
  enum { r, y, z };
  for (const double x : {0.5 - third, 0.5 + third}) {
    const std::array<double, 3> N{(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)},
        D{(4 * x - 3) / L, (4 - 8 * x) / L, (4 * x - 1) / L};
    const auto row = [&](const std::array<double, 3>& by, int vector, int component) {
      Row out_row = Row::Zero();
      for (int k = 0; k < 3; ++k) out_row[9 * k + 3 * vector + component] = by[static_cast<std::size_t>(k)];
      return out_row;
    };
    // The section turns by −z₂ about x, z₁ about y and −y₁ about z.
    add_stiffness(e, 0.5 * L * e.axial, row(D, r, 0), out);
    add_stiffness(e, 0.5 * L * e.shear_y, row(D, r, 1) + row(N, y, 0), out);
    add_stiffness(e, 0.5 * L * e.shear_z, row(D, r, 2) + row(N, z, 0), out);
    add_stiffness(e, 0.5 * L * e.torsion, row(D, z, 1), out);
    add_stiffness(e, 0.5 * L * e.bending_y, row(D, z, 0), out);
    add_stiffness(e, 0.5 * L * e.bending_z, row(D, y, 0), out);
  }
  for (int k = 0; k < 3; ++k) {
    const double weight = (k == 1 ? 4 : 1) * L / 6;
    Row stretch_y = Row::Zero(), stretch_z = stretch_y, shear = stretch_y;
    stretch_y[9 * k + 3 * y + 1] = stretch_z[9 * k + 3 * z + 2] = 1;
    shear[9 * k + 3 * y + 2] = shear[9 * k + 3 * z + 1] = 1;
    add_stiffness(e, weight * e.axial, stretch_y, out);
    add_stiffness(e, weight * e.axial, stretch_z, out);
    add_stiffness(e, weight * e.section_shear, shear, out);
  }
}

void name_modes(const Numbering& numbers, ReducedBody& body) {
  const std::array<const char*, 3> axes{"along", "across", "normal"};
  const std::array<const char*, 3> vectors{"displacement", numbers.thick() ? "y" : "slope", "z"};
  body.mode_names.assign(static_cast<std::size_t>(body.modes), "stretch at the first node");
  for (int node = 1; node < numbers.nodes; ++node)
    for (int v = 0; v < numbers.vectors(); ++v)
      for (int c = 0; c < 3; ++c)
        body.mode_names[static_cast<std::size_t>(numbers.at(node, v, c))] =
            fmt::format("{} {}, node {}", vectors[static_cast<std::size_t>(v)],
                        axes[static_cast<std::size_t>(c)], node + 1);
}

/// Displacements of the mesh's nodes, and turns of frames there: of a cable changes of slope.
void add_nodes(const AncfLine& line, const Numbering& numbers, const Matrix3d& axes, ReducedBody& body,
               MatrixXd& turns) {
  body.node_shapes.setZero(3 * body.nodes.cols(), body.modes);
  turns = body.node_shapes;
  for (std::size_t k = 1; k < line.nodes.size(); ++k) {
    const int node = static_cast<int>(numbers.thick() ? 2 * k : k);
    const auto column = [&](MatrixXd& of, int vector, int component) {
      return of.block<3, 1>(3 * line.nodes[k], numbers.at(node, vector, component));
    };
    for (int c = 0; c < 3; ++c) column(body.node_shapes, 0, c) = axes.col(c);
    if (numbers.thick()) {
      column(turns, 2, 1) = -axes.col(0);
      column(turns, 2, 0) = axes.col(1);
      column(turns, 1, 0) = -axes.col(2);
    } else {
      for (int c = 0; c < 3; ++c) column(turns, 1, c) = axes.col(c);
    }
  }
}

/// Of each frame the amplitudes of its section's directions.
std::vector<std::array<int, 6>> sections_of(const AncfLine& line, const Numbering& numbers,
                                            const std::vector<NodeFrame>& frames) {
  std::vector<std::array<int, 6>> out;
  for (const NodeFrame& frame : frames) {
    const auto place = std::find(line.nodes.begin(), line.nodes.end(), frame.node) - line.nodes.begin();
    std::array<int, 6> section{};
    for (int k = 0; k < 6; ++k)
      section[static_cast<std::size_t>(k)] = numbers.at(2 * static_cast<int>(place), 1 + k / 3, k % 3);
    out.push_back(section);
  }
  return out;
}

}  // namespace

ReducedBody spatial_ancf_beam(const Mesh& mesh, const AncfOptions& options,
                              const std::vector<NodeFrame>& frames) {
  const AncfLine line = ancf_line(mesh, options);
  const bool thick = options.kind == AncfKind::thick;
  const int elements = static_cast<int>(line.elements.size()), a_piece = thick ? 2 : 1;
  const Numbering numbers{options.kind, a_piece * elements + 1};
  const Matrix3d axes = line_axes(mesh, line, thick);
  AncfBeam beam;
  beam.kind = options.kind;
  beam.along = axes.col(0);
  beam.normal = axes.col(2);
  beam.stiffness_damping = options.stiffness_damping;

  ReducedBody body;
  body.modes = numbers.modes();
  name_modes(numbers, body);
  clear_shape_integrals(body, body.modes);
  body.stiffness.setZero(body.modes, body.modes);
  for (int k = 0; k < elements; ++k) {
    const int index = line.elements[static_cast<std::size_t>(k)];
    const BeamElement& element = mesh.elements[static_cast<std::size_t>(index)];
    Spatial e = element_of(mesh, index, options.kind);
    e.amplitudes.fill(-1);
    const int width = 3 * numbers.vectors();
    for (int c = 0; c < width * (a_piece + 1); ++c)
      e.amplitudes[static_cast<std::size_t>(c)] = numbers.at(a_piece * k + c / width, c % width / 3, c % 3);
    add_mass(e, element, mesh.nodes.col(line.nodes[static_cast<std::size_t>(k)]), axes, thick, body);
    if (thick) {
      add_thick_stiffness(e, body.stiffness);
    } else {
      add_cable_stiffness(e, body.stiffness);
      const double polar = polar_inertia(element) * e.length;
      body.second_moment += polar * (0.5 * Matrix3d::Identity() - beam.along * beam.along.transpose());
    }
    beam.spatial.push_back(e);
  }
  complete_ancf_body(mesh, line, options, body);
  MatrixXd turns;
  add_nodes(line, numbers, axes, body, turns);
  add_ancf_frames(mesh, frames, turns, body);
  if (thick) beam.sections = sections_of(line, numbers, frames);
  body.ancf = std::move(beam);
  return body;
}

}  // namespace mimbre::fe
