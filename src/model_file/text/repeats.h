#pragma once
#include <memory>
#include <string>

#include "model_file/text/value.h"

namespace mimbre::model_file {

/// The tree with what is repeated written out. An entry of a map, or an item of a list, whose value has the
/// key `for` stands once for each value of its indices: `for: {i: {from: 1, to: 9}}`, `for: {side: [left,
/// right]}`, with several indices once for each combination, the last running fastest. In its name and within
/// it `$i` is the index's value; `$(2*i - 1)` is the value of an expression there and everywhere else in a
/// part. Parameters, requirements and templates are left as they are. Where nothing is repeated it is the
/// same tree.
///
/// `instance`: of the part, empty for the model. What is wrong in what is repeated is reported once (Errors).
/// Throws InputError where the tree becomes larger than the limits.
std::shared_ptr<const Tree> written_out(const std::shared_ptr<const Tree>& tree, const Reading& reading,
                                        const std::string& instance);

}  // namespace mimbre::model_file
