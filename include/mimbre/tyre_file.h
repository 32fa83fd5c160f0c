#pragma once
#include <filesystem>
#include <string>
#include <vector>

/// Tyre property files (.tir) of MF-Tyre, MF-Swift and PAC2002.
namespace mimbre {

/// A Magic Formula tyre, in SI units.
struct TyreProperties {
  /// What its formulas calculate with, in the order of tyre_files/magic_numbers.h.
  std::vector<double> numbers;
  int version = 0;                            ///< 52, 61 or 62: Magic Formula 5.2, 6.1, 6.2
  double unloaded_radius = 0;                 ///< m
  double width = 0;                           ///< m; 0: not given, as below
  double rim_radius = 0;                      ///< m
  double nominal_load = 0;                    ///< N
  double pressure = 0, nominal_pressure = 0;  ///< Pa
  std::string side;                           ///< on which it was measured: left, right, symmetric or nothing
  /// Keys of the file that nothing here depends on, as "[SECTION] KEY".
  std::vector<std::string> unused;
  /// Of these the ones that another program's forces may depend on: coefficients without a value, and unknown
  /// ones that leave no term out. For a warning.
  std::vector<std::string> doubtful;
};

/// Throws InputError, with every error that was found, where the file is no such file, misses a number that
/// no tyre can do without, or holds one that cannot be.
///
/// Lengths, forces, masses and times are converted to SI by the file's section [UNITS]; pressures are Pa
/// unless it names another PRESSURE; angles must be radians, as the formula's coefficients depend on them.
/// What a file leaves out takes the value that leaves its term out of the formulas.
TyreProperties read_tyre_properties(const std::filesystem::path& path);

}  // namespace mimbre
