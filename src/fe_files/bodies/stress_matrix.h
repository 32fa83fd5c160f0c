#pragma once
#include <string>
#include <vector>

#include "fe_files/text_file.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// The parts of read_stress_matrix: the table, and the matrix from the bytes of the file.
std::vector<int> parse_stress_nodes(TextFile& file, const SolidMesh& mesh);
StressMatrix parse_stress_matrix(std::string bytes, const std::string& name, std::vector<int> nodes,
                                 const SolidMesh& mesh, const FeMatrices& matrices,
                                 const std::vector<Dof>& columns, const FileUnits& units);

}  // namespace mimbre::fe
