#pragma once
#include <string>
#include <utility>
#include <vector>

#include "mimbre/fmu.h"

/// Parts of an FMU.
namespace mimbre::portable {

/// Names in the archive, and contents.
using ArchiveFiles = std::vector<std::pair<std::string, std::string>>;

/// Writes a ZIP archive, deflated, to a file that exists, the same bytes for the same files. Throws
/// std::runtime_error with the reason alone.
void write_archive(const std::string& path, const ArchiveFiles& files);

/// The functions of the standard around the code.
std::string fmu_wrapper(const FmuCode& fmu);
/// The name of its file.
std::string fmu_wrapper_file(const FmuCode& fmu);

/// buildDescription.xml of FMI 3.
std::string fmu_build_description(const FmuCode& fmu);
/// A page about the model, its variables and its steps.
std::string fmu_page(const FmuCode& fmu, const Model& model, const std::string& method);
/// The shared library of these sources, for the machine that this runs on.
struct FmuBinary {
  std::string file;     ///< in the archive
  std::string bytes;    ///< empty: there is none
  std::string message;  ///< why
  ArchiveFiles with{};  ///< what it loads from the same folder
};
FmuBinary compile_fmu(const FmuCode& fmu);

/// A unit as base units of SI.
struct SiUnit {
  bool known = false;
  int kg = 0, m = 0, s = 0, rad = 0, A = 0;
  double factor = 1;  ///< of one such unit, in SI
  std::vector<std::pair<std::string, double>>
      others;  ///< others that people use, and how many of these one is
};
SiUnit si_unit(const std::string& unit);

}  // namespace mimbre::portable
