#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "mimbre/beam_reduction.h"

/// What beams by absolute nodal coordinates of every kind have in common.
namespace mimbre::fe {

/// The line's nodes by distance from the clamped one, and its elements likewise, first node first.
struct AncfLine {
  std::vector<int> nodes;
  std::vector<int> elements;
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();
};

[[noreturn]] void refuse_ancf(const std::string& what);
/// Throws as ancf_beam() does.
AncfLine ancf_line(const Mesh& mesh, const AncfOptions& options);

/// After the mass points and the stiffness: the other matrices, and what is drawn.
void complete_ancf_body(const Mesh& mesh, const AncfLine& line, const AncfOptions& options,
                        ReducedBody& body);

/// `turns`: X_theta of the nodes' frames, as node_shapes.
void add_ancf_frames(const Mesh& mesh, const std::vector<NodeFrame>& frames, const Eigen::MatrixXd& turns,
                     ReducedBody& body);

/// ancf_beam() of the kinds cable and thick.
ReducedBody spatial_ancf_beam(const Mesh& mesh, const AncfOptions& options,
                              const std::vector<NodeFrame>& frames);

}  // namespace mimbre::fe
