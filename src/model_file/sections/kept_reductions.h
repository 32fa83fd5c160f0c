#pragma once
#include <memory>
#include <string>

#include "mimbre/reduced_body.h"
#include "model_file/text/builder.h"

namespace mimbre::model_file {

/// Reduced bodies that this process has made of bars, found again by exactly what they were made of: variants
/// of a model, as in a sweep, mostly have the same ones. The last few hundred are kept, up to some 64 MB; any
/// thread may ask.

/// All that a reduced body depends on, bit by bit.
std::string content_of(const FlexibleDescription& description, const std::string& name);

/// Null: it is not there.
std::shared_ptr<const ReducedBody> find_reduced(const std::string& content);
void keep_reduced(const std::string& content, const std::shared_ptr<const ReducedBody>& body);

}  // namespace mimbre::model_file
