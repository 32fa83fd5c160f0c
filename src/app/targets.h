#pragma once
#include <string>

#include "app/common.h"

/// What is found out about outputs before a long computation. That one cannot be written is exit code 3, then
/// as later: the library reports that by std::runtime_error.
namespace mimbre::app {

/// Throws std::runtime_error naming the file and the reason where no file can be written at `path`. Leaves
/// nothing behind.
void require_writable(const std::string& path);

/// The same for a reduced body, which needs a plain file.
void require_writable_body(const std::string& path);

/// Throws UsageError when `output` is the file `input` itself, which writing would destroy.
void require_different(const std::string& input, const std::string& output);

/// Throws UsageError when `output` is the model file, or one that was read with it.
void require_not_read(const std::string& model, const LoadedModel& loaded, const std::string& output);

/// Throws UsageError when `output` is a reduced body: results must not take the place of one.
void require_no_body(const std::string& output);

}  // namespace mimbre::app
