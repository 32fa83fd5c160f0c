#pragma once
#include <string>

namespace mimbre::app {

/// Finds out before a long computation whether a file can be written at `path`. Throws std::runtime_error
/// naming the file and the reason. Creates nothing.
void require_writable(const std::string& path);

/// Throws UsageError when `output` is the file `input` itself, which writing would destroy.
void require_different(const std::string& input, const std::string& output);

/// Throws UsageError when `output` is a reduced body: results must not take the place of one.
void require_no_body(const std::string& output);

}  // namespace mimbre::app
