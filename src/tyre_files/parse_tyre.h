#pragma once
#include "fe_files/text_file.h"
#include "mimbre/tyre_file.h"

namespace mimbre::tyre_files {

/// read_tyre_properties, of a text at hand.
TyreProperties parse_tyre(fe::TextFile& file);

}  // namespace mimbre::tyre_files
