#pragma once
#include <memory>

#include "mimbre/fmu.h"
#include "portable/fmu/parts.h"

/// What an FMU has in its folder extra/.
namespace mimbre::portable {

/// Adds a reference result of the first `seconds` (0: none) as an experiment in the format of the Modelica
/// Association (ma-hs-experiments): its inputs, its outputs as the library computes them; the validation
/// reports of the reduced bodies; and the manifest of the layered standard FMI-LS-REF, which lists them.
void add_extra_files(const FmuCode& fmu, const std::shared_ptr<const Model>& model, const RunOptions& options,
                     double seconds, ArchiveFiles& files);

}  // namespace mimbre::portable
