#pragma once
#include "fe_files/text_file.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

/// As read_gmsh of the public header, in the file's units.
ImportedMesh parse_gmsh(TextFile& file);

}  // namespace mimbre::fe
