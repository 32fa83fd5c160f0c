#pragma once
#include <string>

#include "io/fe/text_file.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// Mode shapes from a table. CSV (comma, semicolon, tab or blanks): node label, direction (1–6, or x y z rx
/// ry rz), then a column per mode, with or without a heading. NumPy's savez (.npz): the arrays `label` and
/// `direction` (1–6) of whole numbers, `shapes` (rows × modes). Throws InputError.
UserModes read_user_modes(const std::string& path, const SolidMesh& mesh, const FileUnits& units = {});

/// The same of a table's text and of an archive's bytes, in the file's units; `name` is for messages.
UserModes parse_user_modes(TextFile& file, const SolidMesh& mesh);
UserModes parse_user_modes_npz(std::string bytes, const std::string& name, const SolidMesh& mesh);

}  // namespace mimbre::fe
