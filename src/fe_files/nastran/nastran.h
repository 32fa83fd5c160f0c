#pragma once
#include <optional>
#include <string>
#include <vector>

#include "fe_files/matrices/symmetric_entries.h"
#include "fe_files/nastran/nastran_lines.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

/// Bulk data of one text, without includes, as a mesh in its own units.
ImportedMesh parse_nastran(TextFile& file);

/// The files that a deck includes, and these again.
std::vector<std::string> nastran_includes(const std::string& path);

struct NastranMatrix {
  SymmetricEntries entries;
  SymmetricEntries::Stored stored = SymmetricEntries::Stored::triangle;
};
/// The matrices of the given names from DMIG cards, in the directions of the nodes' displacements.
std::vector<NastranMatrix> parse_dmig(NastranLines& lines, const std::vector<std::string>& names,
                                      const SolidMesh& mesh);

/// The only one of `names` that begins with `letter`, or `wanted`.
std::string choose_matrix(const std::vector<std::string>& names, const std::string& wanted, char letter,
                          const Mark& mark);

}  // namespace mimbre::fe
