#pragma once
#include <string>
#include <vector>

#include "mimbre/fe_mesh.h"

namespace mimbre::app {

/// Nodes that a text selects: `group:NAME` or `set:NAME` (a node set of the mesh), `nodes:FILE` (labels, one
/// per line or separated by commas or blanks), `box(x0,y0,z0, x1,y1,z1)` (inside, with a margin of 1e-6 of
/// the model), `cylinder(px,py,pz, ax,ay,az, r)` (on that surface, to 1 % of r). Coordinates in the file's
/// unit of length. `among`: rows of the model, since nodes without dofs cannot carry anything. Throws
/// UsageError that says what is wrong and what there is.
std::vector<int> select_nodes(const std::string& text, const fe::SolidMesh& mesh,
                              const std::vector<fe::Dof>& dofs, double length_unit);

}  // namespace mimbre::app
