#pragma once
#include "model_file/builder.h"

namespace mimbre::model_file {

/// The sections `surfaces` and `contacts`.
void read_contacts(Builder& builder, Part& part);

}  // namespace mimbre::model_file
