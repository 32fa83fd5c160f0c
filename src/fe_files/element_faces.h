#pragma once
#include <vector>

#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// Places in the element of the nodes of face S`face` (from 1, numbered as in Abaqus and CalculiX), corners
/// first; empty when the element has no such face. Of a shell both faces, S1 and S2 (SNEG, SPOS), are itself.
std::vector<int> face_nodes(ElementType type, int face);

}  // namespace mimbre::fe
