#pragma once
#include <vector>

#include "mimbre/beam_reduction.h"

namespace mimbre::model_file {

/// A line of elements from the clamped node, or from a node where bars branch, to the next such node or to a
/// free end.
struct BarPath {
  std::vector<int> nodes;     ///< of the mesh, in the order of the walk; one more than elements
  std::vector<int> elements;  ///< of the mesh
  int before = -1;            ///< the path at whose end it begins; -1: the clamped node
  bool free_end = false;      ///< nothing else is attached to the last node
  bool closes = false;        ///< the last node was reached before: the path closes a loop
};

/// The frame of bars as paths, in the order in which one walks along the bars from node `start`: where they
/// branch, along the branches in the order of the mesh's elements, each with all that hangs on it before the
/// next. A path comes after the one before it. Elements that are not connected with `start` are in none.
std::vector<BarPath> bar_paths(const fe::Mesh& mesh, int start);

/// `count` pieces shared among the paths: one for each, and each further one for the path whose pieces have
/// the most elements on average. `count` must be at least that of the paths, at most that of their elements.
std::vector<int> share_pieces(const std::vector<BarPath>& paths, int count);

}  // namespace mimbre::model_file
