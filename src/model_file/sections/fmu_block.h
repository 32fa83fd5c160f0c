#pragma once
#include "model_file/text/builder.h"

/// Blocks that FMUs compute: {fmu: controller.fmu, inputs: {y: angle}, outputs: [u]}.
namespace mimbre::model_file {

/// Names of the signals of such a block, behind that of the block; none where it has one that has its name.
std::vector<std::string> fmu_output_names(const Tree& description);

/// Reads the FMU and what is chosen for it into the block, its inputs but for their formulas: these come
/// back, in the order of the block's inputs.
std::vector<Value> read_fmu(Builder& builder, const Fields& fields, spec::Block& block);

/// Keys beside those of all blocks.
std::vector<std::string> fmu_keys();

/// Blocks of FMUs without an interval are called at every step of the model.
void complete_fmu_intervals(spec::Model& model);

}  // namespace mimbre::model_file
