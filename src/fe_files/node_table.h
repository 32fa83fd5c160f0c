#pragma once
#include <string_view>
#include <vector>

#include "fe_files/text_file.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

/// Nodes from CSV: label, x, y, z.
ImportedMesh parse_node_table(TextFile& file);

/// Dofs of the rows of a matrix from CSV: row, node label, direction.
std::vector<Dof> parse_dof_table(TextFile& file, const SolidMesh& mesh);

/// Direction 1–6, or x y z rx ry rz, as 0–5; −1: none of these.
int direction_of(std::string_view field);

}  // namespace mimbre::fe
