#pragma once
#include <string>
#include <vector>

#include "app/options.h"

namespace mimbre::app {

/// The key of a reduction to a body called `name`: a digest of the program, of all options that were given
/// but for those named in `without`, and of the bytes of every file that they name, its includes and the
/// matrices beside it. Empty when a file is a pipe, or the files cannot be followed; reading them will report
/// why.
std::string reduction_key(const Parser& command, const std::string& name,
                          const std::vector<std::string>& without);

}  // namespace mimbre::app
