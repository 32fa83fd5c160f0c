#pragma once
#include <optional>

#include "portable/library/model_source.h"

namespace mimbre::portable {

/// The source of a model that was read from a file or a text with these settings. Nothing where reading it
/// again does not give the same model, which was made in another way or with other settings, or where a file
/// has changed since.
std::optional<ModelSource> source_of(const spec::Model& model,
                                     const std::map<std::string, std::string>& settings);

}  // namespace mimbre::portable
