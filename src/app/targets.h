#pragma once
#include <functional>
#include <string>

namespace mimbre::app {

/// Finds out before a long computation whether a file can be written at `path`. Throws std::runtime_error
/// naming the file and the reason. Creates nothing.
void require_writable(const std::string& path);

/// The same for a reduced body, which needs a plain file.
void require_writable_body(const std::string& path);

/// Runs what writes a sound body; that its file cannot be written is no mistake in the input: throws Failure.
void write_body_file(const std::function<void()>& write);

/// Throws UsageError when `output` is the file `input` itself, which writing would destroy.
void require_different(const std::string& input, const std::string& output);

/// Throws UsageError when `output` is a reduced body: results must not take the place of one.
void require_no_body(const std::string& output);

}  // namespace mimbre::app
