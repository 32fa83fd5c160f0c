#pragma once
#include <memory>
#include <string>

#include "model_file/text/builder.h"

/// Several files that make one model.
namespace mimbre::model_file {

/// The tree of a model or template, and of the templates in it, with the sections of the files under
/// `include` in place, before its own. A file that is included twice is taken once; one that includes itself
/// is refused.
std::shared_ptr<const Tree> with_includes(Builder& builder, const std::shared_ptr<const Tree>& tree);

/// The tree of the file that `value` names, with what it includes in place; its text is kept with the
/// model's, so that results explain themselves. Null, and an error at `value`, where it cannot be read.
std::shared_ptr<const Tree> read_tree(Builder& builder, const Value& value);

}  // namespace mimbre::model_file
