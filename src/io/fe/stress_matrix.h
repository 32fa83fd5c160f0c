#pragma once
#include <string>
#include <vector>

#include "io/fe/text_file.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// Stress by displacements from SciPy's save_npz (CSR, CSC or COO; entries of the same place are summed).
/// Rows: xx yy zz xy yz zx of each node in turn, nodes in the order of the mesh or, with `nodes_path`, of a
/// table whose first column has their labels. Columns: the dofs `columns` or, where that is empty, those of
/// `matrices`, in this order. `units` are those of the file: stress in mass/(length time²), by displacements
/// in lengths and rotations in rad. Throws InputError.
StressMatrix read_stress_matrix(const std::string& path, const std::string& nodes_path, const SolidMesh& mesh,
                                const FeMatrices& matrices, const std::vector<Dof>& columns,
                                const FileUnits& units = {});

/// The parts of it: the table, and the matrix from the bytes of the file.
std::vector<int> parse_stress_nodes(TextFile& file, const SolidMesh& mesh);
StressMatrix parse_stress_matrix(std::string bytes, const std::string& name, std::vector<int> nodes,
                                 const SolidMesh& mesh, const FeMatrices& matrices,
                                 const std::vector<Dof>& columns, const FileUnits& units);

}  // namespace mimbre::fe
