#pragma once
#include "model_file/text/builder.h"

namespace mimbre::model_file {

/// The sections `surfaces` and `contacts`.
/// Of all parts before the contacts of any: these may name a surface of another part.
void read_surfaces(Builder& builder, Part& part);
void read_contacts(Builder& builder, Part& part);

}  // namespace mimbre::model_file
