#pragma once
#include "fe_files/matrices/symmetric_entries.h"
#include "fe_files/text_file.h"

namespace mimbre::fe {

/// JOB.dof: node.direction of each row.
std::vector<Dof> parse_calculix_dofs(TextFile& file, const SolidMesh& mesh);
/// JOB.sti, JOB.mas, JOB.str: lines `row column value`.
SymmetricEntries parse_calculix_matrix(TextFile& file, const std::vector<Dof>& rows);

}  // namespace mimbre::fe
