#pragma once
#include "model_file/text/builder.h"

namespace mimbre::model_file {

/// Warns of angles that only degrees make sense of: a joint that starts, or is driven from, more than a turn
/// away from its assembled position, or oscillates over more than five turns.
void warn_of_degrees(Builder& builder);

}  // namespace mimbre::model_file
