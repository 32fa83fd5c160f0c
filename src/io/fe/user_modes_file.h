#pragma once
#include <string>

#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// Mode shapes from a table. CSV (comma, semicolon, tab or blanks): node label, direction (1–6, or x y z rx
/// ry rz), then a column per mode, with or without a heading. NumPy's savez (.npz): the arrays `label` and
/// `direction` (1–6) of whole numbers, `shapes` (rows × modes). Throws InputError.
UserModes read_user_modes(const std::string& path, const SolidMesh& mesh, const FileUnits& units = {});

}  // namespace mimbre::fe
