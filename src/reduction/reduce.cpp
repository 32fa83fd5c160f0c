#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "fe/elements/beam_element.h"
#include "mimbre/beam_reduction.h"
#include "reduction/bar_sections.h"
#include "reduction/bases/craig_bampton.h"
#include "reduction/shape_integrals.h"
#include "reduction/stiffening/geometric_stiffness.h"
#include "reduction/stiffening/second_order.h"
#include "reduction/stiffening/stretching.h"

namespace mimbre::fe {
namespace {

BodyFrame body_frame(const NodeFrame& frame, const Mesh& mesh, const Eigen::MatrixXd& shapes) {
  if (frame.node < 0 || frame.node >= mesh.nodes.cols())
    throw std::invalid_argument(fmt::format("frame '{}': node {} does not exist, the mesh has {} nodes",
                                            frame.name, frame.node, mesh.nodes.cols()));
  return {frame.name, mesh.nodes.col(frame.node), frame.rotation, shapes.middleRows<3>(6 * frame.node),
          shapes.middleRows<3>(6 * frame.node + 3)};
}

void add_drawing(const Mesh& mesh, const Eigen::MatrixXd& shapes, ReducedBody& body) {
  body.nodes = mesh.nodes;
  body.node_shapes.resize(3 * mesh.nodes.cols(), shapes.cols());
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node)
    body.node_shapes.middleRows<3>(3 * node) = shapes.middleRows<3>(6 * node);
  double area = 0;
  for (const BeamElement& element : mesh.elements) {
    body.lines.push_back(element.nodes);
    area = std::max(area, element.section.area);
  }
  body.line_radius = std::sqrt(area / std::numbers::pi);
}

/// The mass of each element's centre line between its two nodes, interpolated linearly, or lumped at them.
Eigen::SparseMatrix<double> nodal_mass(const Mesh& mesh, MassMatrix mass_matrix) {
  const bool lumped = mass_matrix == MassMatrix::lumped;
  std::vector<Eigen::Triplet<double>> entries;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamElement& beam = mesh.elements[e];
    const double mass = beam.material.density * beam.section.area * element_geometry(mesh, e).length;
    for (int i : beam.nodes)
      for (int j : beam.nodes)
        if (!lumped || i == j) entries.emplace_back(i, j, lumped ? mass / 2 : i == j ? mass / 3 : mass / 6);
  }
  Eigen::SparseMatrix<double> matrix(mesh.nodes.cols(), mesh.nodes.cols());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

ReducedBody reduce(const Mesh& mesh, const ReductionOptions& options, const std::vector<NodeFrame>& frames) {
  if (!(std::isfinite(options.stiffness_damping) && options.stiffness_damping >= 0))
    throw std::invalid_argument(
        fmt::format("stiffness damping must not be negative, is {}", options.stiffness_damping));
  if (mesh.elements.empty()) throw std::invalid_argument("the mesh has no elements");
  const Matrices matrices = assemble(mesh, options.mass_matrix);
  const bool geometric = options.stiffening == Stiffening::geometric_stiffness;
  const Basis basis =
      craig_bampton(mesh, matrices, options,
                    geometric ? unit_inertia_forces(mesh, options.mass_matrix) : Eigen::MatrixXd());

  ReducedBody body;
  body.modes = static_cast<int>(basis.shapes.cols());
  body.mode_names = basis.names;
  body.boundary_rotation = options.boundary_rotation;
  const Eigen::MatrixXd mass = basis.shapes.transpose() * (matrices.mass * basis.shapes);
  body.mass_matrix = 0.5 * (mass + mass.transpose());
  body.stiffness = basis.stiffness;
  body.damping = options.stiffness_damping * basis.stiffness;
  add_shape_integrals(mesh, basis.shapes, options.mass_matrix, body);
  for (const NodeFrame& frame : frames) body.frames.push_back(body_frame(frame, mesh, basis.shapes));
  add_drawing(mesh, basis.shapes, body);
  body.mesh_inertia = MeshInertia{6, matrices.mass, basis.shapes, nodal_mass(mesh, options.mass_matrix)};
  if (geometric) body.geometric = geometric_stiffness(mesh, options, basis);
  if (geometric || options.stiffening == Stiffening::linear)
    body.stretching = stretching_of_beams(mesh, matrices, options, frames, basis.shapes, body);
  if (options.sections) body.sections = bar_sections(mesh, matrices, options, frames, basis.shapes);
  body.bar_stress = bar_stress(mesh, basis.shapes);
  make_orthogonal(body);
  add_second_order(mesh, options, body);
  return body;
}

}  // namespace mimbre::fe
