#pragma once
#include <string>

#include "fe_files/text_file.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// read_user_modes of a table's text and of an archive's bytes, in the file's units; `name` is for messages.
UserModes parse_user_modes(TextFile& file, const SolidMesh& mesh);
UserModes parse_user_modes_npz(std::string bytes, const std::string& name, const SolidMesh& mesh);

}  // namespace mimbre::fe
