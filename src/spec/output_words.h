#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "mimbre/spec.h"
#include "spec/output_kind.h"

/// What reading an output needs, from a model file and in the builder alike.
namespace mimbre {

/// What is given must be used, so that a mistake does not look like a success: a fault for each key that is
/// given and that the kind does not take, as "'along' belongs to 'deflection' and 'strain'".
std::vector<std::string> unused_keys(const OutputInfo& kind,
                                     const std::function<bool(const std::string& key)>& given);

/// Component `output.component` of where the item is, as a frame sees it: 0 in the assembled position, in
/// which the frame is at `reference` and the item at `place`, both global.
void see_from(spec::Output& output, const spec::Pose& reference, const Eigen::Vector3d& place);

/// A node of the surface of a flexible body, or why there is none.
struct SurfaceNode {
  int node = -1;
  std::string fault;
};
/// Of this number in its mesh.
SurfaceNode surface_node(const ReducedBody& body, int label);
/// At this place, global, of a body at `pose`.
SurfaceNode surface_node(const ReducedBody& body, const spec::Pose& pose, const Eigen::Vector3d& place);

}  // namespace mimbre
