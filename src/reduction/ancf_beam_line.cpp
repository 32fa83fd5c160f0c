#include "reduction/ancf_beam_line.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "fe/elements/beam_element.h"
#include "reduction/shape_integrals.h"

namespace mimbre::fe {
namespace {

constexpr double kStraight = 1e-9;  // of the beam's length

}  // namespace

void refuse_ancf(const std::string& what) {
  throw std::invalid_argument(
      "a beam by absolute nodal coordinates is one straight line of bars, clamped at one end: " + what);
}

AncfLine ancf_line(const Mesh& mesh, const AncfOptions& options) {
  const int start = options.clamped_node;
  if (start < 0 || start >= mesh.nodes.cols()) refuse_ancf(fmt::format("node {} does not exist", start));
  if (mesh.elements.empty()) refuse_ancf("the mesh has no elements");
  std::vector<std::vector<int>> at_node(static_cast<std::size_t>(mesh.nodes.cols()));
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    element_geometry(mesh, e);  // refuses what is unsound
    if (options.kind != AncfKind::thick && mesh.elements[e].theory != BeamTheory::euler_bernoulli)
      refuse_ancf(fmt::format("element {} has shear or rotary inertia, for which it has no coordinates", e));
    if (options.kind == AncfKind::thick && mesh.elements[e].theory != BeamTheory::timoshenko)
      refuse_ancf(
          fmt::format("element {} has no shear, which thick elements need (beam_theory: timoshenko)", e));
    if (!mesh.elements[e].offsets[0].isZero(0) || !mesh.elements[e].offsets[1].isZero(0))
      refuse_ancf(fmt::format("element {} has an offset", e));
    for (const int node : mesh.elements[e].nodes) at_node[static_cast<std::size_t>(node)].push_back(e);
  }
  AncfLine line{{start},
                {},
                element_geometry(mesh, at_node[static_cast<std::size_t>(start)].empty()
                                           ? 0
                                           : at_node[static_cast<std::size_t>(start)].front())
                    .axes.col(0)};
  for (int last = -1; line.elements.size() < mesh.elements.size();) {
    const int here = line.nodes.back();
    std::vector<int> next = at_node[static_cast<std::size_t>(here)];
    std::erase(next, last);
    if (next.size() != 1) refuse_ancf(fmt::format("it branches or ends at node {}", here));
    last = next.front();
    const std::array<int, 2>& ends = mesh.elements[static_cast<std::size_t>(last)].nodes;
    line.elements.push_back(last);
    line.nodes.push_back(ends[0] == here ? ends[1] : ends[0]);
  }
  const Eigen::Vector3d whole = mesh.nodes.col(line.nodes.back()) - mesh.nodes.col(start);
  line.along = whole.normalized();
  if (static_cast<Eigen::Index>(line.nodes.size()) != mesh.nodes.cols())
    refuse_ancf("the mesh has nodes that are on no bar");
  double last = -1;
  for (const int node : line.nodes) {
    const Eigen::Vector3d r = mesh.nodes.col(node) - mesh.nodes.col(start);
    if ((r - r.dot(line.along) * line.along).norm() > kStraight * whole.norm())
      refuse_ancf(fmt::format("node {} is off the line", node));
    if (!(r.dot(line.along) > last)) refuse_ancf(fmt::format("it doubles back at node {}", node));
    last = r.dot(line.along);
  }
  return line;
}

void complete_ancf_body(const Mesh& mesh, const AncfLine& line, const AncfOptions& options,
                        ReducedBody& body) {
  complete_shape_integrals(body);
  body.mass_matrix = body.S_modes[0][0] + body.S_modes[1][1] + body.S_modes[2][2];
  body.damping = options.stiffness_damping * body.stiffness;
  body.user_from_modal.setIdentity(body.modes, body.modes);
  body.nodes = mesh.nodes;
  for (std::size_t k = 0; k + 1 < line.nodes.size(); ++k)
    body.lines.push_back({line.nodes[k], line.nodes[k + 1]});
  double area = 0;
  for (const BeamElement& e : mesh.elements) area = std::max(area, e.section.area);
  body.line_radius = std::sqrt(area / std::numbers::pi);
}

void add_ancf_frames(const Mesh& mesh, const std::vector<NodeFrame>& frames, const Eigen::MatrixXd& turns,
                     ReducedBody& body) {
  for (const NodeFrame& frame : frames) {
    if (frame.node < 0 || frame.node >= mesh.nodes.cols())
      throw std::invalid_argument(fmt::format("frame '{}': node {} does not exist, the mesh has {} nodes",
                                              frame.name, frame.node, mesh.nodes.cols()));
    body.frames.push_back({frame.name, mesh.nodes.col(frame.node), frame.rotation,
                           body.node_shapes.middleRows<3>(3 * frame.node),
                           turns.middleRows<3>(3 * frame.node)});
  }
}

}  // namespace mimbre::fe
