#pragma once
#include <vector>

#include "tyre_files/magic_numbers.h"
#include "tyre_files/property_file.h"

/// Units of tyre property files.
namespace mimbre::tyre_files {

/// What one of a file's units is in SI.
struct Units {
  double length = 1, force = 1, time = 1, pressure = 1;

  double of(forces::magic::Unit unit) const;
};

/// Of the properties of the section [UNITS]. Adds to `errors` what it cannot take.
Units read_units(const std::vector<Property>& properties, std::vector<Diagnostic>& errors);

}  // namespace mimbre::tyre_files
