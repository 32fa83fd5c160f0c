#pragma once
#include <string>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// The spanning tree of a mechanism. Bodies are spec indices here; -1 is the ground.
struct Topology {
  struct Branch {
    int body;       ///< the child
    int parent;     ///< spec index, -1 ground
    int joint;      ///< spec index
    bool reversed;  ///< the child carries the joint's frame a
  };
  std::vector<Branch> branches;  ///< parent before child, depth first
  std::vector<int> cut_joints;
};

/// Chooses which joints are cut: `cut: always` ones, then those with the fewest loop closure equations; of
/// equals the ones farther from the ground stay cut so that branches are short, then the later ones in the
/// file. Joints with drives or initial values, and `cut: never` ones, are kept in the tree, those with
/// springs where that goes. Bodies without a way to the ground get a floating joint, appended to `model`.
/// Throws InputError when joints that must stay in the tree form a loop.
Topology find_topology(spec::Model& model);

}  // namespace mimbre
