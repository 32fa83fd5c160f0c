#pragma once
#include <cstddef>
#include <vector>

#include "compile/compiled.h"

/// Where forces between bodies that are not neighbours enter the state vectors of the joints on their way,
/// and where they leave them.
namespace mimbre::relative {

/// Rows of a force element, a cut joint or a constraint: what it measures by the coordinates of bodies.
struct CoupledRows {
  const Path* path = nullptr;
  int count = 0;
  int jacobian = 0;                   ///< where they begin in the workspace's
  int element = -1, equation = -1;    ///< one of the two
  std::size_t scaled = 0, signs = 0;  ///< where the scaled rows and their signs begin
  int node = 0;                       ///< at which their forces are eliminated: of a single body it itself
  int unknown = -1;  ///< the first of its unknowns that is such a force; −1: rows of a single body need none
};

/// A body's part of coupled rows, and where the forces of the rows are found.
struct RowsOfBody {
  int rows = 0, entry = 0;  ///< which of TransferPlan::rows, and of their path
  int place = 0;            ///< of the first force, as in TransferNode::passes
};

/// A body or, as the last one, the ground.
struct TransferNode {
  int parent = -1;      ///< a node
  int coordinates = 0;  ///< of the body
  int unknowns = 0;     ///< its coordinates, then the forces that are eliminated here
  int size = 6;         ///< of half a state vector at its joint: a motion, then the forces that pass there
  std::vector<RowsOfBody> moves;
  /// Of each force that passes its joint: place in the parent's half state vector, or −1 − place among the
  /// parent's unknowns.
  std::vector<int> passes;
};

/// What the ground has to do with a force element on one body: its covectors act on the motion there.
struct GroundElement {
  int element = 0, body = 0;
  int subspace = 0;  ///< of the place on the body
};

struct TransferPlan {
  explicit TransferPlan(const Compiled& m);
  std::vector<TransferNode> nodes;  ///< bodies in their order, then the ground
  std::vector<CoupledRows> rows;
  std::vector<GroundElement> grounded;
  std::vector<int> legs;              ///< elements that only measure, for sums
  std::size_t scaled = 0, signs = 0;  ///< sizes
};

}  // namespace mimbre::relative
