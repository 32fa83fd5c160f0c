#pragma once
#include "model_file/text/builder.h"

namespace mimbre::model_file {

/// The heights of a road over a grid: given as they are, of an OpenCRG `file`, or random by `iso8608`.
void read_road_heights(Builder& builder, const Fields& fields, spec::Road& road);

}  // namespace mimbre::model_file
